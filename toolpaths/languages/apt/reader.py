"""APT/CL and Siemens NX CLSF: GOTO with the tool axis, feeds, units, frames, circles and drilling cycles."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

from toolpaths.errors import ReadError
from toolpaths.languages.apt.motion import UPRIGHT, AptMotion
from toolpaths.languages.apt.words import (
    EVENTS,
    LATHE,
    PASSED,
    REFUSED,
    AptStatement,
    number,
    numbers,
    refusal,
    refuse_swallowed,
    statements,
)
from toolpaths.reading.source_text import comment_word, load_lines
from toolpaths.toolpath import Toolpath

_QUOTED = re.compile(r"\s*'.*'\s*")  # PARTNO of Fusion 360's post, behind MODE/MILL
_HOOK = re.compile(r"(?:^|_)(?:START|END|STOP|BEGIN|FINISH)(?:_|$)")
GCODE = re.compile(r"[GMNTSFO]\d+(?:[A-Z].*)?")


def read(path: Path, source: str, chord: float) -> Toolpath:
    """Poses of an APT/CL or CLSF file in its first coordinate system."""
    reader = AptReader(source)
    for statement in statements(load_lines(path, source), source):
        reader.statement(statement)
    return reader.finish(chord)


class AptReader(AptMotion):
    """Acts on the statements of one file.

    Attributes:
        acts: word -> what is done about it.
    """

    def __init__(self, source: str) -> None:
        super().__init__(source)
        self.ended = self.closed = self.milled = False
        self.acts: dict[str, Callable[[AptStatement], None]] = {
            "$$": self._comment,
            "GOTO": self._goto,
            "FROM": self._start,
            "GOHOME": self._home,
            "GODLTA": self._relative,
            "RAPID": self._rapid,
            "CIRCLE": self._circle,
            "MOVARC": self._circle,
            "INDIRV": self._direction,
            "TLON,GOFWD": self._tlon,
            "CYCLE": self._cycle,
            "FEDRAT": self._feedrate,
            "SPINDL": self._spindle,
            "UNITS": self._units,
            "UNIT": self._units,
            "MSYS": self._frame,
            "CSYS": self._frame,
            "TRNTYP": self._frame,
            "TLAXIS": self._tool_axis,
            "MULTAX": self._multax,
            "LOAD": self._load,
            "LOADTL": self._load,
            "TOOLNO": self._load,
            "CUTTER": self._cutter,
            "TLDATA": self._cutter,
            "CUTCOM": self._cutcom,
            "PARTNO": self._part,
            "MODE": self._mode,
            "SETUP": self._setup,
            "CALSUB": self._called,
            "TOOL PATH": self._tool_path,
            "END-OF-PATH": self._end,
            "END": self._end,
            "FINI": self._end,
        }

    def statement(self, s: AptStatement) -> None:
        """Act on one statement, or refuse it."""
        if self.ended and s.word != "$$":
            raise refusal(self.source, s, "a statement after FINI", "Two programs in one file? Give one file each.")
        if s.word == "INSERT" or "/" in s.text:
            refuse_swallowed(self.source, s)
        if act := self.acts.get(s.word):
            act(s)
        elif s.word in EVENTS:
            self._event(s)
        elif s.word not in PASSED:
            remedy = "This looks like G-code: name the file .nc." if GCODE.fullmatch(s.word) else ""
            raise refusal(self.source, s, REFUSED.get(s.word, "this reader does not know the word"), remedy)

    def finish(self, chord: float) -> Toolpath:
        """The poses, when all of the file is read."""
        if self.circle:
            raise refusal(self.source, self.circle[0], "no GOTO follows with the end of the circle")
        if not self.closed or self.open:
            missing = "END-OF-PATH" if self.open else "FINI or END-OF-PATH"
            problem = f"the file looks cut off: {missing} is missing"
            raise ReadError(self.source, None, problem, "Output it again.")
        return self.track.toolpath(chord, scale=self.feeds.scale())

    def _feedrate(self, s: AptStatement) -> None:
        self.feeds.feedrate(s)
        self.unclosed = None
        if self.cycle and self.cycle.rate not in (None, self.feeds.rate):
            raise refusal(self.source, s, "another feed within a cycle that has its own", "Is CYCLE/OFF missing?")

    def _spindle(self, s: AptStatement) -> None:
        self.feeds.spindle(s, len(self.track))
        self._event(s)

    def _units(self, s: AptStatement) -> None:
        self.feeds.units(s, poses=len(self.track) > 0)

    def _frame(self, s: AptStatement) -> None:
        """MSYS, CSYS, TRNTYP."""
        self._next_operation(s)
        changed = self.frames.read(s, poses=len(self.track) > 0)
        if changed:
            self._no_cycle(s)
            if self.circle:
                raise refusal(self.source, s, "the frame changes between a circle and its end")
            self._event(s)
        if s.word == "CSYS" and self.frames.world:  # at the begin of each operation of SolidWorks CAM
            if self.frames.up(UPRIGHT):
                self.axis, self.axis_stale = UPRIGHT, False
            else:
                self.axis_stale = self.axis_stale or changed or not self.frames.up(self.axis)
        elif changed:
            self.axis_stale = self.axis_stale or self.axis != UPRIGHT

    def _comment(self, s: AptStatement) -> None:
        self.frames.comment(s)
        self.tool.comment(s)
        self.track.event(comment_word(s.text), s.line)

    def _tool_axis(self, s: AptStatement) -> None:
        self._axis(s, numbers(s, (3,), self.source))

    def _multax(self, s: AptStatement) -> None:
        if s.minor not in ([], ["ON"], ["OFF"]):
            raise refusal(self.source, s, "MULTAX, MULTAX/ON or MULTAX/OFF is expected")
        if s.minor == ["OFF"] and self.fusion:  # its section is upright then
            self.axis, self.axis_stale = UPRIGHT, False
        elif s.minor == ["OFF"] and self.axis != UPRIGHT:
            self.axis_stale = True

    def _load(self, s: AptStatement) -> None:
        self._next_operation(s)
        self._no_cycle(s)
        self.tool.load(s)
        self._event(s)

    def _cutter(self, s: AptStatement) -> None:
        self.tool.cutter(s)
        self._event(s)

    def _cutcom(self, s: AptStatement) -> None:
        if self.fusion and s.minor[:1] != ["OFF"]:
            problem = "cutter compensation by Fusion 360: the path may be the part's outline, not the cutter's"
            raise refusal(self.source, s, problem, "Set the compensation type of the operation to 'in computer'.")
        self.tool.compensation(s)
        self._event(s)

    def _part(self, s: AptStatement) -> None:
        if len(self.track):
            raise refusal(self.source, s, "a part begins after moves of another", "Two programs? Give one file each.")
        self.fusion = self.milled and _QUOTED.fullmatch(s.text) is not None
        self._event(s)

    def _mode(self, s: AptStatement) -> None:
        """MODE/MILL: what the machine does, not what numbers mean."""
        if s.minor != ["MILL"]:
            raise refusal(self.source, s, LATHE if s.minor == ["TURN"] else "only MODE/MILL is read")
        self.milled = True

    def _setup(self, s: AptStatement) -> None:
        """SETUP/START of SolidWorks CAM."""
        if not s.minor or any(number(m) is not None for m in s.minor):
            raise refusal(self.source, s, "words such as START are expected, no numbers")
        self._next_operation(s)
        self._event(s)

    def _called(self, s: AptStatement) -> None:
        """CALSUB of hyperMILL: lines of the post processor's own at the begin and end of program, job and the like."""
        if len(s.minor) != 1 or not _HOOK.search(s.minor[0]):
            problem = "a subprogram that is not in the file; read are names such as START_PROG, END_JOB"
            raise refusal(self.source, s, problem, "Output its moves in the file.")
        self._event(s)

    def _tool_path(self, s: AptStatement) -> None:
        self._no_way()
        if self.open:
            problem = "a path begins before END-OF-PATH of the last one"
            raise refusal(self.source, s, problem, "Is the file cut off or mixed?")
        self.paths = self.open = True
        self.axis_stale = self.axis != UPRIGHT
        self._event(s)

    def _end(self, s: AptStatement) -> None:
        self._no_way()
        if self.circle:
            raise refusal(self.source, self.circle[0], "no GOTO follows with the end of the circle")
        self.closed, self.open = True, False
        self.rapid, self.cycle = False, None
        self.ended = s.word == "FINI"
