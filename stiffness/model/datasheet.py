"""A first model of an arm from the data sheets of its reducers, with the wide standard deviations that it has.

A reducer alone is stiffer than its joint, which has bearings, links and a servo loop in series. How much is
known only roughly: K_joint / K_reducer is taken as anything from SOFTEST to 1, every octave as likely as
another. Mean and standard deviation of that (log-uniform) distribution make the model.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stiffness.effects import backlash, joint_hardening, joint_stiffness
from stiffness.errors import RobotError
from stiffness.model.model import ComplianceModel
from stiffness.robot.reducer import ARCMIN, Reducer
from stiffness.robot.robot import Robot

Floats = npt.NDArray[np.float64]

# A reducer of 67 N*m/arcmin (4020 N*m/deg) and the six joints of the same arm as its measurement found them, 505 to
# 1220 N*m/deg, make 0.13 to 0.30 (docs/datasheet.md)
SOFTEST = 0.1
_UNKNOWN_GAP = 1.0 * ARCMIN  # the largest that makers give (docs/datasheet.md), for a sheet without a figure


def share() -> tuple[float, float]:
    """Mean and standard deviation of K_joint / K_reducer."""
    width = np.log(1 / SOFTEST)
    mean = (1 - SOFTEST) / width
    square = (1 - SOFTEST**2) / (2 * width)
    return float(mean), float(np.sqrt(square - mean**2))


def gap(reducer: Reducer) -> tuple[float, float] | None:
    """Gap and its standard deviation, rad; None where the sheet has neither figure.

    Backlash (loop width at zero torque, friction in it) and lost motion less its elastic part are both upper
    bounds: the gap is half the smaller of the two, with half the smaller figure as standard deviation.
    """
    bounds, stated = [], []
    if reducer.backlash is not None:
        bounds.append(reducer.backlash)
        stated.append(reducer.backlash)
    if reducer.lost_motion is not None:
        elastic = 2 * reducer.windup(reducer.lost_motion_torque or 0.0)
        bounds.append(max(reducer.lost_motion - elastic, 0.0))
        stated.append(reducer.lost_motion)
    if not bounds:
        return None
    return min(bounds) / 2, min(stated) / 2


def datasheet_model(robot: Robot, named: str) -> ComplianceModel:
    """A starting model.

    Args:
        named: the robot as the model file shall name it.

    Raises:
        RobotError: names the joints without reducer data.
    """
    reducers = _complete(robot)
    mean, spread = share()
    rigidity = np.array([r.rigidity[-1] for r in reducers])
    base, soft, play = (module.EFFECT.name for module in (joint_stiffness, joint_hardening, backlash))
    values = {base: joint_stiffness.values_of(mean * rigidity)}
    sd = {base: joint_stiffness.values_of(spread * rigidity)}
    if any(len(r.rigidity) > 1 for r in reducers):
        values[soft], sd[soft] = _hardening(reducers)
    gaps = [gap(r) for r in reducers]
    if any(gaps):
        known = [g or (0.0, _UNKNOWN_GAP) for g in gaps]
        values[play] = backlash.values_of(np.array([g for g, _ in known]))
        sd[play] = {"gap_rad": np.array([s for _, s in known])}
    return ComplianceModel(
        source="",
        robot=named,
        gravity="uncompensated",
        reference_temperature=20.0,
        base=robot.base,
        tip=robot.tip,
        values=values,
        sd=sd,
        provenance=_provenance(robot, reducers, [k + 1 for k, g in enumerate(gaps) if g is None]),
    )


def _complete(robot: Robot) -> list[Reducer]:
    given = robot.reducers or (None,) * robot.n
    missing = [name for name, r in zip(robot.joint_names, given, strict=True) if r is None]
    if missing:
        raise RobotError(
            f"robot {robot.name}: no reducer data for {', '.join(missing)}: give each a [joints.reducer] table in the "
            "robot file, with rigidity_nm_per_arcmin and source (docs/datasheet.md)"
        )
    return [r for r in given if r is not None]


def _hardening(reducers: list[Reducer]) -> tuple[dict[str, Floats], dict[str, Floats]]:
    """A sheet with one piece gives no wind-up: it is zero, with the effect's typical size as standard deviation."""
    each = [joint_hardening.values_of_pieces(r.rigidity, r.breaks) for r in reducers]
    values = {name: np.array([v[name] for v in each]) for name in each[0]}
    typical = {p.name: p.start for p in joint_hardening.EFFECT.parameters}
    halves = {name: values[name] / 2 for name in ("windup_rad", "knee_nm", "further_rad")}
    halves["windup_rad"] = np.where(values["windup_rad"] == 0, typical["windup_rad"], halves["windup_rad"])
    return values, halves


def _provenance(robot: Robot, reducers: list[Reducer], without_gap: list[int]) -> dict[str, object]:
    mean, spread = share()
    text: dict[str, object] = {
        "kind": "assumption",
        "method": "data sheet",
        "source": f"reducer data of {robot.name}: " + "; ".join(dict.fromkeys(r.source for r in reducers)),
        "standard_deviations": f"joint stiffness {mean:.2f} +- {spread:.2f} of the reducer's: a joint is taken as "
        f"{SOFTEST:g} to 1 times its reducer, log-uniform",
        "load_range": "not measured",
        "preload_side": "not measured",
        "temperature": "not given",
    }
    if without_gap:
        text["gap_not_given"] = [f"joint-{k}" for k in without_gap]
    return text
