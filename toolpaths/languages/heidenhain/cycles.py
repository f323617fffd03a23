"""KlartextCycles: drilling cycles, datum shifts, rotations, presets, tilted planes and TCPM of a Klartext program."""

from __future__ import annotations

import re

from toolpaths.interpreting.values import ExpressionError
from toolpaths.languages.heidenhain.block import SWALLOWING, expected
from toolpaths.languages.heidenhain.drilling import MAX, NEEDED, KlartextDrilling, drilling
from toolpaths.languages.heidenhain.formula import NUMBER, PARAMETER, QParameters
from toolpaths.languages.heidenhain.motion import KlartextMotion
from toolpaths.languages.heidenhain.planes import Plane, plane, spatial
from toolpaths.languages.heidenhain.words import CYCLES_OFF, CYCLES_PASSED, CYCLES_REFUSED
from toolpaths.machine import Machine
from toolpaths.reading.machine_words import stay
from toolpaths.reading.source_text import comment_word

_VALUE = rf"[-+]?\s*(?:{NUMBER}|{PARAMETER})"
_CYCLE = re.compile(r"(\d+)(?:\.(\d+))?\s*(.*)", re.S)
_Q = re.compile(rf"Q(\d+)\s*=\s*(?:({_VALUE})|(F?\s*(?:MAX|AUTO)))")
_SHIFT = re.compile(rf"(?:(I)?([XYZABCUVW])\s*({_VALUE})\s*)+")
_SHIFT_WORD = re.compile(rf"(I)?([XYZABCUVW])\s*({_VALUE})")
_ROTATION = re.compile(rf"(I)?ROT\s*({_VALUE})")
_ANGLE = re.compile(rf"([ABC])\s*({_VALUE})")
_TCPM = re.compile(
    r"\s*(?:(F)\s*(TCP|CONT)|(AXIS)\s*(POS|SPAT)|(PATHCTRL)\s*(AXIS|VECTOR)|(REFPNT)\s*(\S+)|F\s*\d+|(\S+))"
)
_MODES = (["MODE", "MILL"],)
_PASSED = frozenset(("DWELL", "FEED", "S-PULSE", "SPINDLE", "COUNT"))


class KlartextCycles(KlartextMotion):
    """Cycles and planes of one file.

    Attributes:
        q: Q parameters.
        cycle: the drilling cycle that is defined.
        modal: M89: every positioning block calls it.
    """

    def __init__(self, source: str, machine: Machine | None) -> None:
        super().__init__(source, machine)
        self.q = QParameters()
        self.cycle: KlartextDrilling | None = None
        self.modal = False
        self._tilt_angles: dict[str, float] = {}

    def choose_tip(self, *, on: bool, text: str, line: int) -> None:
        """M128, M129 and FUNCTION TCPM.

        Raises:
            ValueError: a tilted plane is on.
        """
        if not on:
            self.end_tip()
            self.spatial_angles = False
        elif self.swivelled and self.frame.rows is not None:
            raise ValueError("M128 or FUNCTION TCPM in a tilted plane", "Write PLANE RESET before it.")
        else:
            self.swivelled, self.tip = False, True
        self.track.event(text, line)

    def define(self, text: str, line: int) -> None:
        """CYCL DEF.

        Raises:
            ValueError: a cycle that is not read.
        """
        match = _CYCLE.match(text)
        if not match:
            raise ValueError(f"CYCL DEF {text[:40]}: the number of the cycle is missing")
        number, part, more = int(match[1]), int(match[2] or 0), match[3]
        SWALLOWING.refuse(more)
        if number in CYCLES_REFUSED:
            if number in CYCLES_OFF and (not part or CYCLES_OFF[number].fullmatch(more.strip())):
                return
            raise ValueError(f"CYCL DEF {number}: {CYCLES_REFUSED[number]}")
        if number in (7, 10, 19):
            if part:
                {7: self._shift, 10: self._rotation, 19: self._working_plane}[number](more.strip(), line)
        elif number in NEEDED:
            self.cycle, self.modal = drilling(number, self._q_values(more), self.unit, self.feed_unit), False
            self.track.event(comment_word(f"CYCL DEF {number}"), line)
        elif number == 247:
            self._preset(self._q_values(more), line)
        elif number in CYCLES_PASSED:
            if part == 0 or number == 9:
                self.track.event(comment_word(self.text), line)
        else:
            problem = f"CYCL DEF {number}: a cycle that this reader does not know"
            raise ValueError(problem, f"Read are {', '.join(map(str, sorted(NEEDED)))}; post the moves of others.")

    def _q_values(self, text: str) -> dict[int, float]:
        """Q200=+2 ...; a feed may be MAX or AUTO."""
        out: dict[int, float] = {}
        found = _Q.findall(text)
        if len(found) != text.count("="):
            raise ValueError(
                f"{text.strip()[:60]}: a value behind each '=' is expected: a number, a parameter, MAX or AUTO"
            )
        for number, value, word in found:
            if word:
                if word.endswith("AUTO") and not self.tool_feed > 0:
                    raise ValueError(f"Q{number}=AUTO, but TOOL CALL gives no feed")
                out[int(number)] = MAX if word.endswith("MAX") else self.tool_feed
            else:
                out[int(number)] = self.q.number(value)
                self.q.put(f"Q{number}", out[int(number)])
        return out

    def _shift(self, text: str, line: int) -> None:
        if not _SHIFT.fullmatch(text):
            raise ValueError(
                f"CYCL DEF 7.1 {text[:30]}: a datum of a table, or no axis", "Post X, Y and Z of the shift."
            )
        for relative, axis, value in _SHIFT_WORD.findall(text):
            number = self.q.number(value)
            if axis in "XYZ":
                self.frames.shift("XYZ".index(axis), number * self.unit, relative=bool(relative))
            elif number:
                raise ValueError(f"CYCL DEF 7 with {axis}{number:g}: a shift of a rotary axis")
        self._put_frame(f"CYCL DEF 7 {text}", line)

    def _rotation(self, text: str, line: int) -> None:
        match = expected(text, _ROTATION, "ROT with an angle")
        self.frames.rotate(self.q.number(match[2]), relative=bool(match[1]))
        self._put_frame(f"CYCL DEF 10 {text}", line)

    def _put_frame(self, words_: str, line: int) -> None:
        self.set_frame(self.frames.total())
        self.track.event(comment_word(words_), line)

    def _working_plane(self, text: str, line: int) -> None:
        """Cycle 19: spatial angles A, B, C; rotary axes are turned by words of their own."""
        given = {axis: self.q.number(value) for axis, value in _ANGLE.findall(text)}
        if given and (left := [c for c, v in self._tilt_angles.items() if v and c not in given]):
            raise ValueError(f"CYCL DEF 19 without {', '.join(left)}, which the plane before has")
        self._tilt_angles = given
        self._incline(Plane(spatial(given), turns=False, keeps=False), f"CYCL DEF 19 {text}", line)

    def _plane(self, text: str, line: int) -> None:
        to = plane(text, self.q)
        if self.tip and to.frame.rows is not None:
            raise ValueError("PLANE under M128 or FUNCTION TCPM", "Write M129 before it.")
        self._incline(to, f"PLANE {text.strip()}", line)

    def _incline(self, to: Plane, text: str, line: int) -> None:
        self.frames.incline(to)
        frame = self.frames.total()
        if self.frames.tilt.rows is None:
            self.end_swivel(frame, comment_word(text), line, turns=to.turns, keeps=to.keeps)
        else:
            self.swivel(frame, comment_word(text), line, turns=to.turns, keeps=to.keeps)

    def _preset(self, q: dict[int, float], line: int) -> None:
        used = len(self.track) > 0 or any(v == v for v in self.at)
        self.frames.preset(f"{q.get(339, 0.0):g}", used)
        self._put_frame("CYCL DEF 247", line)

    def _trans(self, text: str, line: int) -> None:
        """TRANS DATUM AXIS X.. or RESET; TRANS ROTATION."""
        kind = text.split()
        if kind[:2] == ["DATUM", "AXIS"]:
            self._shift(text.partition("AXIS")[2].strip(), line)
        elif kind[:2] == ["DATUM", "RESET"]:
            self._shift("X0 Y0 Z0", line)
        else:
            raise ValueError(f"TRANS {text.strip()[:30]}: TRANS DATUM AXIS is read", "Post cycle 7 or 10.")

    def _function(self, text: str, line: int) -> None:
        kind = text.split()
        if kind[:1] == ["TCPM"]:
            self._tcpm(text.partition("TCPM")[2])
            self.choose_tip(on=True, text="FUNCTION TCPM", line=line)
        elif kind == ["RESET", "TCPM"]:
            self.choose_tip(on=False, text="FUNCTION RESET TCPM", line=line)
        elif kind in _MODES or (kind and kind[0] in _PASSED):
            SWALLOWING.refuse(text)
            self.track.event(comment_word(self.text), line)
        else:
            raise ValueError(f"FUNCTION {text.strip()[:30]}: this reader does not know it")

    def _tcpm(self, text: str) -> None:
        for _, _, axis, angles, _, _, point, where, other in _TCPM.findall(text):
            if other:
                raise ValueError(f"{other!r} in FUNCTION TCPM: no word that is read")
            if axis:
                self.spatial_angles = angles == "SPAT"
            if point and where != "TIP-TIP":
                raise ValueError(f"REFPNT {where}: places that are not those of the tip", "Post with TIP-TIP.")

    def _drill(self, line: int) -> None:
        """One hole where the tool is."""
        self.no_corner()
        if self.cycle is None:
            raise ExpressionError("a cycle call, but no drilling cycle is defined")
        if any(v != v for v in self.at):
            raise ValueError("a cycle call, but where the tool is, is not known", "Name X, Y and Z in a line first.")
        if self.tip:
            raise ValueError("a drilling cycle under M128 or FUNCTION TCPM", "Write M129 before it.")
        for step in self.cycle.steps():
            if step.dwell:
                self.track.event(f"dwell {step.dwell:g} s", line, stay(step.dwell))
            elif step.height != self.at[2]:
                self.go(step.mark, (self.at[0], self.at[1], step.height), step.feed, line)
