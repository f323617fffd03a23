"""What a choice of axes is told in: use of each axis, and findings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from compensator.axes.axis_trial import FollowedAxes
from compensator.axes.free_axes import FreeAxes
from compensator.path.chosen_axes import AxisUse
from compensator.path.chosen_turn import TurnValue
from toolpaths.finding import NOTE, WARNING, Finding
from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]

AT_END = 1e-3  # of the range: as near to its end is at it


def axis_uses(free: FreeAxes, toolpath: Toolpath, places: Floats) -> tuple[AxisUse, ...]:
    """What a path asks of every axis; ``places`` (N, A)."""
    lasts = np.diff(free.time(toolpath))
    out = []
    for k, name in enumerate(free.names):
        way = np.abs(np.diff(places[:, k]))
        rates = np.divide(way, lasts, out=np.zeros_like(way), where=lasts > 0)
        rail = bool(free.rail[k])
        out.append(AxisUse(
            name=name, unit="mm" if rail else "deg", carries="robot" if rail else "part",
            range=(float(free.low[k]), float(free.high[k])),
            least=float(places[:, k].min()), greatest=float(places[:, k].max()), travel=float(way.sum()),
            fastest=float(rates.max(initial=0.0)),
            limits=(float(free.speed[k]), float(free.acceleration[k])) if free.moving[k] else None,
        ))  # fmt: skip
    return tuple(out)


def choice_findings(
    free: FreeAxes, uses: tuple[AxisUse, ...], taken: FollowedAxes, *, fixed: FollowedAxes | None, said: Sequence[str]
) -> Iterator[Finding]:
    """What was chosen, what it was worth, and what is to be known about it."""
    source = taken.path.toolpath.source
    yield from free.assumptions()
    moved = [use for use in uses if use.moves]
    if not moved:
        yield Finding(NOTE, source, f"{free.told(taken.places[0])} for the whole path: {_worth(taken.value)}")
    else:
        spans = [f"{u.name} moves between {u.least:.1f} and {u.greatest:.1f} {u.unit}" for u in moved]
        ways = "; ".join(f"{span}, {u.travel:.0f} {u.unit} in all" for span, u in zip(spans, moved, strict=True))
        if fixed is None:
            yield Finding(NOTE, source, f"no fixed place serves the whole path: {ways}: {_worth(taken.value)}")
        else:
            before = f"{free.told(fixed.places[0])} all along would be {_worth(fixed.value)}"
            yield Finding(NOTE, source, f"{ways}: {_worth(taken.value)}; {before}")
    for use in uses:
        room = AT_END * (use.range[1] - use.range[0])
        ends = [e for e, v in ((use.range[0], use.least), (use.range[1], use.greatest)) if abs(v - e) <= room]
        if ends:
            what = f"{use.name} stands at the end of its range, {ends[0]:g} {use.unit}"
            yield Finding(NOTE, source, what, "If it can go further, a wider range may serve better")
    if taken.windows[1]:
        failed, windows = taken.windows[1], taken.windows[0]
        kind = "rail" if free.rail[free.moving].any() else "table"
        what = f"{failed} of {windows} windows of the {kind}'s refinement failed: there it stays as it began"
        yield Finding(WARNING, source, what, "The result is sound, and may be worse than it could be")
    for what in said:
        yield Finding(NOTE, source, f"{what}: it was left out")


def _worth(value: TurnValue) -> str:
    return (
        f"mean standard deviation of the deflection {value.sd * 1e6:.1f} um, {value.reversals:.0f} joint reversals in "
        f"the cut, cost {value.cost * 1e12:.0f} um2"
    )
