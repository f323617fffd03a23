"""InformJob: the text of an INFORM job, its positions and its instructions, each with its place.

Source: Yaskawa DX100 (HW0482494) Data Transmission, 4.1 job data format, 4.3 position data.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import NamedTuple

from toolpaths.interpreting.program_text import ProgramText
from toolpaths.languages.inform.words import HEAD

_LINE = re.compile(r"[^\r\n\f\x1a]+")
_N = r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)"
_POSITION = re.compile(rf"([A-Z]{{1,3}}\d+)\s*=\s*({_N}(?:\s*,\s*{_N})*)")
_FLAGS = re.compile(r"-?\d(?:\s*,\s*-?\d){5,30}")
_WHOLE = re.compile(r"\d{1,6}")
_NAME = re.compile(r"//NAME\s+(\S{1,64})")
LARGEST = 1e7  # of a number of a position


@dataclass(frozen=True, slots=True)
class JobPosition:
    """A position of a job.

    Attributes:
        kind: ROBOT, BASE, USER or PULSE.
        user: number of its user frame, where the kind is USER.
        tool: number of the tool file.
        bits: configuration as in Program, -1: not given.
        numbers: X Y Z in mm, Rx Ry Rz in deg; or pulses.
    """

    kind: str
    user: int
    tool: int
    bits: int
    numbers: tuple[float, ...]


class JobLine(NamedTuple):
    """An instruction: its place in the text of the job, and its text."""

    start: int
    end: int
    text: str


class InformJob(ProgramText):
    """The text of one job.

    Attributes:
        name: by which others call it.
        positions: by name, such as C00001.
        lines: the instructions behind NOP, without END.

    Raises:
        ReadError: it is no job; names the line.
    """

    def __init__(self, text: str, source: str) -> None:
        super().__init__(text, source)
        self.name = ""
        self.positions: dict[str, JobPosition] = {}
        self.lines: list[JobLine] = []
        self._kind, self._user, self._tool, self._bits, self._cartesian = "", 0, 0, -1, True
        self._count: tuple[int, int] | None = None  # of C positions that the head says, and where
        found = [JobLine(m.start(), m.end(), m[0].strip()) for m in _LINE.finditer(text)]
        found = [line for line in found if line.text]
        first = found[0] if found else JobLine(0, 0, "")  # a file may hold nothing but its end mark
        if first.text.removeprefix("\xef\xbb\xbf") != "/JOB":
            self.refuse(first.start, f"{first.text[:40]!r}: not an INFORM job, which begins with /JOB")
        body = next((k for k, line in enumerate(found) if line.text == "NOP"), len(found))
        self._head(found[1:body])
        self._body(found[body:])

    def _head(self, lines: list[JobLine]) -> None:
        for line in lines:
            word = line.text.split(maxsplit=1)[0].split(",")[0]
            if line.text == "/JOB":
                self.refuse(line.start, "/JOB again: two programs in one file", "Give one file each.")
            if word in HEAD:
                self._state(word, line)
            elif m := _POSITION.fullmatch(line.text):
                self._position(line, m[1], m[2])
            else:
                remedy = "Expected: positions such as C00000=..., then //INST, NOP, instructions, END."
                self.refuse(line.start, f"{line.text[:40]!r} is not read in the head of a job", remedy)
        if self._count is not None:
            taught, said = sum(name.startswith("C") for name in self.positions), self._count[0]
            if taught != said:
                problem = f"///NPOS says {said} positions, the job has {taught}"
                self.refuse(self._count[1], problem, "The file may be cut off: save the job again.")

    def _state(self, word: str, line: JobLine) -> None:
        rest = line.text[len(word) :].strip()
        if word == "//NAME":
            found = _NAME.fullmatch(line.text)
            self.name = found[1].upper() if found else ""
        elif word == "///NPOS":
            self._count = self._whole(line, rest.split(",")[0]), line.start
        elif word == "///TOOL":
            self._tool = self._whole(line, rest.split(",")[0])
        elif word == "///USER":
            self._user = self._whole(line, rest)
        elif word == "///POSTYPE":
            if rest not in ("ROBOT", "BASE", "USER", "PULSE", "ANGLE"):
                remedy = "Read are ROBOT, BASE, USER and PULSE: save the job so."
                self.refuse(line.start, f"positions of type {rest[:20]!r}", remedy)
            self._kind = rest
        elif word in ("///RECTAN", "///PULSE"):
            self._cartesian = word == "///RECTAN"
        elif word == "///RCONF":
            self._bits = self._configuration(line, rest)

    def _whole(self, line: JobLine, text: str) -> int:
        if not _WHOLE.fullmatch(text.strip()):
            self.refuse(line.start, f"{line.text[:40]!r}: a whole number is expected")
        return int(text)

    def _configuration(self, line: JobLine, rest: str) -> int:
        """No-flip, lower arm, rear; of 24 numbers: NX100 and older write 8, and mean another flip."""
        if not _FLAGS.fullmatch(rest):
            self.refuse(line.start, f"{line.text[:40]!r}: RCONF has 8 or 24 numbers")
        given = rest.replace(" ", "").split(",", 3)
        flags = [part != "0" for part in given[:3]]
        return flags[0] + 2 * flags[1] + 4 * flags[2] if rest.count(",") >= 19 else -1

    def _position(self, line: JobLine, name: str, text: str) -> None:
        numbers = tuple(float(part) for part in text.split(","))
        if max(map(abs, numbers)) > LARGEST and self._cartesian:
            self.refuse(line.start, f"{line.text[:40]!r}: a number that is too large", "Check the number.")
        if name in self.positions:
            self.refuse(line.start, f"{name} stands twice", "Two jobs in one file? Give one file each.")
        pulses = self._kind in ("PULSE", "ANGLE") or not self._cartesian
        if name.startswith("C") and not pulses and (len(numbers) != 6 or not self._kind):
            problem = f"{name} has {len(numbers)} numbers" if self._kind else f"{name} before ///POSTYPE"
            self.refuse(line.start, problem, "X, Y, Z, Rx, Ry, Rz of an arm of six axes are read.")
        kind = "PULSE" if pulses else self._kind
        bits, tool = self._bits, self._tool
        self.positions[name] = JobPosition(kind=kind, user=self._user, tool=tool, bits=bits, numbers=numbers)

    def _body(self, lines: list[JobLine]) -> None:
        if not lines:
            self.refuse(len(self.text), "no NOP: the job has no instructions", "The file may be cut off.")
        ends = [k for k, line in enumerate(lines) if line.text == "END"]
        if not ends:
            problem = "the job looks cut off: it does not end with END"
            self.refuse(lines[-1].start, problem, "Add END if it is complete.")
        if ends[0] != len(lines) - 1:
            behind = lines[ends[0] + 1]
            what = "two programs in one file" if behind.text == "/JOB" else f"text behind END: {behind.text[:30]!r}"
            self.refuse(behind.start, what, "Give one file each.")
        self.lines = lines[1:-1]
