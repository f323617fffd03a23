"""Next traces: the measurement that would split what these traces do not tell apart, in words."""

from __future__ import annotations

from collections.abc import Sequence

from stiffness.diagnosis.alternatives import Alternatives
from stiffness.diagnosis.result import MovedParameter
from stiffness.effects import BY_NAME
from stiffness.session.path_trace import PathTrace
from stiffness.session.session import Session


def next_traces(
    sessions: Sequence[Session], found: Sequence[Alternatives], changed: Sequence[MovedParameter], left: bool
) -> list[str]:
    """What to run and measure next; () for sessions of set-ups, and where the traces have told all.

    Args:
        left: whether structure is left that no effect explains.
    """
    paths = [s.path for s in sessions if s.path is not None]
    if not paths:
        return []
    names = {name for own in found for name in (own.addition.effect.name, *own.fits) if own.fits}
    names |= {name for c in changed if c.confused_with for name in (c.effect, *c.confused_with)}
    out = []
    if any(BY_NAME[name].process_wrench for name in names):
        out.append(
            "the same contour at half the depth, and a session or trace with a known load in place of the cut (a "
            "weight on a rope): a softer joint yields to both, a larger cutting force is in the cut alone"
        )
    if any(BY_NAME[name].surface_reading for name in names):
        out.append("a contour with an uneven allowance: a cutter of another size leaves the same whatever the force")
    if any(BY_NAME[name].memory is not None for name in names):
        out.append(_circles(paths, "what depends on torque and what on travel differ there"))
    elif names and not out:
        out.append("the same circle or contour elsewhere in the workspace, and a session of loaded set-ups there")
    if left and len({float(f) for p in paths for f in p.feeds}) < 2:
        out.append("the same program at half the feed: a lag of the servos halves, a gap or friction stays")
    return out


def _circles(paths: Sequence[PathTrace], why: str) -> str:
    x, y, z = (1e3 * paths[0].rows.position.mean(axis=0)).tolist()
    return (
        f"a circle of 150 mm about x {x:.0f}, y {y:.0f}, z {z:.0f} mm in the base, in both directions, dry, and the "
        f"same with a radius of 50 mm and in a second plane: {why}"
    )
