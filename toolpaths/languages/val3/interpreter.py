"""Executes a VAL3 program as far as everything is constant, and collects the moves.

What only the controller knows is refused by line where a move depends on it. Source: VAL3 Reference Manual
(D28062804A), 8 arm positions, 9 movement control (movej, movel, movec; mdesc: tvel in mm/s, leave and reach in mm).
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NoReturn

import numpy as np

from toolpaths.interpreting.program_text import LinkedText
from toolpaths.interpreting.robot_moves import ARC, JOINTS, LINE, NOWHERE, PTP
from toolpaths.interpreting.robot_track import RobotTrack
from toolpaths.interpreting.values import Runtime, first_runtime
from toolpaths.interpreting.vocabulary import REFUSED, REMARK, SETTING
from toolpaths.languages.val3.scan import ValData, ValLine, ValProgram
from toolpaths.languages.val3.targets import ValSpeed, ValTarget, ValTools, speed_of, target_of
from toolpaths.languages.val3.values import JOINTED, SPELLED, TRSF, ValValues, numbers_of
from toolpaths.languages.val3.words import OPENS, QUIET, SWALLOWING, WORDS, second_statement
from toolpaths.reading.source_text import comment_word, load_lines
from toolpaths.rotation import matrix_from_staubli, quaternion_from_matrix
from toolpaths.toolpath import CUT, RAPID, Floats

_MOVE = re.compile(r"(?:[A-Za-z_]\w*(?:\[\w+\])?\s*=\s*)?(mov(?:ejx|ecx|[ejlc]+))\s*\((.*)\)")
_CALL = re.compile(r"call\s+(?:(\w+):)?(\w+)\s*\((.*)\)")
_LINK = re.compile(r"link\s*\(([^,()]+),([^,()]+)\)")
_SET = re.compile(r"((?:[A-Za-z_]\w*:)?[A-Za-z_]\w*(?:\[\w+\])?)\s*(?:\.\s*(\w+(?:\.\w+)?))?\s*=(?!=)\s*(.*)")
_PIECE = re.compile(r"[{}(),]")
_N = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)")
_FIRST = re.compile(r"//|\$?[A-Za-z_]\w*")
_NAN = float("nan")
MOST_DEEP = 20
_CASES = {word.lower(): word for word in WORDS}


def _quaternions(numbers: Floats) -> Floats:
    """Of rx, ry, rz in deg (N, 4), the last unused."""
    known = np.isfinite(numbers[:, 0])
    out = np.full((len(numbers), 4), np.nan)
    out[known] = quaternion_from_matrix(matrix_from_staubli(np.radians(numbers[known, :3])))
    return out


class ValInterpreter:
    """Execution of a program and of those that it calls and that lie beside it.

    Args:
        program: that is run.
        data: of its application.
        path: of its file; others are looked for beside it.
    """

    def __init__(self, program: ValProgram, data: dict[str, ValData], path: Path) -> None:
        self.path, self.text, self.program = path, LinkedText(program), program
        self.values = ValValues(data)
        self.track = RobotTrack(program.source, "val3", _quaternions, text=self.text)
        self.parts: dict[str, ValProgram | None] = {program.name.lower(): program}
        self.begin = 0  # of the program that runs, in the whole text
        self.inside: list[tuple[str, ValLine]] = []  # blocks that are open: the word that closes each, its line
        self.lost = ""
        self.tools = ValTools(self.values, self.track)
        self.left = 10_000 + 20 * len(program.lines)

    def run(self, depth: int = 0) -> None:
        """Every statement of the program."""
        program, begin, inside = self.program, self.begin, self.inside
        self.inside = []
        self.values.declare(program.locals)
        for line in program.lines:
            self.left -= 1
            if self.left < 0:
                self._refuse(line, "programs call each other more often than they are long", "Unroll the calls.")
            if self._statement(line, depth):
                break
            self.program, self.begin = program, begin
        if self.inside:
            self._refuse(self.inside[-1][1], "a block that is not closed", "The file may be cut off.")
        self.inside = inside

    def _refuse(self, line: ValLine, problem: str, remedy: str = "") -> NoReturn:
        self.program.refuse(line.start, problem, remedy)

    def _event(self, line: ValLine, instruction: str = "") -> None:
        part, at = self.text.part(self.begin), self.program.line(line.start)
        self.track.event(comment_word(line.text.removeprefix("//")), at, instruction, part)

    def _statement(self, line: ValLine, depth: int) -> bool:
        """Run one; True where it ends the program."""
        text = line.text
        found = _FIRST.match(text)
        word = _CASES.get(found[0].lower(), "") if found else ""
        done = WORDS.get(word, "")
        if text.startswith("//"):
            self._event(line)
        elif problem := self._swallowed(text):
            self._refuse(line, problem, SWALLOWING.remedy)
        elif m := _MOVE.fullmatch(text):
            self._move(line, m[1].lower(), m[2])
        elif m := _CALL.fullmatch(text):
            self._call(line, m[1] or "", name=m[2], arguments=m[3], depth=depth)
        elif self.inside and text.lower().startswith(self.inside[-1][0]):
            self._event(line)
            self.inside.pop()
        elif word in OPENS:
            self._event(line)
            self.inside.append((OPENS[word], line))
        elif text == "return" and not self.inside:
            return True
        elif m := _LINK.fullmatch(text):
            self._link(line, m[1], m[2])
        elif done in (REMARK, SETTING) and word != "=":
            self._event(line, "" if done == SETTING or word in QUIET or self.inside else text)
        elif done != REFUSED and (m := _SET.fullmatch(text)) and "?" not in text:
            self._assign(line, m[1], field=(m[2] or "").lower(), value=m[3].strip())
        else:
            why = "it is not read so" if done else "this reader does not know it"
            why = "what it does is known only while the program runs" if done == REFUSED else why
            self._refuse(line, f"{text[:50]!r}: {why}", "Write the moves out.")
        return False

    @staticmethod
    def _swallowed(text: str) -> str:
        """What is wrong with a statement that holds another one; empty: nothing."""
        first = _FIRST.match(text)
        called = _MOVE.match(text) or _CALL.match(text)
        return second_statement(text, text.index("(") if called else first.end() if first else 0)

    def _decided(self, line: ValLine) -> None:
        """What stands in a block that may or may not run, or run again, cannot be followed."""
        if self.inside:
            opened = self.inside[-1][1]
            problem = f"{opened.text[:30]!r} (line {self.program.line(opened.start)}) decides about {line.text[:40]!r}"
            remedy = "Moves that a condition or a loop decides cannot be compensated: write them out."
            self._refuse(line, problem, remedy)

    def _call(self, line: ValLine, library: str, *, name: str, arguments: str, depth: int) -> None:
        self._event(line, line.text)
        called = None if library else self._beside(name)
        if called is None:
            return  # a program of a library, such as that of a gripper
        if not any("mov" in other.text or "call" in other.text for other in called.lines) and not arguments:
            return
        self._decided(line)
        if called.parameters or arguments.strip():
            self._refuse(line, f"{line.text[:40]!r}: a call with arguments", "Write the moves of that program out.")
        if depth >= MOST_DEEP:
            self._refuse(line, f"{line.text[:40]!r}: more than {MOST_DEEP} programs within each other")
        at = next(k for k, part in enumerate(self.text.parts) if part is called)
        self.program, self.begin = called, self.text.begins[at]
        self.run(depth + 1)

    def _beside(self, name: str) -> ValProgram | None:
        if name.lower() not in self.parts:
            beside = (p for p in sorted(self.path.parent.glob("*")) if p.suffix.lower() == ".pgx")
            file = next((p for p in beside if p.stem.lower() == name.lower()), None)
            program = None
            if file is not None:
                load_lines(file, str(file))
                program = ValProgram(file.read_bytes().decode("latin-1"), str(file))
                self.text.add(program)
                self.left += 20 * len(program.lines)
            self.parts[name.lower()] = program
        return self.parts[name.lower()]

    def _link(self, line: ValLine, name: str, father: str) -> None:
        key = self.values.find(name)
        if key is None:
            self._refuse(line, f"{name.strip()[:30]} is not in the data", "Give the .dtx beside the program.")
        if self.inside:
            self.values.forget(key[0], f"set in line {self.program.line(line.start)}, which may or may not run")
            return
        self.values.put(key, fatherId=father.strip() if "[" in father else f"{father.strip()}[0]")

    def _assign(self, line: ValLine, name: str, *, field: str, value: str) -> None:
        """Set what is a number or a trsf of numbers; what is computed is not known from here on."""
        key, base = self.values.find(name), name.split("[")[0].lower()
        at = self.program.line(line.start)
        if self.inside or key is None:
            self.values.forget(base, f"set in line {at}" + (", which may or may not run" if self.inside else ""))
            self._event(line, line.text if base not in self.values.kinds else "")
            return
        kind, numbers = self.values.kinds[base], numbers_of(value)
        last = field.rpartition(".")[2]
        if field in ("trsf", "") and kind not in JOINTED and numbers is not None and len(numbers) == 6:
            self.values.put(key, **dict(zip(TRSF, numbers, strict=True)))
        elif field == "" and kind in JOINTED and numbers is not None and len(numbers) == 6:
            self.values.put(key, **{f"j{i}": v for i, v in enumerate(numbers, 1)})
        elif field and _N.fullmatch(value) and len(value) < 20:
            self.values.put(key, **{SPELLED.get(last, last): float(value)})
        elif field == "blend":
            self.values.put(key, blend=value)
        elif not field.startswith("config") and field not in ("accel", "decel"):
            self.values.forget(base, f"computed in line {at}")
            self._event(line)

    def _move(self, line: ValLine, word: str, arguments: str) -> None:
        self._decided(line)
        given = _split(arguments)
        if word not in ("movej", "movel", "movec") or len(given) != (4 if word == "movec" else 3):
            remedy = "Expected: movej or movel(target, tool, mdesc), movec(via, target, tool, mdesc)."
            self._refuse(line, f"{line.text[:50]!r} is not read", remedy)
        target, speed = target_of(self.values, given[-3]), speed_of(self.values, given[-1])
        if isinstance(target, Runtime) and word == "movej":
            self.lost = f"{line.text[:40]!r} (line {self.program.line(line.start)})"
            self._event(line, line.text)
            return
        via = target_of(self.values, given[0]) if word == "movec" else None
        reason = first_runtime(target, via, speed)
        if reason is not None or isinstance(target, Runtime) or isinstance(via, Runtime) or isinstance(speed, Runtime):
            remedy = "Give it as numbers, in the program or in the .dtx beside it."
            self._refuse(line, f"{line.text[:50]!r}: {reason.reason if reason else ''}", remedy)
        if word != "movej" and self.lost and self.track.count:
            remedy = "Put a movej to a known point in front of it."
            self._refuse(line, f"this move starts where {self.lost} leads", remedy)
        self.lost = ""
        self._append(line, word=word, target=target, via=via, speed=speed, tool=self.tools.number(given[-2]))

    def _append(
        self, line: ValLine, *, word: str, target: ValTarget, via: ValTarget | None, speed: ValSpeed, tool: int
    ) -> None:
        if target.jointed and word != "movej":
            self._refuse(line, f"{line.text[:40]!r}: a line to joint angles", "Give the target as a point.")
        code = JOINTS if target.jointed else {"movej": PTP, "movel": LINE, "movec": ARC}[word]
        numbers = target.numbers
        if target.jointed:
            self.track.joints[self.track.count] = np.radians(numbers)
            numbers = (_NAN,) * 6
        through: tuple[float, ...] = (_NAN,) * 3
        if via is not None:
            if via.jointed or not via.beside(target):
                self._refuse(line, f"{line.text[:40]!r}: via point and end in two frames", "Give them in one.")
            through = via.numbers[:3]
        frame = self.track.frame(target.father, target.unknown)
        kind, feed = (RAPID, _NAN) if word == "movej" else (CUT, speed.feed)
        self.track.move(
            (*numbers, 0.0, feed, speed.zone, *through),
            (
                code, int(kind), tool, self.program.line(line.start), frame, -1, self.begin + line.start,
                self.begin + line.end, *NOWHERE, *NOWHERE,
            ),
        )  # fmt: skip


def _split(arguments: str) -> list[str]:
    """Arguments of a call, at commas outside brackets."""
    depth, out, last = 0, [], 0
    for m in _PIECE.finditer(arguments):
        if m[0] == "," and depth == 0:
            out.append(arguments[last : m.start()].strip())
            last = m.end()
        elif m[0] != ",":
            depth += 1 if m[0] in "{(" else -1
    return [*out, arguments[last:].strip()]
