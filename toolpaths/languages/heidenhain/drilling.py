"""Drilling cycles 200, 201, 203, 205 and 240 of Klartext as the moves that the control makes.

Source: HEIDENHAIN cycle programming (iTNC 530, TNC 640): cycle run and parameters of each. Heights count from the
surface Q203; the tool comes to the set-up clearance Q200 and leaves to the second one, Q204, where that is higher.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from toolpaths.reading.track import CUT_MARK, RAPID_MARK

#: Cycle -> parameters that it needs, beside Q200 Q201 Q203 Q206.
NEEDED: dict[int, tuple[int, ...]] = {200: (202,), 201: (), 203: (202,), 205: (202,), 240: ()}
_LENGTHS = (200, 201, 202, 203, 204, 205, 212, 256, 257, 258, 259, 379)
_FEEDS = (206, 208, 253)
_OTHERS = (210, 211, 213, 343, 344, 395)
NEAR = 0.2e-3  # m above the last depth, to which the tool comes back at rapid
MAX = math.inf  # of a feed: rapid
MOST_STROKES = 2000


class KlartextStep(NamedTuple):
    """A move along the tool, or with ``dwell`` a stay: kind, height m, feed m/s, s of the stay."""

    mark: int
    height: float
    feed: float = math.nan
    dwell: float = 0.0


@dataclass(frozen=True)
class KlartextDrilling:
    """A cycle with its Q values: lengths in m, feeds in m/s (MAX: rapid), times in s."""

    number: int
    q: Mapping[int, float]

    def steps(self) -> Iterator[KlartextStep]:
        """The moves of one hole."""
        q = self.q
        clear, bottom = q[203] + q[200], q[203] + q[201]
        yield KlartextStep(RAPID_MARK, clear)
        if q.get(379):
            yield KlartextStep(CUT_MARK, clear - abs(q[379]), q.get(253) or q[206])
        if self.number in (201, 240):
            yield KlartextStep(CUT_MARK, bottom, q[206])
        else:
            yield from self._strokes(clear)
        if q.get(211):
            yield KlartextStep(CUT_MARK, bottom, dwell=q[211])
        if self.number in (201, 203):
            yield self._out(clear)
        yield KlartextStep(RAPID_MARK, max(clear, q[203] + q.get(204, 0.0)))

    def _out(self, height: float) -> KlartextStep:
        """Out of the hole, at Q208 where the cycle has it."""
        feed = self.q.get(208, 0.0) or self.q[206]
        return KlartextStep(RAPID_MARK, height) if feed == MAX else KlartextStep(CUT_MARK, height, feed)

    def _strokes(self, clear: float) -> Iterator[KlartextStep]:
        q, depth = self.q, -self.q[201]
        reached = abs(q.get(379, 0.0))
        breaks = int(q.get(213, 0.0)) if self.number == 203 else 0
        since = 0
        for count, stroke in enumerate(self._depths(depth - reached)):
            if count and breaks and since < breaks:
                yield KlartextStep(CUT_MARK, q[203] - reached + q.get(256, 0.0), q[206])
                since += 1
            elif count:
                yield self._out(clear) if self.number == 203 else KlartextStep(RAPID_MARK, clear)
                if q.get(210):
                    yield KlartextStep(CUT_MARK, clear, dwell=q[210])
                yield KlartextStep(RAPID_MARK, min(q[203] - reached + self._near(reached / depth), clear))
                since = 0
            if self.number == 205 and q.get(257):
                yield from self._broken(reached, stroke)
            reached += stroke
            end = q[203] + q[201] if depth - reached < 1e-9 else q[203] - reached
            yield KlartextStep(CUT_MARK, end, q[206])

    def _near(self, share: float) -> float:
        """How far above the last depth feeding begins again; cycle 205 goes from Q258 to Q259 evenly."""
        first = self.q.get(258, 0.0)
        if self.number != 205 or not first:
            return NEAR
        return first + share * ((self.q.get(259) or first) - first)

    def _broken(self, reached: float, stroke: float) -> Iterator[KlartextStep]:
        """Cycle 205 breaks the chip inside a stroke, every Q257."""
        step, q = self.q[257], self.q
        for k in range(1, math.ceil(stroke / step - 1e-9)):
            yield KlartextStep(CUT_MARK, q[203] - reached - k * step, q[206])
            yield KlartextStep(CUT_MARK, q[203] - reached - k * step + q.get(256, 0.0), q[206])

    def _depths(self, depth: float) -> list[float]:
        """How deep each stroke goes, m."""
        q, out, left, stroke = self.q, [], depth, self.q[202]
        less = q.get(212, 0.0) if self.number != 200 else 0.0
        while left > 1e-9:
            out.append(min(stroke, left))
            left -= out[-1]
            if less:
                stroke = max(stroke - less, q.get(205, 0.0) or less)
            if len(out) > MOST_STROKES:
                raise ValueError(
                    f"cycle {self.number} makes more than {MOST_STROKES} strokes", "Check Q202, Q205, Q212."
                )
        return out


def drilling(number: int, q: Mapping[int, float], unit: float, feed_unit: float) -> KlartextDrilling:
    """A drilling cycle as it is defined.

    Args:
        number: of the cycle.
        q: parameter -> value as written; MAX for a feed of that name.
        unit: m of a length.
        feed_unit: m of the length in a feed.

    Raises:
        ValueError: a value is missing, makes no sense, or is not read.
    """
    name = f"CYCL DEF {number}"
    if missing := [f"Q{p}" for p in (200, 201, 203, 206, *NEEDED[number]) if p not in q]:
        raise ValueError(f"{name} without {', '.join(missing)}")
    if strange := [f"Q{p}" for p in q if p not in (*_LENGTHS, *_FEEDS, *_OTHERS)]:
        raise ValueError(f"{name} with {', '.join(strange)}: this reader does not know what it means")
    out = {p: v * unit if p in _LENGTHS else v for p, v in q.items() if p not in _FEEDS}
    out |= {p: q[p] if q[p] == MAX else q[p] * feed_unit / 60.0 for p in _FEEDS if p in q}
    if not out[201] < 0:
        raise ValueError(f"{name} with a depth Q201 of {q[201]:g}: below 0 is expected")
    if not 0 < out[206] < MAX or any(out.get(p, 0.0) < 0 for p in _FEEDS):
        raise ValueError(f"{name}: feeds above 0 are expected, and Q206 is no rapid")
    if 202 in NEEDED[number] and not out[202] > 0:
        raise ValueError(f"{name} with an infeed Q202 of {q[202]:g}: above 0 is expected")
    if bad := [p for p in (200, 204, 205, 212, 213, 256, 257, 258, 259, 210, 211) if out.get(p, 0.0) < 0]:
        raise ValueError(f"{name} with Q{bad[0]}={q[bad[0]]:g}: 0 or more is expected")
    if out.get(395) or out.get(343):
        raise ValueError(
            f"{name}: its depth depends on the point of the tool (Q395 or Q343)", "Post the depth of the tip."
        )
    if out.get(257) and -out[201] / out[257] > MOST_STROKES:
        raise ValueError(f"{name} breaks the chip more than {MOST_STROKES} times", "Check Q257.")
    return KlartextDrilling(number, out)
