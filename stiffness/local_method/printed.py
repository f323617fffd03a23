"""Printed: the paper's equations as they are printed, for comparison with the right ones. Never used for a model.

Berntsen, Bertheussen, Tyapin, Combined Stiffness Identification of 6-DoF Industrial Robot. Where the print departs:
Eq. 2, 3 and 22 take the norm of a displacement (any noise adds to it), Eq. 4 and 24 print tau = J W, Eq. 22 and 23
take off joint 1 but not joint 4, Eq. 10 and 12 subtract the turn of joints 2 and 3 as if A-B lay along the arm and
one point told both, Eq. 9, 17 and 18 have angles without sign.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.local_method.joint import Angle
from stiffness.local_method.setup import LocalSetup, StateReadings

Floats = npt.NDArray[np.float64]

TAKEN_OFF = {2: (1,), 5: (0,)}  # joints (from 0) that Eq. 3 and Eq. 22 take off


@dataclass(frozen=True)
class Printed:
    """A way that is not right: ``name`` for tables, ``words`` what it does, ``stiffness`` N*m/rad."""

    name: str
    words: str
    stiffness: float


def printed(angle: Angle, stiffness: Floats) -> tuple[Printed, ...]:
    """The printed ways for one loaded state, with the stiffness (n,) of the joints before."""
    k = angle.setup.joint
    if k == 3:
        return (Printed("as printed", "angle between A-B loaded and unloaded, Eq. 5-12", _joint_4(angle)),)
    if k == 4:
        return (Printed("as printed", "difference of two arc cosines, Eq. 13-20", _joint_5(angle)),)
    return (*_norms(angle), *_products(angle, stiffness)) if k in TAKEN_OFF else _norms(angle)


def _norms(angle: Angle) -> tuple[Printed, ...]:
    """Eq. 2 with all else right: of the mean displacement, and of every single one."""
    setup, state = angle.setup, angle.state
    known = ~np.isnan(angle.others)
    off = setup.points["A"].jacobian[:, known] @ angle.others[known]
    lengths = np.linalg.norm(setup.singles(state, "A") - off, axis=1)
    product = angle.balance * abs(angle.reading)
    mean = abs(product / np.linalg.norm(setup.displacement(state, "A") - off))
    return (
        Printed("norm", "norm of the mean displacement instead of its projection", float(mean)),
        Printed("norm of singles", "mean of the norms of single displacements", float(abs(product) / lengths.mean())),
    )


def _products(angle: Angle, stiffness: Floats) -> tuple[Printed, ...]:
    """Joints 3 and 6: tau = J W, only the paper's joints taken off, and all of it as printed."""
    k, a = angle.setup.joint, angle.setup.points["A"]
    paper, right = np.zeros(len(stiffness)), np.nan_to_num(angle.others)
    listed = [j for j in TAKEN_OFF[k] if not np.isnan(stiffness[j])]
    paper[listed] = _j_w(angle.setup, angle.state)[listed] / stiffness[listed]
    wrong, only = right.copy(), np.zeros(len(stiffness))
    wrong[listed], only[listed] = paper[listed], right[listed]
    moved = angle.setup.displacement(angle.state, "A")
    way = a.jacobian[:, k] / angle.reading
    product = angle.balance * angle.reading

    def left(turns: Floats) -> Floats:
        return np.asarray(moved - a.jacobian @ turns)

    found = [Printed("J W", "tau = J W (Eq. 4 and 24) for J^T W", float(product / (way @ left(wrong))))]
    if k == 5:
        without = float(product / (way @ left(only)))
        found.append(Printed("without joint 4", "the turn of joint 4 left in the reading", without))
    literal = float(abs(product) / np.linalg.norm(left(paper)))
    return (*found, Printed("as printed", "J W, norm, and no joint but the paper's taken off", literal))


def _j_w(setup: LocalSetup, state: StateReadings) -> Floats:
    """(n,) J W with the Jacobian of the point that the load acts on; SI numbers, the product has no unit."""
    force, at = state.force, setup.at
    jacobian = at.jacobian(force.link, at.point(force.point_link, force.point))
    change = setup.arm.in_base(at, force) - setup.arm.in_base(at, setup.reference.force)
    return np.asarray(jacobian @ change)


def _means(setup: LocalSetup, state: StateReadings) -> dict[str, Floats]:
    return {p: state.readings[p].mean for p in setup.points}


def _between(a: Floats, b: Floats) -> float:
    """rad, the arc cosine of Eq. 9."""
    return float(np.arccos(np.clip(a @ b / np.linalg.norm(a) / np.linalg.norm(b), -1.0, 1.0)))


def _joint_4(angle: Angle) -> float:
    """Eq. 5-12: K4 = F L14 / atan(|AB| tan(phi - alpha) / R4), alpha = atan(|A - A0| / L24)."""
    setup = angle.setup
    rest, load = _means(setup, setup.reference), _means(setup, angle.state)
    unloaded, loaded = rest["B"] - rest["A"], load["B"] - load["A"]
    lever = np.linalg.norm(setup.points["A"].jacobian[:, 2])  # L24, from axis 3 to A
    alpha = abs(np.arctan(np.linalg.norm(load["A"] - rest["A"]) / lever)) if lever > 0 else 0.0
    turn = np.arctan(np.linalg.norm(unloaded) * np.tan(_between(unloaded, loaded) - alpha) / angle.reading)
    return float(abs(angle.torque) / turn) if turn else float("inf")


def _joint_5(angle: Angle) -> float:
    """Eq. 13-20: K5 = F L15 / (phi_l - phi_u), phi the angle between A-B and B-C."""
    setup = angle.setup
    phi = [
        _between(p["B"] - p["A"], p["C"] - p["B"])
        for p in (_means(setup, angle.state), _means(setup, setup.reference))
    ]
    turn = abs(phi[0] - phi[1])
    return float(abs(angle.torque) / turn) if turn else float("inf")
