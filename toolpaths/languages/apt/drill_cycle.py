"""CYCLE of APT/CL and NX CLSF: drilling cycles as the moves that a control makes of them.

A GOTO in a cycle names a point on the surface; all heights are measured from it along the tool axis. FEDTO is a
depth (ISO 4343, SolidWorks CAM), but in CLSF a height, negative below the point (mom_cycle_feed_to of NX posts).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from toolpaths.frame import Vector
from toolpaths.languages.apt.cycle_values import by_place
from toolpaths.languages.apt.feed import FEED_WORDS, AptFeeds, FeedRate
from toolpaths.languages.apt.words import LARGEST, AptStatement, number, refusal

KINDS = {"DRILL": "DRILL", "CSINK": "DRILL", "FACE": "DRILL", "DEEP": "DEEP", "DEEP2": "DEEP", "BRKCHP": "BRKCHP"} | {
    "BORE": "BORE",
    "REAM": "BORE",
}
_VARIANTS = {"DEEP", "BRKCHP"}  # after DRILL, as NX writes it
_TAP = "tapping: the spindle has to turn with the feed, which no robot program written here can do"
_NOT_READ = {"TAP": _TAP, "RTAP": _TAP, "MILL": "a milling cycle; output the moves as GOTO"}
_DEPTH, _CLEAR, _RETRACT = ("FEDTO", "DEPTH"), ("RAPTO", "CLEAR"), ("RTRCTO", "RETURN")
_KEYS = {*_DEPTH, *_CLEAR, *_RETRACT, "STEP", "INCR", "1STPECK", "SUBPECK", "DWELL", *FEED_WORDS}
MOST_PECKS = 200
BACK = 0.1  # share of a peck: how far above the last depth feeding begins again, and how far a chip break backs off
SAME = 1e-9  # file units; nearer than this a move goes nowhere
ROUNDING = 2e-3  # file units, by which heights of one file may contradict each other


class DrillCycle(NamedTuple):
    """One drilling cycle; heights in file units along the tool axis, from the point of the GOTO.

    Attributes:
        kind: DRILL, DEEP (out of the hole after each peck), BRKCHP (back a little) or BORE (out at feed).
        bottom: height fed to.
        clear: height where feeding begins.
        retract: height left at; None: ``clear``; infinite: as high as the tool was before the cycle.
        pecks: first peck and the others, both counted from ``clear``; None: in one go.
        dwell: of DWELL, as DELAY has it; empty for none.
        rate: feed, None: the one in force.
        depth: of a GOTO at the bottom of the hole (Fusion 360), with heights along the tool axis; else None.
    """

    kind: str
    bottom: float
    clear: float
    retract: float | None
    pecks: tuple[float, float] | None
    dwell: str
    rate: FeedRate | None
    depth: float | None = None


class DrillMove(NamedTuple):
    """One move of an expanded cycle."""

    end: Vector
    rapid: bool
    bottom: bool = False


def cycle(s: AptStatement, feeds: AptFeeds, *, nx: bool, bottoms: bool = False) -> DrillCycle:
    """Read CYCLE/kind,...

    Args:
        s: the statement.
        feeds: feed and units in force.
        nx: a CLSF file.
        bottoms: GOTO names the bottoms of holes, as Fusion 360 has it where values have no words.

    Raises:
        ReadError: a kind or word that is not read, a height that is missing, or heights that do not fit.
    """
    kind, rest = _kind(s, feeds.source)
    placed = by_place(s, rest, feeds.source)
    given = _pairs(s, rest, feeds) if placed is None else placed
    depth, clear, retract = _one(given, _DEPTH), _one(given, _CLEAR), _one(given, _RETRACT)
    if depth is None or clear is None:
        raise refusal(feeds.source, s, "FEDTO (or DEPTH) and RAPTO (or CLEAR) are expected", "Name both heights.")
    bottom = depth if nx and "FEDTO" in given else -depth
    if bottom > 0.0:
        sign = "above 0 lies above the point in CLSF" if nx else "below 0 lies above the point"
        raise refusal(feeds.source, s, f"a depth {sign}")
    if "CLEAR" in given and "RAPTO" in given:  # ISO 4343, Creo: further on from CLEAR, in rapid
        clear, retract = given["CLEAR"] - given["RAPTO"], max(given["CLEAR"], retract or 0.0)
    at_bottom = bottoms and placed is not None
    if clear < bottom and not at_bottom:
        raise refusal(feeds.source, s, "RAPTO lies below the bottom of the hole")
    found = DrillCycle(
        kind=kind,
        bottom=0.0 if at_bottom else bottom,
        clear=clear,
        retract=retract,
        pecks=_pecks(s, given, feeds.source),
        dwell="",
        rate=None,
        depth=depth if at_bottom else None,
    )
    found = found._replace(rate=_rate(s, given, feeds), dwell=_dwell(s, given, rest, feeds.source))
    if not at_bottom:
        refuse_many(s, found, feeds.source)
    return found


def _rate(s: AptStatement, given: dict[str, float], feeds: AptFeeds) -> FeedRate | None:
    word = next((w for w in FEED_WORDS if w in given), None)
    return feeds.rate_of(s, given[word], word) if word else None


def _dwell(s: AptStatement, given: dict[str, float], rest: list[str], source: str) -> str:
    stay = given.get("DWELL", 0.0)
    if stay < 0.0:
        raise refusal(source, s, "a dwell of 0 or more is expected")
    unit = "REV," if "REV" in rest else ""
    return f"{unit}{stay:g}" if stay > 0.0 else ""


def at_hole(s: AptStatement, c: DrillCycle, point: Vector, axis: Vector, source: str) -> DrillCycle:
    """The cycle with heights measured from this point, where they are places along the tool axis.

    Raises:
        ReadError: the tool would feed from below the top of the hole.
    """
    if c.depth is None:
        return c
    height = sum(p * n for p, n in zip(point, axis, strict=True))
    clear, retract = c.clear - height, None if c.retract is None else c.retract - height
    if clear < c.depth - ROUNDING:
        problem = f"feeding begins {clear:g} above the bottom of the hole, which is {c.depth:g} deep"
        raise refusal(source, s, problem, "In files of Fusion 360 the GOTO of a cycle is the bottom of the hole.")
    found = c._replace(clear=clear, retract=retract)
    refuse_many(s, found, source)
    return found


def refuse_many(s: AptStatement, c: DrillCycle, source: str) -> None:
    """Refuse a cycle of too many pecks."""
    if len(_depths(c)) > MOST_PECKS:
        raise refusal(source, s, f"more than {MOST_PECKS} pecks a hole", "Check the step.")


def _kind(s: AptStatement, source: str) -> tuple[str, list[str]]:
    minor = s.minor
    word = minor[0] if minor else ""
    if word not in KINDS:
        problem = _NOT_READ.get(word, f"read are {', '.join(KINDS)} and OFF")
        raise refusal(source, s, problem, "Output the drilling moves as GOTO.")
    if word == "DRILL" and len(minor) > 1 and minor[1] in _VARIANTS:
        return KINDS[minor[1]], minor[2:]
    return KINDS[word], minor[1:]


def _pairs(s: AptStatement, rest: list[str], feeds: AptFeeds) -> dict[str, float]:
    """Word and number, word and number; RTRCTO may have AUTO (infinite) or a number and MANUAL."""
    given: dict[str, float] = {}
    words = iter(rest)
    for key in words:
        if key == "MANUAL" and "RTRCTO" in given:
            continue
        if key == "AUTO" and "RTRCTO" not in given:  # NX leaves RTRCTO itself out at times
            given["RTRCTO"] = math.inf
            continue
        text = next(words, "")
        if key == "DWELL" and text == "REV":
            text = next(words, "")
        value = number(text)
        if key == "RTRCTO" and text == "AUTO":
            given.setdefault(key, math.inf)
            continue
        if key not in _KEYS or key in given or value is None or not -LARGEST < value < LARGEST:
            problem = f"{key[:20]},{text[:20]}: each of {', '.join(sorted(_KEYS))} once, with a number, is read"
            raise refusal(feeds.source, s, problem, "Output the drilling moves as GOTO.")
        given[key] = value
    groups = [g for g in _GROUPS if g is not _CLEAR or "DEPTH" not in given]  # Creo has CLEAR and RAPTO
    if sum(word in given for word in FEED_WORDS) > 1 or any(sum(w in given for w in g) > 1 for g in groups):
        raise refusal(feeds.source, s, "two words for the same thing")
    return given


_GROUPS = (_DEPTH, _CLEAR, _RETRACT, ("STEP", "INCR", "1STPECK"))


def _one(given: dict[str, float], words: tuple[str, ...]) -> float | None:
    return next((given[w] for w in words if w in given), None)


def _pecks(s: AptStatement, given: dict[str, float], source: str) -> tuple[float, float] | None:
    first = _one(given, ("STEP", "INCR", "1STPECK"))
    then = given.get("SUBPECK", first)
    if first is None and then is None:
        return None
    if first is None or then is None or not (first > 0.0 and then > 0.0):
        raise refusal(source, s, "a step above 0 is expected")
    return first, then


def _depths(c: DrillCycle) -> list[float]:
    """Heights of the bottoms of the pecks, the last one the bottom of the hole."""
    if c.pecks is None or c.kind not in ("DEEP", "BRKCHP"):
        return [c.bottom]
    first, then = c.pecks
    left = c.clear - c.bottom - first
    if left > MOST_PECKS * then:
        return [c.bottom] * (MOST_PECKS + 1)
    count = max(math.ceil(left / then - 1e-9), 0)
    return [c.clear - first - k * then for k in range(count)] + [c.bottom]


def hole(c: DrillCycle, point: Vector, axis: Vector, at: Vector | None, before: Vector | None) -> Iterator[DrillMove]:
    """The moves for one hole.

    Args:
        c: the cycle in force.
        point: of the GOTO; axis: unit tool axis there.
        at: where the tool is, None where that is not known or its axis is another one.
        before: where it was when the cycle began, None where that is not known.
    """

    def height(p: Vector) -> float:
        return sum((a - b) * n for a, b, n in zip(p, point, axis, strict=True))

    def over(h: float, base: Vector = point) -> Vector:
        return base[0] + h * axis[0], base[1] + h * axis[1], base[2] + h * axis[2]

    up = c.clear if c.retract is None else max(c.clear, c.retract)
    if up == math.inf:
        up = c.clear if before is None else max(c.clear, height(before))
    level = up
    if at is not None:
        h = height(at)
        if h < up:
            yield DrillMove(over(up - h, at), True)
        level = max(up, h)
    yield DrillMove(over(level), True)
    yield DrillMove(over(c.clear), True)
    for h, rapid, bottom in _plunge(c):
        yield DrillMove(over(h), rapid, bottom)
    yield DrillMove(over(up), True)


def _plunge(c: DrillCycle) -> Iterator[tuple[float, bool, bool]]:
    """Heights from ``clear`` into the hole and, when they are no mere rapid, out of it: height, rapid, bottom."""
    depths = _depths(c)
    for last, h in zip([c.clear, *depths], depths, strict=False):
        back = BACK * (c.pecks[1] if c.pecks else 0.0)
        if last != c.clear:
            if c.kind == "DEEP":
                yield c.clear, True, False
            yield min(last + back, c.clear), True, False
        yield h, False, h == depths[-1]
    if c.kind == "BORE":
        yield c.clear, False, False
