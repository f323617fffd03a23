"""Fanuc TP programs (.ls): J, L and C moves to positions, frames and tools set from constants.

What a program computes while it runs (jumps, conditions, offsets, position registers) is refused by line. docs/fanuc.md
lists what is read. Sources: fanuc_scan.py, toolpaths/programs/fanuc_config.py.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from toolpaths.errors import ReadError
from toolpaths.programs.fanuc_config import model_joints
from toolpaths.programs.program import ToolFrame
from toolpaths.readers.fanuc_scan import FREE, Listing, Record, Statement
from toolpaths.readers.robot_moves import ARC, JOINTS, LINE, NOWHERE, PTP, RobotMoves, RobotTrack
from toolpaths.readers.text import comment_word, load_lines
from toolpaths.rotation import matrix_from_fanuc, quaternion_from_matrix
from toolpaths.toolpath import CUT, RAPID, Floats, Toolpath

_P = r"P\[(\d+)(?::[^\]]*)?\]"
MOVE = re.compile(
    rf"([JLC])\s+{_P}\s*(?:{_P}\s*)?\s(?:([\d.]+)\s*(%|mm/sec|cm/min|inch/min|deg/sec|sec|msec)|(max_speed))\s+"
    r"(FINE|CNT\s?\d+|CD\s?\d+|CR\s?\d+)(.*)"
)
_MOTION = re.compile(r"[A-Z]\s+P(?:R)?\[")
_OPTIONS = re.compile(r"(?:\s*(?:ACC\s?\d+|PTH|BREAK|(?:Ind\.)?EV\s?\d+%))*\s*")
_UNITS = {"mm/sec": 1.0, "cm/min": 10.0 / 60.0, "inch/min": 25.4 / 60.0}
_ELEMENT = re.compile(r"PR\[(\d+)(?::[^\],]*)?,([1-6])(?::[^\]]*)?\]\s*=\s*(\()?\s*(-?[\d.]+)\s*(\))?")
_REGISTER = re.compile(r"PR\[(?:GP\d:)?(\d+)[^\]]*\]\s*=\s*(LPOS)?")
_SET_FRAME = re.compile(r"(UFRAME|UTOOL)\[(?:GP1:)?(\d+)(?::[^\]]*)?\]\s*=\s*PR\[(\d+)(?::[^\]]*)?\]")
_CHOOSE = re.compile(r"(UFRAME|UTOOL)_NUM(?:\[GP1\])?\s*=\s*(\d+)")
_CALL = re.compile(r"CALL\s+([A-Za-z_]\w*)\s*(?:\(([^)]*)\))?")
_HARMLESS = re.compile(
    r"(?:DO|RO|AO|GO|SO|UO|F|M|R|SR|TIMER|UALM|MESSAGE|PAYLOAD|LBL)\[|WAIT\b(?!.*TIMEOUT)|PAUSE$|OVERRIDE\s*=|"
    r"COL (?:DETECT|GUARD)|(?:JOINT|LINEAR)_MAX_SPEED|(?:OFFSET|TOOL_OFFSET|SKIP) CONDITION|Arc (?:Start|End)|"
    r"(?:UN)?LOCK PREG"
)
_WRITTEN = re.compile(
    rb"![ \t]*+(?:Compensated program |compensated by[ \t]*+(?:;[ \t]*+[\r\n]*+[ \t]*+\d*+[ \t]*+:[ \t]*+!)?[ \t]*+"
    rb"toolpath-compensator)"
)
_CONSTANT = re.compile(r"-?(?:\d+\.?\d*|\.\d+)")


def read(path: Path, source: str, chord: float) -> Toolpath:
    """The poses of a .ls file; arcs become points within ``chord``."""
    load_lines(path, source)
    return moves_of(path.read_bytes(), source, path).toolpath(chord)


def moves_of(data: bytes, source: str, path: Path) -> RobotMoves:
    """The moves, with their places in the text (one character a byte).

    Args:
        path: where the file lies; programs that it calls are looked for beside it.
    """
    run = _Run(Listing(data.decode("latin-1"), source), path, _WRITTEN.search(data) is not None)
    run.all()
    return run.track.moves()


def refuse_written(data: bytes, source: str) -> None:
    """Refuse a program that this product wrote or corrected: compensated twice is wrong. The marker takes two remarks.

    Raises:
        ReadError: names the line of the marker.
    """
    if found := _WRITTEN.search(data):
        line = data.count(b"\n", 0, found.start()) + 1
        raise ReadError(source, line, "this program is compensated already", "Give the program as it was before that.")


def _quaternions(numbers: Floats) -> Floats:
    """Of W, P, R in deg (N, 4), the last unused."""
    known = np.isfinite(numbers[:, 0])
    out = np.full((len(numbers), 4), np.nan)
    out[known] = quaternion_from_matrix(matrix_from_fanuc(np.radians(numbers[known, :3])))
    return out


class _Run:
    """Execution of a program, statement by statement; what a ``checked`` one calls was looked into before."""

    def __init__(self, listing: Listing, path: Path, checked: bool) -> None:
        self.listing, self.path, self.checked = listing, path, checked
        self.track = RobotTrack(listing.source, "fanuc", _quaternions)
        self.registers: dict[int, list[float | None]] = {}
        self.frames: dict[int, Floats] = {0: np.eye(4)}
        self.tools: dict[int, ToolFrame] = {0: ToolFrame("UT 0", np.zeros(3), np.eye(3))}
        self.frame: int | None = None
        self.tool: int | None = None
        self.unknown: int | None = None

    def all(self) -> None:
        """Every statement up to END."""
        for s in self.listing.statements():
            if s.text in ("END", "ABORT"):
                break
            if m := MOVE.fullmatch(s.text):
                self._move(s, m)
            elif s.text.startswith(("!", "//", "--eg:")):
                self.track.event(comment_word(s.text.lstrip("!/ ")), s.line)
            else:
                self._other(s)

    def _refused(self, s: Statement, problem: str, remedy: str) -> ReadError:
        return ReadError(self.listing.source, s.line, problem, remedy)

    def _other(self, s: Statement) -> None:
        if m := _ELEMENT.fullmatch(s.text):
            if not _CONSTANT.fullmatch(m[4]) or bool(m[3]) != bool(m[5]):
                raise self._refused(s, f"{s.text!r}: {m[4]!r} is not a number", "Write it as 12.5 or (-12.5).")
            self.registers.setdefault(int(m[1]), [None] * 6)[int(m[2]) - 1] = float(m[4])
        elif m := _CHOOSE.fullmatch(s.text):
            setattr(self, "frame" if m[1] == "UFRAME" else "tool", int(m[2]))
        elif m := _SET_FRAME.fullmatch(s.text):
            self._set_frame(s, m[1], int(m[2]), int(m[3]))
        elif m := _REGISTER.match(s.text):
            self.registers[int(m[1])] = [None] * 6
        elif m := _CALL.fullmatch(s.text):
            self._call(s, m[1])
        elif _HARMLESS.match(s.text):
            self.track.event(comment_word(s.text), s.line)
        elif _MOTION.match(s.text):
            remedy = "Expected: J, L or C to P[n], a speed, FINE or CNT; no register, no offset, no option but ACC."
            raise self._refused(s, f"the move {s.text[:60]!r} is not known before the program runs", remedy)
        else:
            remedy = "Jumps, conditions and what else decides while the program runs cannot be compensated."
            raise self._refused(s, f"the instruction {s.text[:60]!r} is not read", remedy)

    def _set_frame(self, s: Statement, word: str, number: int, register: int) -> None:
        values = self.registers.get(register)
        if values is None or None in values:
            remedy = f"Assign PR[{register},1] to PR[{register},6] numbers before."
            raise self._refused(s, f"{s.text!r}: PR[{register}] is not known before the program runs", remedy)
        numbers = np.array(values, dtype=np.float64)
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = matrix_from_fanuc(np.radians(numbers[3:])), numbers[:3] * 1e-3
        if word == "UFRAME":
            self.frames[number] = pose
            return
        tool = self.tools.get(number)
        used = number in self.track.tools and tool is not None
        if used and tool is not None and not np.allclose(np.hstack([tool.rotation, tool.xyz[:, None]]), pose[:3]):
            raise self._refused(s, f"UTOOL[{number}] is changed after moves with it", "Give each tool its own number.")
        self.tools[number] = ToolFrame(f"UT {number}", pose[:3, 3], pose[:3, :3])

    def _call(self, s: Statement, name: str) -> None:
        """A called program is let pass where it lies beside and does not move the arm."""
        beside = [p for p in self.path.parent.glob("*") if p.suffix.lower() == ".ls" and p.stem.upper() == name.upper()]
        if not beside and not self.checked:
            remedy = f"Put {name}.ls beside the program: it is read to see that it does not move the arm."
            raise self._refused(s, f"CALL {name}: what that program does is not known", remedy)
        if not beside:
            self.track.event(f"CALL {name}", s.line)
            return
        listing = Listing(beside[0].read_bytes().decode("latin-1"), str(beside[0]))
        for inner in listing.statements():
            if not inner.text.startswith(("!", "//")) and inner.text != "END" and not _HARMLESS.match(inner.text):
                remedy = f"It says {inner.text[:40]!r} in line {inner.line}: put that into this program."
                raise self._refused(s, f"CALL {name}: that program does more than set signals", remedy)
        self.track.event(f"CALL {name}", s.line)

    def _move(self, s: Statement, m: re.Match[str]) -> None:
        word, first, second, speed, unit, _, term, options = m.groups()
        if not _OPTIONS.fullmatch(options):
            remedy = "Offsets, skips and wrist moves are known only while the program runs."
            raise self._refused(s, f"the option {options.strip()[:40]!r} of a move is not read", remedy)
        if (word == "C") != (second is not None):
            raise self._refused(s, f"{s.text[:40]!r}", "Expected: two positions behind C, one behind J and L.")
        if speed is not None and not _CONSTANT.fullmatch(speed):
            raise self._refused(s, f"the speed {speed!r} is not a number", "Give it as 12.5.")
        record = self._record(s, int(second or first))
        via = self._record(s, int(first)) if second else None
        if via is not None and via.bits < 0:
            raise self._refused(s, f"the via point P[{first}] is given in joint angles", "Record it as a position.")
        feed = float(speed) * _UNITS[unit] if unit in _UNITS else float("nan")
        if feed == 0.0:
            raise self._refused(s, f"the speed {speed}{unit} is not above 0", "Correct the speed.")
        zone = 0.0 if term == "FINE" else float(term[2:]) if term[:2] in ("CD", "CR") else float("nan")
        kind = RAPID if word == "J" or speed is None else CUT
        self._append(s, word, kind, record, via, (feed, zone))

    def _append(
        self, s: Statement, word: str, kind: np.uint8, to: Record, via: Record | None, numbers: tuple[float, float]
    ) -> None:
        frame, tool = self._active(s, to, via)
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

    def _record(self, s: Statement, number: int) -> Record:
        record = self.listing.records.get(number)
        if record is None:
            raise self._refused(s, f"P[{number}] is not in /POS", "The file may be cut off: post it again.")
        return record

    def _active(self, s: Statement, *records: Record | None) -> tuple[int, int]:
        """The number of the track's frame and of the tool; what a position says has to be what is active."""
        for r in records:
            if r is None:
                continue
            for name, said in (("frame", r.frame), ("tool", r.tool)):
                active = getattr(self, name)
                if active is None and said != FREE:
                    setattr(self, name, said)
                elif said not in (FREE, active):
                    word = "UFRAME_NUM" if name == "frame" else "UTOOL_NUM"
                    problem = f"the position is recorded with {name} {said}, {word} is {active}"
                    raise self._refused(s, problem, "The controller refuses that, too: choose it before the move.")
        frame, tool = self.frame or 0, self.tool or 0
        if tool in self.tools:
            self.track.tools[tool] = self.tools[tool]
        if frame in self.frames:
            return self.track.frame(self.frames[frame]), tool
        if self.unknown not in (None, frame):
            remedy = "Set UFRAME in the program, or use one frame for all moves."
            raise self._refused(s, f"frames {self.unknown} and {frame} are not in the file", remedy)
        self.unknown = frame
        return self.track.frame(None), tool
