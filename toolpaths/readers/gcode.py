"""G-code (RS-274) as Fusion 360 posts it for three-axis milling: G0 to G3, modal words, one work offset."""

from __future__ import annotations

import math
import re
from pathlib import Path

from toolpaths.errors import ReadError
from toolpaths.readers.gcode_arc import arc_geometry
from toolpaths.readers.gcode_words import GROUP, M_END, Words, split_block, strip_comments
from toolpaths.readers.text import comment_word, load_lines
from toolpaths.readers.track import CUT_MARK, RAPID_MARK, Track
from toolpaths.toolpath import Toolpath

MM, INCH = 1e-3, 25.4e-3
MOTIONS = {0: "G0", 10: "G1", 20: "G2", 30: "G3"}
PLANES = {170: 2, 180: 1, 190: 0}  # index of the axis normal to the plane
MOVING = frozenset("XYZIJKR")
ALLOWED = frozenset("XYZIJKRFSTNHPQO")
TOOL_CHANGE = re.compile(r"[Mm]\s*0*6(?![0-9.])")


def read(path: Path, source: str, chord: float) -> Toolpath:
    """Poses of a G-code file in its work offset; the tool axis is (0, 0, 1)."""
    return _Machine(source).run(load_lines(path, source)).toolpath(chord)


class _Machine:
    """Modal state while the blocks of one file are read. Positions in m, nan where not known yet."""

    def __init__(self, source: str) -> None:
        self.source = source
        self.track = Track(source, "gcode")
        self.at = (math.nan, math.nan, math.nan)
        self.motion: int | None = None
        self.normal = 2
        self.unit: float | None = None
        self.relative = False
        self.feed: float | None = None  # as written
        self.tool = self.selected = 0
        self.changes = False  # does an M6 stand in the file? then T only selects
        self.spindle = False
        self.percent = self.ended = False
        self.retracts: list[tuple[int, int, str]] = []  # moves before it, line, words

    def run(self, lines: list[str]) -> Track:
        """Read every block."""
        self.changes = any(TOOL_CHANGE.search(strip_comments(s)[0]) for s in lines if TOOL_CHANGE.search(s))
        for line, text in enumerate(lines, 1):
            if text and not text.isspace():
                self._line(text, line)
        self._check_end(lines)
        self._check_retracts()
        return self.track

    def _line(self, text: str, line: int) -> None:
        if "(" in text or ";" in text:
            text, comments = strip_comments(text)
            for comment in comments:
                self.track.event(comment_word(comment), line)
        if text.strip() == "%":
            self._percent(line)
            return
        values, gs, ms = split_block(text.upper(), self.source, line)
        if not (values or gs or ms):
            return
        if self.ended:
            problem = "words after the end of the program"
            raise self._error(line, problem, "Two programs in one file? Give one file each.")
        self._block(values, gs, ms, line)

    def _percent(self, line: int) -> None:
        if self.percent or self.ended:
            self.ended = True
        elif len(self.track) or self.unit:
            raise self._error(line, "'%' in the middle of the program", "Is the head of the file missing?")
        self.percent = True

    def _block(self, values: Words, gs: list[int], ms: list[int], line: int) -> None:
        for letter in values:
            if letter not in ALLOWED:
                raise self._error(line, f"{letter}{values[letter]:g}: this reader does not know it")
        if gs:
            self._check_groups(gs, line)
        if "F" in values:
            self.feed = values["F"]
        self._events(values, ms, line)
        single = self._modes(gs, values) if gs else None
        self._check_letters(values, gs, single, line)
        if single == 40:
            self.track.event(f"G4 P{values.get('P', 0):g}", line)
        elif single is not None:
            self._retract(single, values, line)
        elif not MOVING.isdisjoint(values):
            self._move(values, line)
        if any(m in M_END for m in ms):
            self.track.event("M30" if 30 in ms else "M2", line)
            self.ended = True

    def _check_groups(self, gs: list[int], line: int) -> None:
        names = [GROUP[g] for g in gs]
        for name in names:
            if names.count(name) > 1:
                words = " ".join(f"G{g / 10:g}" for g in gs if GROUP[g] == name)
                raise self._error(line, f"{words}: two words for {name} in one block")

    def _modes(self, gs: list[int], values: Words) -> int | None:
        """Take over the modal words; the non-modal one is returned."""
        single = None
        for g in gs:
            if g in MOTIONS or g == 800:
                self.motion = None if g == 800 else g
            elif g in PLANES:
                self.normal = PLANES[g]
            elif g in (200, 210):
                self._units(INCH if g == 200 else MM, values)
            elif g in (900, 910):
                self.relative = g == 910
            elif g in (40, 280, 300, 530):
                single = g
        return single

    def _units(self, unit: float, values: Words) -> None:
        if self.unit not in (None, unit) and "F" not in values:
            self.feed = None  # controllers differ in what an F from before a change of units means
        self.unit = unit

    def _check_letters(self, values: Words, gs: list[int], single: int | None, line: int) -> None:
        """Letters that mean something only beside another word."""
        if "H" in values and 430 not in gs:
            raise self._error(line, f"H{values['H']:g} without G43")
        if "P" in values and single != 40 and 640 not in gs:
            raise self._error(line, f"P{values['P']:g}: read only with G4 and G64")
        if "Q" in values and 640 not in gs:
            raise self._error(line, f"Q{values['Q']:g}: read only with G64")
        if "O" in values and (len(self.track) or self.unit):
            raise self._error(line, f"O{values['O']:g}: a second program", "Give one file each.")

    def _events(self, values: Words, ms: list[int], line: int) -> None:
        words = []
        if "O" in values:
            words.append(f"O{values['O']:g}")
        if "T" in values:
            self.selected = self._tool_number(values["T"], line)
            words.append(f"T{self.selected}")
            if not self.changes:
                self.tool = self.selected
        if "S" in values:
            words.append(f"S{values['S']:g}")
        for m in ms:
            if m == 6:
                self.tool = self.selected
            if m in (3, 4, 5):
                self.spindle = m != 5
            if m not in M_END:
                words.append(f"M{m}")
        if words:
            self.track.event(" ".join(words), line)

    def _tool_number(self, value: float, line: int) -> int:
        if not 0 <= value < 1e9 or value != int(value):
            raise self._error(line, f"T{value:g}: a whole number from 0 on is expected")
        return int(value)

    def _move(self, values: Words, line: int) -> None:
        """One block with a G0, G1, G2 or G3 in force."""
        motion = self.motion
        if motion is None:
            problem = "coordinates, but no G0, G1, G2 or G3 is in force"
            raise self._error(line, problem, "Is the head of the file missing?")
        start, end = self.at, self._target(values, line)
        feed = math.nan
        if motion:
            if self.feed is None or self.feed <= 0:
                shown = "none is given" if self.feed is None else f"it is F{self.feed:g}"
                raise self._error(line, f"{MOTIONS[motion]} needs a feed, {shown}", "Add an F word above 0.")
            feed = self.feed * self.unit / 60.0  # type: ignore[operator]  # _target refused a missing unit
        if motion >= 20:
            self._arc(values, start, end, line)
        elif not values.keys().isdisjoint("IJKR"):
            raise self._error(line, f"I, J, K or R with {MOTIONS[motion]}", "They belong to G2 and G3.")
        self.at = end
        if end[0] == end[0] and end[1] == end[1] and end[2] == end[2]:  # no nan: the place is known
            self.track.moves.extend((*end, 0.0, 0.0, 1.0, feed))
            self.track.marks.extend((CUT_MARK if motion else RAPID_MARK, self.tool, line))
        else:
            words = " ".join(f"{a}{values[a]:g}" for a in "XYZ" if a in values)
            self.track.event(f"{words}, before the position is known", line)

    def _target(self, values: Words, line: int) -> tuple[float, float, float]:
        unit = self.unit
        if unit is None:
            raise self._error(
                line, "no units: neither G21 nor G20 before it", "Add G21 (mm) or G20 (inch) on top."
            )
        x, y, z = self.at
        if self.relative:
            new = (
                x + values.get("X", 0.0) * unit,
                y + values.get("Y", 0.0) * unit,
                z + values.get("Z", 0.0) * unit,
            )
            for letter, value in zip("XYZ", new, strict=True):
                if letter in values and value != value:
                    problem = f"{letter}{values[letter]:g} in G91, but where {letter} starts is not known"
                    raise self._error(line, problem, "Move there in G90 first.")
            return new
        return (
            values["X"] * unit if "X" in values else x,
            values["Y"] * unit if "Y" in values else y,
            values["Z"] * unit if "Z" in values else z,
        )

    def _arc(self, values: Words, start: tuple[float, ...], end: tuple[float, ...], line: int) -> None:
        if any(v != v for v in start) or not len(self.track):
            unknown = "".join(letter for letter, v in zip("XYZ", start, strict=True) if v != v)
            problem = f"an arc, but where it starts is not known ({unknown})"
            raise self._error(line, problem, "Name X, Y and Z in G0 or G1 first.")
        scaled = {k: v * self.unit for k, v in values.items() if k in "IJKR"}  # type: ignore[operator]
        try:
            center, sweep = arc_geometry(scaled, start, end, self.normal, clockwise=self.motion == 20)
        except ValueError as problem:
            raise self._error(line, str(problem), "Check the arc, or post lines instead.") from None
        normal = (float(self.normal == 0), float(self.normal == 1), float(self.normal == 2))
        self.track.arc(center, normal, sweep)

    def _retract(self, single: int, values: Words, line: int) -> None:
        """G28, G30, G53: a place of the machine, not of the work object; read as a retract."""
        name = f"G{single / 10:g}"
        axes = [a for a in "XYZ" if a in values]
        if not values.keys().isdisjoint("IJKR") or (single == 530 and (self.motion != 0 or not axes)):
            problem = f"{name}: read only as a rapid retract"
            raise self._error(line, problem, f"Write G53 G0 Z.. or {name} G91 Z0.")
        if single != 530 and axes and not (self.relative and all(values[a] == 0 for a in axes)):
            problem = f"{name} by way of a point"
            raise self._error(line, problem, f"Read is only the pure retract: {name} G91 Z0.")
        words = " ".join([name, *(f"{a}{values[a]:g}" for a in axes)])
        self.track.event(words, line)
        self.retracts.append((len(self.track), line, words))
        self.at = tuple(math.nan if a in (axes or "XYZ") else v for a, v in zip("XYZ", self.at, strict=True))  # type: ignore[assignment]

    def _check_retracts(self) -> None:
        """The retract itself is no pose: the straight way that is left must run above all cuts."""
        n = len(self.track)
        inner = [r for r in self.retracts if 0 < r[0] < n]
        if not inner:
            return
        heights = self.track.moves[2::7]
        top = self._highest_cut()
        for before, line, words in inner:
            if not (low := min(heights[before - 1], heights[before])) > top:
                problem = f"{words} is no place in the work object, and without it the tool would travel at "
                problem += f"Z {low * 1e3:g} mm, cuts reach up to Z {top * 1e3:g} mm"
                raise self._error(
                    line, problem, "Add a rapid to a higher Z before it, and approach from one."
                )

    def _highest_cut(self) -> float:
        """Z of the highest cutting pose, m; moves straight up are retracts, whatever their feed."""
        x, y, z = (self.track.moves[k::7] for k in range(3))
        kinds = self.track.marks[0::3]
        return max(
            (
                z[m]
                for m in range(1, len(z))
                if kinds[m] and not (x[m] == x[m - 1] and y[m] == y[m - 1] and z[m] >= z[m - 1])
            ),
            default=-math.inf,
        )

    def _check_end(self, lines: list[str]) -> None:
        if self.ended:
            return
        why = ""
        if self.percent:
            why = "it begins with '%' but does not end with one"
        elif self.spindle:
            why = "it ends without M2, M30 or M5 while the spindle turns"
        elif lines[-1].strip():
            why = "it ends without M2 or M30, and without a line end"
        if why:
            problem = f"the file looks cut off: {why}"
            raise self._error(len(lines), problem, "Add M30 if it is complete.")

    def _error(self, line: int, problem: str, remedy: str = "") -> ReadError:
        return ReadError(self.source, line, problem, remedy)
