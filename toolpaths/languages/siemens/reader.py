"""SINUMERIK 840D programs (.mpf, .spf, .arc): run as far as everything in them is constant, their moves collected."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

from toolpaths.interpreting.values import ExpressionError, Runtime
from toolpaths.languages.siemens.actions import ACTED, CALLED, ENDS, SiemensActions
from toolpaths.languages.siemens.block import Arguments, BlockParser, SiemensBlock, plain_block
from toolpaths.languages.siemens.drilling import DRILLING
from toolpaths.languages.siemens.expressions import SiemensExpression
from toolpaths.languages.siemens.flow import HEAD, Next, SiemensFlow, code, upper
from toolpaths.languages.siemens.library import SiemensLibrary
from toolpaths.languages.siemens.program import SiemensProgram, SiemensUnit
from toolpaths.languages.siemens.words import EVENT_CALLS, SETTING_VALUES, SETTINGS
from toolpaths.machine import Machine
from toolpaths.reading.source_text import comment_word, load_lines
from toolpaths.toolpath import Toolpath

_CHANGE = re.compile(r"M\s*0*6(?![0-9.])", re.I)
_ROTARY = re.compile(r"(?<![A-Z0-9_])[ABC]\s*(?:=|[-+.\d])(?!\s*\()", re.I)
_PROC = re.compile(r"\s*(?:N\d+\s*)?PROC\s+\w+(.*)", re.I)
_KNOWN_WORDS = SETTINGS | SETTING_VALUES | ACTED
_KNOWN_CALLS = CALLED | EVENT_CALLS
MOST_CALLS, DEEPEST = 9999, 20


def read(path: Path, source: str, chord: float, machine: Machine | None = None) -> Toolpath:
    """Poses of a program in its coordinate system.

    Args:
        path: the file; what it calls may lie beside it.
        source: its name in messages.
        chord: m, how far chords may lie from arcs.
        machine: what a file with rotary words, or with several coordinate systems, was posted for.

    Raises:
        ReadError: a line is refused.
    """
    lines = load_lines(path, source)
    reader = SiemensReader(SiemensProgram(lines, source), path, machine)
    reader.run_all()
    return reader.toolpath(chord)


class SiemensReader(SiemensActions):
    """Runs the program of one file.

    Args:
        program: its units.
        path: the file.
        machine: what it was posted for.
    """

    def __init__(self, program: SiemensProgram, path: Path, machine: Machine | None) -> None:
        super().__init__(program.source, machine)
        self.flow = SiemensFlow(self._run_section)
        self.units, self.library = program, SiemensLibrary(program, path, self._entered)
        self.variables = self.flow.variables
        self.ended_at, self._depth = -1, 0

    def run_all(self) -> None:
        """Run the main program.

        Raises:
            ReadError: a line is refused, or the program has no end.
        """
        main = self.units.main
        self.run(main, 0, len(main.lines))
        if self.ended_at < 0:
            problem = "the program looks cut off: it ends without M30, M2, M17 or RET"
            raise main.refusal(len(main.lines) - 1, problem, "Add M30 if it is complete.")
        for at in range(self.ended_at + 1, len(main.lines)):
            if not main.ran[at] and code(main.lines[at]).strip(" \t%"):
                raise main.refusal(
                    at, "words after the end of the program", "Two programs in one file? Give one file each."
                )
        for unit in self.units.units:
            if unit is not main and not any(unit.ran) and unit.lines:
                self.track.event(f"{unit.name}_{unit.kind} is not called", unit.first - 1)

    def _entered(self, lines: list[str]) -> None:
        """A file is read: how long it may run, whether it changes tools and turns axes."""
        self.flow.allow(len(lines))
        self.changes = self.changes or any(_CHANGE.search(code(s)) for s in lines if _CHANGE.search(s))
        turns = self.rotary.letters and any(_ROTARY.search(code(s)) for s in lines if _ROTARY.search(s))
        if turns and not self.rotary.used:
            self.rotary.use(len(self.track))

    def run(self, unit: SiemensUnit, begin: int, stop: int) -> None:
        """Run lines of a unit, up to its end or RET.

        Raises:
            ReadError: a line is refused.
        """
        lines, ran, at = unit.lines, unit.ran, begin
        while at < stop and self.ended_at < 0:
            text = lines[at]
            ran[at] = 1
            if not text or text.isspace():
                at += 1
                continue
            try:
                self.flow.count_step()
                to = self._line(unit, at, text)
            except ExpressionError as problem:
                raise unit.refusal(at, f"{text.strip()[:60]}: {problem}", "Post it with numbers.") from None
            except ValueError as problem:
                raise unit.refusal(at, *map(str, problem.args[:2])) from None
            except RecursionError:
                raise unit.refusal(at, "brackets or calls too deep") from None
            if to < 0:  # RET
                return
            if not begin <= to <= stop:
                raise unit.refusal(at, "a jump out of a section that is repeated", "Post it without jumps.")
            at = to

    def _line(self, unit: SiemensUnit, at: int, text: str) -> int:
        """Run one line; the one to go on with, below 0 to return."""
        line = unit.caller or unit.first + at
        if ";" in text:
            plain = code(text)
            if comment := comment_word(text[len(plain) :].lstrip("; ")):
                self.track.event(comment, line)
            text = plain
        self.text = text
        block = plain_block(text.upper())
        if block is None or "L" in block.values:
            return self._statement(unit, at, text, line)
        if (end := self.act(block, line)) is not None:
            return self._end(unit, at, end, line)
        return at + 1

    def _end(self, unit: SiemensUnit, at: int, m: int, line: int) -> int:
        """M17 returns from a subprogram; M2, M30 and M17 of the main program end it."""
        if m == 17 and self._depth:
            return -1
        self.no_corner()
        self.track.event(f"M{m}", line)
        self.ended_at = at if unit is self.units.main else len(self.units.main.lines)
        return at + 1

    def _statement(self, unit: SiemensUnit, at: int, text: str, line: int) -> int:
        """A line that is more than addresses with numbers."""
        head = HEAD.match(text)
        rest = upper(text[head.end() :] if head else text)
        if not rest.strip() or rest.strip() == "%":
            return at + 1
        tokens = SiemensExpression(rest, self.variables.look_up)
        if head and "/" in head[0]:
            return self._skipped(unit, at, tokens, line)
        word = tokens.peek()
        if act := self.flow.control.get(word):
            tokens.take()
            place: Next = act(unit, at, tokens)
            return at + 1 if place is None else place
        if word == "MCALL":
            tokens.take()
            self._modal(tokens)
            return at + 1
        if word in ("CALL", "EXTCALL", "RET"):
            return self._call_word(unit, at, tokens, line)
        block = BlockParser(tokens).block()
        for name, value in block.sets:
            if self.variables.put(name, value):
                self.track.event(comment_word(text), line)
        if called := self._called(block):
            self._run_called(*called, line=line)
            return at + 1
        if block.values.keys() & {"L", "P"}:
            raise ValueError(
                f"{text.strip()[:40]}: a subprogram that is not in the file, and not beside it", "Put it there."
            )
        if (end := self.act(block, line)) is not None:
            return self._end(unit, at, end, line)
        return at + 1

    def _skipped(self, unit: SiemensUnit, at: int, tokens: SiemensExpression, line: int) -> int:
        """A block with '/': let pass where it makes no difference to moves whether it counts."""
        block = BlockParser(tokens).block()
        harmless = not block.gs and not block.sets and block.values.keys() <= {"S", "H"}
        harmless = (
            harmless and all(w in SETTINGS for w in block.words) and all(n in EVENT_CALLS for n, _ in block.calls)
        )
        ends = [m for _, m in block.ms if m in ENDS]
        after = any(code(text).strip(" \t%") for text in unit.lines[at + 1 :])
        if not harmless or 6 in [m for _, m in block.ms] or (ends and after):
            problem = f"{self.text.strip()[:40]}: whether the block counts is chosen at the machine"
            raise ValueError(problem, "Take out the '/', or the block.")
        self.track.event(comment_word(self.text), line)
        return self._end(unit, at, ends[0], line) if ends else at + 1

    def _modal(self, tokens: SiemensExpression) -> None:
        """MCALL: every move from here on calls a drilling cycle; alone: none does."""
        block = BlockParser(tokens).block()
        if not (block.calls or block.words or block.values):
            self.modal = None
            return
        name = block.calls[0][0] if block.calls else (block.words or ["L"])[0]
        if len(block.calls) != 1 or name not in DRILLING or block.values or block.words:
            raise ValueError(f"MCALL {name}: read are {', '.join(DRILLING)}", "Post its moves instead.")
        self.modal = self.cycle(name, block.calls[0][1])

    # Subprograms

    def _call_word(self, unit: SiemensUnit, at: int, tokens: SiemensExpression, line: int) -> int:
        """CALL "NAME", CALL BLOCK A TO B, EXTCALL "NAME", RET."""
        word = tokens.take()
        if word == "RET":
            return -1 if self._depth else self._end(unit, at, 17, line)
        if word == "CALL" and tokens.peek() == "BLOCK":
            tokens.take()
            self._run_section(unit, self.flow.section(unit, at, tokens))
            return at + 1
        bracket = tokens.peek() == "("
        if bracket:
            tokens.take()
        name = tokens.value()
        if bracket:
            tokens.take(")")
        if isinstance(name, Runtime) or not isinstance(name, str):
            raise ValueError(f"{word}: the name of the program is not in the file")
        plain = re.split(r"[/\\]", name)[-1].upper()
        plain = re.sub(r"^_N_|[._](?:SPF|MPF)$", "", plain)
        if (found := self.library.find(plain)) is None:
            raise ValueError(
                f'{word} "{name[:40]}": there is no such program in the file or beside it', "Put it there."
            )
        self._run_called(found, [], 1, line=line)
        return at + 1

    def _called(self, block: SiemensBlock) -> tuple[SiemensUnit, Arguments, int] | None:
        """The program that a block calls, with arguments and how often."""
        names: list[tuple[str, Arguments]] = [c for c in block.calls if c[0] not in _KNOWN_CALLS]
        names += [(w, []) for w in block.words if w not in _KNOWN_WORDS]
        if isinstance(number := block.values.get("L"), float):  # L=AC(1) calls nothing
            names.append((f"L{number:g}", []))
        if len(names) != 1 or (found := self.library.find(names[0][0])) is None:
            return None
        count = block.values.get("P", 1.0)
        if block.gs or block.ms or not block.values.keys() <= {"L", "P"} or not isinstance(count, float):
            raise ValueError(f"{names[0][0]}: a subprogram is called in a block of its own")
        if count != int(count) or not 1 <= count <= MOST_CALLS:
            raise ValueError(f"P{count:g}: a whole number of calls up to {MOST_CALLS} is expected")
        return found, names[0][1], int(count)

    def _run_called(self, unit: SiemensUnit, given: Arguments, count: int, *, line: int) -> None:
        if self._depth >= DEEPEST:
            raise ValueError(f"subprograms call each other more than {DEEPEST} deep")
        inside = any(unit is u for u in self.units.units)
        place = unit if inside else replace(unit, caller=line)
        proc = next((m for text in unit.lines[:30] if (m := _PROC.match(text))), None)
        head = upper(code(proc[1])) if proc else ""
        saved = self.modes() if re.search(r"(?<!\w)SAVE(?!\w)", head) else None
        for _ in range(count):
            tokens = SiemensExpression(head, self.variables.look_up) if proc else None
            self.variables.enter(tokens, given)
            self._depth += 1
            self.run(place, 0, len(place.lines))
            self._depth -= 1
            self.variables.leave()
        if saved:
            self.restore(saved)

    def _run_section(self, unit: SiemensUnit, section: tuple[int, int, int]) -> None:
        """Lines from the first to before the second, so many times."""
        if self._depth >= DEEPEST:
            raise ValueError(f"sections repeat each other more than {DEEPEST} deep")
        first, stop, times = section
        self._depth += 1
        for _ in range(times):
            self.run(unit, first, stop)
        self._depth -= 1
