"""How a G-code file is written: its words with their places in a line, and numbers in the file's own manner."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from itertools import islice
from typing import NamedTuple

from toolpaths.languages.gcode.codes import MOTIONS, RETURNS
from toolpaths.languages.gcode.words import COMMENT
from toolpaths.rewriting.edits import Edit, edited

WORD = re.compile(r"([A-Za-z])(\s*)([-+]?(?:\d+\.?\d*|\.\d+))")
ORDER = "XYZIJKF"
LEAST_DIGITS = {False: 3, True: 5}  # decimals in mm, in inch: what loses less than 1 um
VECTOR_DIGITS = 7
SAMPLE = 20_000  # lines that show the manner of a file


class GcodeWord(NamedTuple):
    """One word of a line: letter in upper case, number as it stands there, and its place."""

    letter: str
    number: str
    start: int
    end: int

    @property
    def value(self) -> float:
        """The number."""
        return float(self.number)

    @property
    def key(self) -> int:
        """Ten times the number, as G words have it."""
        return int(float(self.number) * 10 + 0.5)

    @property
    def is_motion(self) -> bool:
        """G0 to G3 or a canned cycle."""
        return self.letter == "G" and self.key in MOTIONS

    @property
    def is_return(self) -> bool:
        """G98, G99."""
        return self.letter == "G" and self.key in RETURNS


def words_of(line: str) -> list[GcodeWord]:
    """The words of a line outside comments."""
    bare = COMMENT.sub(lambda m: " " * len(m[0]), line) if "(" in line or ";" in line else line
    return [GcodeWord(m[1].upper(), m[3], m.start(), m.end()) for m in WORD.finditer(bare)]


@dataclass(frozen=True)
class GcodeSpelling:
    """The manner of one file.

    Attributes:
        digits: most decimals of X, Y, Z in the file.
        fixed: every number with decimals has that many.
        point: whole numbers end in a point.
        bare: no zero in front of the point.
        gap: what stands between words.
        lower: letters are small.
        padded: G01, not G1.
    """

    digits: int
    fixed: bool
    point: bool
    bare: bool
    gap: str
    lower: bool
    padded: bool

    def number(self, value: float, inch: bool, digits: int | None = None) -> str:
        """A number of this file; never coarser than 1 um."""
        places = max(self.digits, LEAST_DIGITS[inch]) if digits is None else digits
        text = f"{value:.{places}f}"
        if not (self.fixed and digits is None):
            text = text.rstrip("0")
            text = text if not text.endswith(".") or self.point else text[:-1]
        if float(text) == 0.0:
            text = text.lstrip("-")
        if self.bare and "." in text:
            text = re.sub(r"^(-?)0\.(?=\d)", r"\1.", text)
        return text

    def word(self, letter: str, number: str) -> str:
        """A word of this file."""
        if letter == "G" and self.padded and len(number) == 1:
            number = "0" + number
        return (letter.lower() if self.lower else letter) + number


def spelling_of(lines: Iterable[str]) -> GcodeSpelling:
    """The manner that most words of the file have."""
    places: Counter[int] = Counter()
    counts: Counter[str] = Counter()
    for line in islice(lines, SAMPLE):
        end = -1
        for m in WORD.finditer(COMMENT.sub("", line)):
            counts["lower" if m[1].islower() else "upper"] += 1
            if end >= 0:
                counts["joined" if m.start() == end else "apart"] += 1
            end = m.end()
            if m[1] in "XYZxyz":
                whole, _, part = m[3].partition(".")
                places[len(part)] += 1
                counts["point"] += m[3].endswith(".")
                counts["plain"] += "." not in m[3]
                counts["bare"] += whole in ("", "-", "+")
                counts["zero"] += whole in ("0", "-0") and part != ""
            elif m[1] in "Gg" and m[3] in ("0", "1", "2", "3", "00", "01", "02", "03"):
                counts["padded" if len(m[3]) == 2 else "short"] += 1
    return GcodeSpelling(
        digits=min(max(places, default=3), 6),
        fixed=len(places.keys() - {0}) == 1,
        point=counts["point"] > counts["plain"],
        bare=counts["bare"] > counts["zero"],
        gap="" if counts["joined"] > counts["apart"] else " ",
        lower=counts["lower"] > counts["upper"],
        padded=counts["padded"] > counts["short"],
    )


def with_words(
    line: str,
    spelling: GcodeSpelling,
    new: Mapping[str, str],
    *,
    drop: Collection[str] = (),
    motion: str = "",
    words: list[GcodeWord] | None = None,
) -> str:
    """The line with numbers replaced, words added in the order X Y Z I J K F, words dropped, the motion word changed.

    Args:
        line: without its end.
        spelling: how added words look.
        new: letter -> number.
        drop: letters that go; G stands for G98 and G99.
        motion: number of the G word that is put in; the motion word of the line goes, if it has one.
        words: of the line, where they are known.
    """
    words = words_of(line) if words is None else words
    gone = [w for w in words if (w.letter in drop and w.letter != "G") or ("G" in drop and w.is_return)] if drop else []
    kept = [w for w in words if w not in gone] if gone else words
    edits = []
    for w in gone:
        start = w.start
        while start > 0 and line[start - 1] in " \t":
            start -= 1
        edits.append(Edit(start, w.end, ""))
    old = next((w for w in kept if w.is_motion), None)
    if motion and old is not None:
        edits.append(Edit(old.end - len(old.number), old.end, spelling.word("G", motion)[1:]))
    edits += [Edit(w.end - len(w.number), w.end, new[w.letter]) for w in kept if w.letter in new]
    present = {w.letter for w in kept}
    added = [("G", motion)] if motion and old is None else []
    added += [(c, new[c]) for c in ORDER if c in new and c not in present]
    put_in = [_added(kept, letter, spelling.word(letter, number), spelling.gap) for letter, number in added]
    return edited(line, put_in + edits)


def _added(words: list[GcodeWord], letter: str, text: str, gap: str) -> Edit:
    """Where a word is put in: behind the words that come before it in the usual order."""
    order = "NG" + ORDER
    rank = order.index(letter)
    behind = [w for w in words if w.letter in order and order.index(w.letter) <= rank]
    if behind:
        return Edit(behind[-1].end, behind[-1].end, gap + text)
    start = words[0].start if words else 0
    return Edit(start, start, text + (gap if words else ""))
