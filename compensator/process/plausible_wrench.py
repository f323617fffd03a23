"""Wrenches beyond the usual range: kN for N, N*mm for N*m, the force on the part for that on the robot."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from compensator.process.process import ToolMotion
from toolpaths.finding import NOTE, WARNING, Finding
from toolpaths.toolpath import CUT

Floats = npt.NDArray[np.float64]

FORCE = (1.0, 20e3)  # N; deburring takes 5 to 50, milling with robots up to about 3,000, friction stir welding 15,000
LEVER, MOMENT = 1.0, 100.0  # m from the TCP, N*m: cutters and grinding discs have radii below 0.25 m
SHARE = 0.1  # of the mean force that has to point along the feed, and into the work, to be asked about


def wrench_doubts(motion: ToolMotion, wrench: Floats, place: str) -> Iterator[Finding]:
    """What is unusual about a wrench that the user gives.

    Args:
        wrench: (N, 6) N and N*m on the robot, base axes, about the TCP.
        place: where it is given, for messages.
    """
    cut = motion.toolpath.kind == CUT
    force, moment = (np.linalg.norm(part[cut], axis=1).max(initial=0.0) for part in (wrench[:, :3], wrench[:, 3:]))
    low, high = FORCE
    if 0 < force < low or force > high:
        what = f"the largest force is {force:.3g} N (usual are {low:g} to {high:,.0f} N)"
        yield Finding(WARNING, place, what, "Forces are in N: were these in kN?" if force < low else "Are these N?")
    if not force and not moment:
        yield Finding(NOTE, place, "the wrench is zero at every cut: nothing is predicted that a process does")
    if moment > MOMENT and moment > LEVER * force:
        usual = f" (usual is less than {MOMENT:g} N*m)"
        if force:
            usual = f", that of {force:.3g} N at {moment / force:.3g} m from the TCP (usual is less than {LEVER:g} m)"
        what = f"the largest moment is {moment:.4g} N*m{usual}"
        yield Finding(WARNING, place, what, "Moments are in N*m about the TCP: were these in N*mm?")
    along, into = _shares(motion, wrench[:, :3], cut)
    if along > SHARE and into > SHARE:
        what = (
            f"the force pulls the tool along its feed ({along:.0%} of it, in the mean) and into the work ({into:.0%}); "
            "usual is against at least one of them"
        )
        yield Finding(WARNING, place, what, "The wrench is what the part does to the robot: is the sign turned round?")


def _shares(motion: ToolMotion, force: Floats, cut: npt.NDArray[np.bool_]) -> tuple[float, float]:
    """Mean parts along the move that ends at each cutting pose, and along the TCP's z, of the mean force."""
    origin = motion.tcp.origin
    moved = np.diff(origin, axis=0, prepend=origin[:1])
    if motion.workobject.rotation.ndim > 2:  # rail or table: the way of the tool on the part
        on_part = motion.tcp.relative_to(motion.workobject).origin
        moved = np.diff(on_part, axis=0, prepend=on_part[:1])
        moved = np.einsum("nij,nj->ni", motion.workobject.rotation, moved)
    length = np.linalg.norm(moved, axis=1)
    rows = cut & (length > 1e-9)
    total = float(np.linalg.norm(force[rows], axis=1).sum())
    if not total:
        return 0.0, 0.0
    along = np.sum(force[rows] * moved[rows] / length[rows, None])
    into = np.sum(force[rows] * motion.z[rows])
    return float(along) / total, float(into) / total
