"""CYCLE of APT/CL in values by place, ``CYCLE/DRILL, d, MMPM, f, c``, as ISO 4343, CATIA and Fusion 360 write it.

d is the depth, f the feed, c the height where the tool arrives and leaves; RAPTO,r is how far below c feeding begins.
The GOTO names a point on the surface and c is measured from it; but the stock post of Fusion 360 ('Common ISO 4343
APT', its onCycle and onCyclePoint) names the bottom of the hole, and its c is the place of the clearance plane.
"""

from __future__ import annotations

from toolpaths.languages.apt.feed import FEED_WORDS
from toolpaths.languages.apt.words import LARGEST, AptStatement, number, refusal

_FORM = "d, unit, f, c after the kind, for pecks d, INCR, i, unit, f, c"
_MORE = {"RAPTO", "DWELL", "ORIENT", "ORIANT"}  # what may follow, each with a number
_OUTPUT = "Output the drilling moves as GOTO."


def by_place(s: AptStatement, rest: list[str], source: str) -> dict[str, float] | None:
    """The values as the words that CYCLE has for them: DEPTH, INCR, MMPM and its like, CLEAR, RAPTO, DWELL.

    Args:
        s: the statement.
        rest: what follows the kind of cycle.
        source: the file, in messages.

    Returns:
        None: the values have words.

    Raises:
        ReadError: another order, a number that is missing, a shift (fine boring).
    """
    if not rest or number(rest[0]) is None:
        return None
    step = rest[1:2] == ["INCR"]
    head, more = rest[: 6 if step else 4], rest[6 if step else 4 :]
    unit = head[3 if step else 1] if len(head) == (6 if step else 4) else ""
    numbers = [number(v) for k, v in enumerate(head) if k not in ((1, 3) if step else (1,))]
    if unit not in FEED_WORDS or None in numbers:
        raise refusal(source, s, f"values without words: {_FORM} are read", _OUTPUT)
    names = ("DEPTH", "INCR", unit, "CLEAR") if step else ("DEPTH", unit, "CLEAR")
    if more and number(more[0]) is not None:
        raise refusal(source, s, "a shift sideways before the tool is withdrawn (fine boring)", _OUTPUT)
    given = dict(zip(names, (v for v in numbers if v is not None), strict=True))
    for word, text in zip(more[::2], [*more[1::2], ""], strict=False):
        value = number(text)
        if word not in _MORE or word in given or value is None:
            problem = f"{word[:20]},{text[:20]}: each of {', '.join(sorted(_MORE))} once is read"
            raise refusal(source, s, problem, _OUTPUT)
        given[word] = value
    for word in ("ORIENT", "ORIANT"):
        given.pop(word, None)  # the spindle's place at the bottom: the tool leaves at feed, without a shift
    if not all(-LARGEST < v < LARGEST for v in given.values()):
        raise refusal(source, s, f"numbers below {LARGEST:g} are expected", _OUTPUT)
    return given
