"""SiemensFlow: which line of a SINUMERIK program comes next: jumps, IF, FOR, WHILE, LOOP, REPEAT, where constant."""

from __future__ import annotations

import re
from collections.abc import Callable

from toolpaths.interpreting.values import ExpressionError, Runtime
from toolpaths.languages.siemens.expressions import SiemensExpression, as_number
from toolpaths.languages.siemens.program import SiemensUnit
from toolpaths.languages.siemens.variables import SiemensVariables

Next = int | None
#: Skip mark, block number, label.
HEAD = re.compile(r"\s*(?:/\d?)?\s*(?:[N:]\s*\d+)?\s*(?:/\d?)?\s*(?:[A-Z_][A-Z0-9_]+\s*:(?!=))?", re.I)
_BRACKETS = r"\s*\((?:\"[^\"]*\"|[^\"()]|\((?:\"[^\"]*\"|[^\"()])*\))*\)"
#: A line that moves nothing, whole.
_IDLE = re.compile(
    rf"\s*(?:(?:(?:MSG|SETAL|WRITE){_BRACKETS}|STOPRE|M0*[01](?!\d)|G0*4(?!\d)\s*[FS]\s*=?\s*[\d.]+|ELSE|ENDIF)"
    r"(?![A-Z_])\s*)*$", re.I,
)  # fmt: skip
_BEHIND = re.compile(rf"\s*[A-Z_]\w*(?:{_BRACKETS})?(?:\s+[A-Z_]+(?![\w=(]))*\s*$", re.I)
_JUMPS = {"GOTO": "", "GOTOF": "F", "GOTOB": "B", "GOTOC": ""}
LEAST_STEPS = 100_000  # that a program may run, however short it is
MOST_REPEATS = 9999


def code(text: str) -> str:
    """A line without its comment."""
    if ";" not in text:
        return text
    if '"' not in text:
        return text[: text.index(";")]
    quoted = False
    for k, c in enumerate(text):
        if c == '"':
            quoted = not quoted
        elif c == ";" and not quoted:
            return text[:k]
    return text


def upper(text: str) -> str:
    """Capitals, but for what stands in quotes."""
    if '"' not in text:
        return text.upper()
    return '"'.join(part if k % 2 else part.upper() for k, part in enumerate(text.split('"')))


class SiemensFlow:
    """The control words of one file.

    Args:
        repeat: runs lines of a unit again: first, the one behind the last, how often.

    Attributes:
        control: word -> what it does; the line to go on with, None: the next one.
        variables: what names stand for.
    """

    def __init__(self, repeat: Callable[[SiemensUnit, tuple[int, int, int]], None]) -> None:
        self.variables, self._run_again = SiemensVariables(), repeat
        self._steps = LEAST_STEPS
        self._bounds: dict[tuple[int, int], tuple[str, float]] = {}
        self.control: dict[str, Callable[[SiemensUnit, int, SiemensExpression], Next]] = {
            "IF": self._if, "ELSE": self._else, "ENDIF": self._pass, "FOR": self._for, "ENDFOR": self._end_for,
            "WHILE": self._while, "ENDWHILE": self._again, "LOOP": self._loop, "ENDLOOP": self._end_loop,
            "REPEAT": self._repeat, "UNTIL": self._until, "REPEATB": self._repeat_block, "DEF": self._def,
            "PROC": self._named, "EXTERN": self._named, **dict.fromkeys(_JUMPS, self._goto), "GOTOS": self._start_again,
        }  # fmt: skip

    def allow(self, lines: int) -> None:
        """So many lines more may run."""
        self._steps += lines

    def count_step(self) -> None:
        """One line more.

        Raises:
            ValueError: too many.
        """
        self._steps -= 1
        if self._steps < 0:
            raise ValueError("the program runs too many lines for its length", "Post it without loops.")

    def section(
        self, unit: SiemensUnit, at: int, tokens: SiemensExpression, *, block: bool = False
    ) -> tuple[int, int, int]:
        """The lines that REPEAT and CALL BLOCK name: the first, the one behind, how often.

        Raises:
            ExpressionError: a label is missing.
        """
        first = self._place(unit, at, tokens.take().upper(), "")
        last = None
        if tokens.kind() == "name" and tokens.peek() == "TO":
            tokens.take()
        if tokens.kind() == "name" and tokens.peek() != "P":
            last = self._place(unit, first, tokens.take().upper(), "F")
        times = 1.0
        if tokens.kind():
            if tokens.take().upper() == "P":
                tokens.take("=")
                times = tokens.number()
            else:
                raise ExpressionError("labels and P= are expected")
        if times != int(times) or not 0 <= times <= MOST_REPEATS:
            raise ExpressionError(f"P={times:g}: a whole number up to {MOST_REPEATS} is expected")
        if block:
            return first, first + 1, int(times)
        if last is None:
            end = unit.find("ENDLABEL", first, "F")
            last = at - 1 if end is None or (first < at < end) else end
        if last < first or first <= at <= last:
            raise ExpressionError("a section that holds its own repeat, or ends before it begins")
        return first, last + 1, int(times)

    def _pass(self, unit: SiemensUnit, at: int, tokens: SiemensExpression) -> Next:
        if tokens.kind():
            raise ExpressionError(f"{tokens.peek()!r} is not expected here")
        return None

    def _named(self, unit: SiemensUnit, at: int, tokens: SiemensExpression) -> Next:
        """PROC, EXTERN: a name with the types of its arguments; behind it words such as SAVE."""
        text = HEAD.sub("", code(unit.lines[at]), count=1).strip()
        if not _BEHIND.fullmatch(text.partition(" ")[2]):
            raise ExpressionError("a name with its arguments is expected, and no other words in the block")
        return None

    def _def(self, unit: SiemensUnit, at: int, tokens: SiemensExpression) -> Next:
        self.variables.declare(tokens)
        return None

    def _truth(self, tokens: SiemensExpression) -> bool | Runtime:
        value = tokens.value()
        if isinstance(value, str):
            raise ExpressionError("a text as a condition")
        return value if isinstance(value, bool | Runtime) else value != 0.0

    def _known(self, tokens: SiemensExpression) -> bool:
        value = self._truth(tokens)
        if isinstance(value, Runtime):
            raise ExpressionError(f"what runs depends on {value.reason}: known only at run time")
        if tokens.kind():
            raise ExpressionError(f"{tokens.peek()!r} is not expected here")
        return value

    def _if(self, unit: SiemensUnit, at: int, tokens: SiemensExpression) -> Next:
        value = self._truth(tokens)
        if tokens.peek() in _JUMPS:
            if isinstance(value, Runtime):
                raise ExpressionError(f"what runs depends on {value.reason}: known only at run time")
            word = tokens.take().upper()
            return self._jump(unit, at, tokens, word) if value else None
        if tokens.kind():
            raise ExpressionError(f"{tokens.peek()!r} is not expected here")
        other = unit.partner(at)
        if isinstance(value, Runtime):
            end = (
                unit.partner(other)
                if HEAD.sub("", unit.lines[other], count=1).strip().upper().startswith("ELSE")
                else other
            )
            if all(_IDLE.match(HEAD.sub("", code(text), count=1)) for text in unit.lines[at + 1 : end]):
                return end + 1
            raise ExpressionError(f"what runs depends on {value.reason}: known only at run time")
        return None if value else other + 1

    def _else(self, unit: SiemensUnit, at: int, tokens: SiemensExpression) -> Next:
        self._pass(unit, at, tokens)
        return unit.partner(at) + 1

    def _loop(self, unit: SiemensUnit, at: int, tokens: SiemensExpression) -> Next:
        self._pass(unit, at, tokens)
        unit.partner(at)
        return None

    def _for(self, unit: SiemensUnit, at: int, tokens: SiemensExpression) -> Next:
        name = tokens.take().upper() if tokens.kind() == "address" else tokens.name()
        tokens.take("=")
        value = tokens.number()
        tokens.take("TO")
        last, end = tokens.number(), unit.partner(at)
        self._pass(unit, at, tokens)
        self.variables.put(name, value)
        self._bounds[id(unit), at] = name, last
        return None if value <= last else end + 1

    def _end_for(self, unit: SiemensUnit, at: int, tokens: SiemensExpression) -> Next:
        self._pass(unit, at, tokens)
        begin = unit.partner(at)
        if (id(unit), begin) not in self._bounds:
            raise ExpressionError("ENDFOR, but its FOR did not run")
        name, last = self._bounds[id(unit), begin]
        value = as_number(self.variables.look_up(name)) + 1.0
        self.variables.put(name, value)
        return begin + 1 if value <= last else None

    def _while(self, unit: SiemensUnit, at: int, tokens: SiemensExpression) -> Next:
        end = unit.partner(at)
        return None if self._known(tokens) else end + 1

    def _again(self, unit: SiemensUnit, at: int, tokens: SiemensExpression) -> Next:
        self._pass(unit, at, tokens)
        return unit.partner(at)

    def _end_loop(self, unit: SiemensUnit, at: int, tokens: SiemensExpression) -> Next:
        self._pass(unit, at, tokens)
        return unit.partner(at) + 1

    def _repeat(self, unit: SiemensUnit, at: int, tokens: SiemensExpression) -> Next:
        if tokens.kind():
            self._run_again(unit, self.section(unit, at, tokens))
        else:
            unit.partner(at)
        return None

    def _repeat_block(self, unit: SiemensUnit, at: int, tokens: SiemensExpression) -> Next:
        self._run_again(unit, self.section(unit, at, tokens, block=True))
        return None

    def _until(self, unit: SiemensUnit, at: int, tokens: SiemensExpression) -> Next:
        return None if self._known(tokens) else unit.partner(at) + 1

    def _goto(self, unit: SiemensUnit, at: int, tokens: SiemensExpression) -> Next:
        return self._jump(unit, at, tokens, tokens.tokens[tokens.at - 1][1].upper())

    def _start_again(self, unit: SiemensUnit, at: int, tokens: SiemensExpression) -> Next:
        raise ExpressionError("GOTOS runs the program again without end")

    def _jump(self, unit: SiemensUnit, at: int, tokens: SiemensExpression, word: str) -> Next:
        label = tokens.take().strip('"').upper()
        if tokens.kind():
            raise ExpressionError("a jump to a place that is worked out")
        return self._place(unit, at, label, _JUMPS[word])

    @staticmethod
    def _place(unit: SiemensUnit, at: int, label: str, way: str) -> int:
        found = unit.find(label, at, way)
        if found is None:
            raise ExpressionError(f"there is no label {label[:40]} to go to")
        return found
