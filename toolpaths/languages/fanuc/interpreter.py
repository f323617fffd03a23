"""Executes a TP program as far as everything is constant, and collects the moves.

What a program computes while it runs (jumps, conditions on moves, offsets, position registers) is refused by line.
Sources: scan.py, config.py.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from toolpaths.errors import ReadError
from toolpaths.frame import Frame
from toolpaths.interpreting.robot_moves import ARC, JOINTS, LINE, NOWHERE, PTP
from toolpaths.interpreting.robot_track import RobotTrack
from toolpaths.interpreting.values import Runtime
from toolpaths.languages.fanuc.called_program import ACTS, SWALLOWING, CalledProgram, called, harmless, swallowed
from toolpaths.languages.fanuc.config import model_joints
from toolpaths.languages.fanuc.registers import CONSTANT, Registers
from toolpaths.languages.fanuc.scan import FREE, Listing, TpRecord, TpStatement
from toolpaths.reading.source_text import comment_word
from toolpaths.rotation import matrix_from_fanuc, quaternion_from_matrix
from toolpaths.tool_frame import ToolFrame
from toolpaths.toolpath import CUT, RAPID, Floats

_P = r"P\[(\d+)(?::[^\]]*)?\]"
MOVE = re.compile(
    rf"([JLC])\s+{_P}\s*(?:{_P}\s*)?\s(?:([\d.]+|R\[\d+(?::[^\]]*)?\])\s*"
    r"(%|mm/sec|cm/min|inch/min|deg/sec|sec|msec)|(max_speed))\s+(FINE|CNT\s?\d+|CD\s?\d+|CR\s?\d+)(.*)"
)
_MOTION = re.compile(r"[A-Z]\s+P(?:R)?\[")
#: A joint move to where only the running program knows.
_SOMEWHERE = re.compile(r"J\s+PR?\[(?!.*\b(?:Skip|LBL)\b)")
#: What a move sets off on its way (TB, TA, DB): a line that is put in must not set it off again.
BESIDES = re.compile(
    r"\s*\b(?:TB|TA|DB)\s*-?[\d.]+\s?(?:sec|mm)\s?,\s?"
    r"(?:CALL\s+\w+(?:\([^)]*\))?|POINT_LOGIC|[DRAGS]O\[[^\]]*\]\s?=\s?[\w.,()]+)"
)
_OPTIONS = re.compile(rf"(?:\s*(?:ACC\s?\d+|PTH|BREAK|(?:Ind\.)?EV\s?\d+%)|{BESIDES.pattern})*\s*")
_UNITS = {"mm/sec": 1.0, "cm/min": 10.0 / 60.0, "inch/min": 25.4 / 60.0}
_SET_FRAME = re.compile(r"(UFRAME|UTOOL)\[(?:GP1:)?(\d+)(?::[^\]]*)?\]\s*=\s*PR\[(\d+)(?::[^\]]*)?\]")
_CHOOSE = re.compile(r"(UFRAME|UTOOL)_NUM(?:\[GP1\])?\s*=\s*(\d+)")
_CALL = re.compile(r"CALL\s+([A-Za-z_]\w*)\s*(?:\(([^)]*)\))?")
_IF = re.compile(r"IF\b(?:[^\[,]|\[[^\]]*\])*?(?:,\s?(.*)|\bTHEN)")
_ENDS = ("END", "ABORT")


def _quaternions(numbers: Floats) -> Floats:
    """Of W, P, R in deg (N, 4), the last unused."""
    known = np.isfinite(numbers[:, 0])
    out = np.full((len(numbers), 4), np.nan)
    out[known] = quaternion_from_matrix(matrix_from_fanuc(np.radians(numbers[known, :3])))
    return out


class TpInterpreter:
    """Execution of a program, statement by statement; what a ``checked`` one calls was looked into before."""

    def __init__(self, listing: Listing, path: Path, checked: bool) -> None:
        self.listing, self.path, self.checked = listing, path, checked
        self.axes = dict.fromkeys(listing.external(), float("nan"))  # where the external axes stand
        self.track = RobotTrack(listing.source, "fanuc", _quaternions, tuple(self.axes))
        self.registers = Registers()
        self.programs: dict[str, CalledProgram | None] = {}  # those that were called
        self.inside: list[TpStatement] = []  # the IFs that are open
        self.lost = ""  # what moved the arm to where only the running program knows
        self.frames: dict[int, Floats] = {0: np.eye(4)}
        self.tools: dict[int, ToolFrame] = {0: ToolFrame("UT 0", Frame.identity())}
        self.active: dict[str, int | None] = {"frame": None, "tool": None}
        self.unknown: int | None = None

    def all(self) -> None:
        """Every statement up to END."""
        for s in self.listing.statements():
            if m := MOVE.fullmatch(s.text):
                if s.text[0] == "J" and not _OPTIONS.fullmatch(m[8]) and _SOMEWHERE.match(s.text):
                    self._somewhere(s)
                else:
                    self._move(s, m)
            elif s.text.startswith(("!", "//", "--eg:")):
                self.track.event(comment_word(s.text.lstrip("!/ ")), s.line)
            elif s.text in _ENDS and not self.inside:
                break
            else:
                self._other(s)
        if self.inside:
            raise self._refused(self.inside[-1], "an IF without its ENDIF", "The file may be cut off: post it again.")

    def _refused(self, s: TpStatement, problem: str, remedy: str) -> ReadError:
        return ReadError(self.listing.source, s.line, problem, remedy)

    def _other(self, s: TpStatement) -> None:
        if problem := swallowed(s.text):
            raise self._refused(s, problem, SWALLOWING.remedy)
        if m := _IF.fullmatch(s.text):
            self._condition(s, m[1])
        elif s.text == "ENDIF" and self.inside:
            self.inside.pop()
        elif m := _CALL.fullmatch(s.text):
            self._call(s, m[1])
        elif harmless(s.text) or (self.inside and s.text in ("ELSE", *_ENDS)):
            self.track.event(comment_word(s.text), s.line, s.text if ACTS.match(s.text) else "")
        elif self.inside:
            self._decided(s, s.text)
        elif m := _CHOOSE.fullmatch(s.text):
            self.active["frame" if m[1] == "UFRAME" else "tool"] = int(m[2])
        elif m := _SET_FRAME.fullmatch(s.text):
            self._set_frame(s, m[1], int(m[2]), int(m[3]))
        elif _SOMEWHERE.match(s.text):
            self._somewhere(s)
        elif _MOTION.match(s.text):
            remedy = "Expected: J, L or C to P[n], a speed, FINE or CNT; no register, no offset, no option but ACC."
            raise self._refused(s, f"the move {s.text[:60]!r} is not known before the program runs", remedy)
        else:
            self._assignment(s)

    def _assignment(self, s: TpStatement) -> None:
        try:
            known = self.registers.assign(s.text)
        except ValueError as why:
            raise self._refused(s, f"{s.text!r}: '{why}' is not a number", "Write it as 12.5 or (-12.5).") from None
        if not known:
            remedy = "Jumps, conditions and what else decides while the program runs cannot be compensated."
            raise self._refused(s, f"the instruction {s.text[:60]!r} is not read", remedy)
        if not s.text.startswith("PR["):
            self.track.event(comment_word(s.text), s.line)

    def _condition(self, s: TpStatement, action: str | None) -> None:
        """IF ... THEN, or IF ...,action: let pass where no move depends on it."""
        self.track.event(comment_word(s.text), s.line)
        if action is None:
            self.inside.append(s)
        elif m := _CALL.fullmatch(action):
            self._call(s, m[1])
        elif not harmless(action) and action not in _ENDS:
            self._decided(s, action)

    def _decided(self, s: TpStatement, action: str) -> None:
        """What a condition decides about: registers, nothing else."""
        if self.registers.spoil(action):
            return
        where = f" (line {self.inside[-1].line})" if self.inside else ""
        remedy = "Moves and frames that a condition decides about cannot be compensated: write them out."
        raise self._refused(s, f"an IF{where} decides about {action[:60]!r}", remedy)

    def _somewhere(self, s: TpStatement) -> None:
        """A joint move to where the running program knows: harmless as long as no cut starts there."""
        if self.inside:
            self._decided(s, s.text)
        self.lost = f"{s.text[:40]!r} (line {s.line})"
        self._stand(dict.fromkeys(self.axes, float("nan")))
        self.track.event(comment_word(s.text), s.line, s.text)

    def _set_frame(self, s: TpStatement, word: str, number: int, register: int) -> None:
        pose = self.registers.pose(register)
        if isinstance(pose, Runtime):
            remedy = f"Assign PR[{register},1] to PR[{register},6] numbers before."
            raise self._refused(s, f"{s.text!r}: {pose.reason} is not known before the program runs", remedy)
        if word == "UFRAME":
            self.frames[number] = pose
            return
        tool = self.tools.get(number)
        used = number in self.track.tools and tool is not None
        if used and tool is not None and not np.allclose(tool.frame.matrix, pose):
            raise self._refused(s, f"UTOOL[{number}] is changed after moves with it", "Give each tool its own number.")
        self.tools[number] = ToolFrame(f"UT {number}", Frame.of(pose))

    def _call(self, s: TpStatement, name: str) -> None:
        """A called program: where it lies beside, what it may do is known; where it does not, it is let pass."""
        self.track.event(f"CALL {name}", s.line, f"CALL {name}")
        if name not in self.programs:
            self.programs[name] = None if self.checked else called(self.path.parent, name)
        found = self.programs[name]
        if found is None:
            return
        if found.frames is not None:
            remedy = f"It says {found.frames.text[:40]!r} in line {found.frames.line}: put that into this program."
            raise self._refused(s, f"CALL {name}: that program sets a frame", remedy)
        if found.registers:
            self.registers.forget()
        if found.chooses:
            self.active = {"frame": None, "tool": None}
        if found.moves is not None:
            self.lost = f"CALL {name} ({found.moves.text[:40]!r} in line {found.moves.line} of it)"
            self._stand(dict.fromkeys(self.axes, float("nan")))

    def _move(self, s: TpStatement, m: re.Match[str]) -> None:
        word, first, second, speed, unit, _, term, options = m.groups()
        if self.inside:
            self._decided(s, s.text)
        if not _OPTIONS.fullmatch(options):
            remedy = "Offsets, skips and wrist moves are known only while the program runs."
            raise self._refused(s, f"the option {options.strip()[:40]!r} of a move is not read", remedy)
        if (word == "C") != (second is not None):
            raise self._refused(s, f"{s.text[:40]!r}", "Expected: two positions behind C, one behind J and L.")
        record = self._record(s, int(second or first))
        via = self._record(s, int(first)) if second else None
        if via is not None and via.bits < 0:
            raise self._refused(s, f"the via point P[{first}] is given in joint angles", "Record it as a position.")
        feed = self._feed(s, speed, unit)
        if term[:3] == "CNT" and int(term[3:]) > 100:
            raise self._refused(s, f"{term} is above 100", "The controller takes CNT0 to CNT100.")
        zone = 0.0 if term == "FINE" else float(term[2:]) if term[:2] in ("CD", "CR") else float("nan")
        kind = RAPID if word == "J" or speed is None else CUT
        self._start(s, word)
        self._append(s, word=word, kind=kind, to=record, via=via, numbers=(feed, zone))

    def _feed(self, s: TpStatement, speed: str | None, unit: str) -> float:
        """mm/s; NaN for joint speeds and times."""
        if speed is None:
            return float("nan")
        value: float | Runtime
        if speed[0] == "R":
            value = self.registers.number(int(re.findall(r"\d+", speed)[0]))
            if isinstance(value, Runtime) and unit in _UNITS:
                remedy = "Assign the register a number before, or give the speed as a number."
                raise self._refused(s, f"the speed {speed} is not known before the program runs", remedy)
        elif CONSTANT.fullmatch(speed):
            value = float(speed)
        else:
            raise self._refused(s, f"the speed {speed!r} is not a number", "Give it as 12.5.")
        if unit not in _UNITS or isinstance(value, Runtime):
            return float("nan")
        if not value > 0.0:
            raise self._refused(s, f"the speed {speed}{unit} is not above 0", "Correct the speed.")
        return value * _UNITS[unit]

    def _start(self, s: TpStatement, word: str) -> None:
        """Where a straight move starts has to be known: poses may be put in on its way."""
        if word != "J" and self.lost:
            remedy = "Put a J move to a position in front of it."
            raise self._refused(s, f"this move starts where {self.lost} leads", remedy)
        self.lost = ""

    def _append(
        self, s: TpStatement, word: str, kind: np.uint8, to: TpRecord, via: TpRecord | None,
        numbers: tuple[float, float],
    ) -> None:  # fmt: skip
        frame, tool = self._active(s, to, via)
        if to.external:
            self._stand(dict(to.external))
        nan = (float("nan"),) * 3
        if to.bits < 0:
            self.track.joints[self.track.count] = model_joints(np.radians(to.numbers))
        pose = (*to.numbers, 0.0) if to.bits >= 0 else (*nan, *nan, 0.0)
        shape = ARC if word == "C" else LINE if word == "L" else PTP if to.bits >= 0 else JOINTS
        target = (to.start, to.end, s.start, s.end) if to.bits >= 0 else NOWHERE
        self.track.move(
            (*pose, *numbers, *(nan if via is None else via.numbers[:3])),
            (
                shape, int(kind), tool, s.line, frame, to.bits, s.start, s.end,
                *target, *(NOWHERE if via is None else (via.start, via.end, s.start, s.end)),
            ),
        )  # fmt: skip

    def _stand(self, values: dict[str, float]) -> None:
        """Where external axes stand from the end of the next move on."""
        now = {**self.axes, **values}
        if now != self.axes:
            self.axes = now
            self.track.stand(tuple(now.values()))

    def _record(self, s: TpStatement, number: int) -> TpRecord:
        record = self.listing.records.get(number)
        if record is None and number in self.listing.records:
            raise self._refused(s, f"P[{number}] was never taught (***)", "Record the position, or delete the move.")
        if record is None:
            raise self._refused(s, f"P[{number}] is not in /POS", "The file may be cut off: post it again.")
        return record

    def _active(self, s: TpStatement, *records: TpRecord | None) -> tuple[int, int]:
        """The number of the track's frame and of the tool; a position has to be recorded in the active ones."""
        for r in records:
            if r is None:
                continue
            for name, said in (("frame", r.frame), ("tool", r.tool)):
                active = self.active[name]
                if active is None and said != FREE:
                    self.active[name] = said
                elif said not in (FREE, active):
                    word = "UFRAME_NUM" if name == "frame" else "UTOOL_NUM"
                    problem = f"the position is recorded with {name} {said}, {word} is {active}"
                    raise self._refused(s, problem, "The controller refuses that, too: choose it before the move.")
        frame, tool = self.active["frame"] or 0, self.active["tool"] or 0
        if tool in self.tools:
            self.track.tools[tool] = self.tools[tool]
        if frame in self.frames:
            return self.track.frame(self.frames[frame]), tool
        if self.unknown not in (None, frame):
            remedy = "Set UFRAME in the program, or use one frame for all moves."
            raise self._refused(s, f"frames {self.unknown} and {frame} are not in the file", remedy)
        self.unknown = frame
        return self.track.frame(None), tool
