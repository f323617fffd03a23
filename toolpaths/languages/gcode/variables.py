"""Variables of G-code where they are constant: #1, #<depth>, R1, and expressions of them, as numbers.

Sources: LinuxCNC G-code reference, sections Parameters and Expressions (an assignment counts from the next block on);
Fanuc Series 30i operator's manual B-64484EN, Custom Macro (numbers from 1000 on are the controller's). A variable that
the file does not assign has a value that only the controller knows.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable

LARGEST_OWN = 999  # numbers that a program may use as it likes: on Fanuc, what is above is the controller's
_DEEPEST = 30
_SPACE = re.compile(r"\s*")
_NUMBER = re.compile(r"\d+\.?\d*|\.\d+")
_NAME = re.compile(r"<([^<>]*)>")
_R = re.compile(r"R(\d{1,4})(?![\d.])")
_ASSIGNED = re.compile(r"\s*=(?!=)")
_FUNCTION = re.compile(r"(ATAN|ACOS|ASIN|SQRT|ROUND|ABS|COS|SIN|TAN|FIX|FUP|LN|EXP)(?=\s*\[)")
_WORD = re.compile(r"[A-Z]")
_PRODUCTS = re.compile(r"\*(?!\*)|/|MOD(?![A-Z])")
_R_PARAMETER = re.compile(r"(?<![A-Z#])R\d{1,4}\s*=")


def _degrees(f: Callable[[float], float]) -> Callable[[float], float]:
    return lambda a: f(math.radians(a))


_FUNCTIONS: dict[str, Callable[[float], float]] = {
    "ABS": abs, "SQRT": math.sqrt, "SIN": _degrees(math.sin), "COS": _degrees(math.cos), "TAN": _degrees(math.tan),
    "ASIN": lambda a: math.degrees(math.asin(a)), "ACOS": lambda a: math.degrees(math.acos(a)),
    "ROUND": lambda a: math.floor(a + 0.5) if a >= 0 else math.ceil(a - 0.5), "FIX": math.floor, "FUP": math.ceil,
    "LN": math.log, "EXP": math.exp,
}  # fmt: skip


def has_variables(text: str) -> bool:
    """Whether a block (upper case, without comments) has something to compute."""
    return "#" in text or "[" in text or "=" in text


class Variables:
    """The variables of one file as they are at a place of its run.

    Attributes:
        used: lines that computed something.
    """

    def __init__(self) -> None:
        self._values: dict[str, float] = {}
        self._outer: list[dict[str, float]] = []  # named ones of the programs that called
        self._r = False  # the file has R parameters
        self._text, self._at, self._depth = "", 0, 0

    def enter(self) -> None:
        """A program is called: names are its own, but for those that begin with an underscore; numbers stay."""
        own = {name: v for name, v in self._values.items() if name[0] == "<" and name[1] != "_"}
        self._outer.append(own)
        self._values = {name: v for name, v in self._values.items() if name not in own}

    def leave(self) -> None:
        """The program that was called last ends."""
        kept = {name: v for name, v in self._values.items() if name[0] != "<" or name[1] == "_"}
        self._values = kept | self._outer.pop()

    def block(self, text: str) -> str:
        """The block (upper case, without comments) with numbers in place of what is computed.

        Raises:
            ValueError: something that is not constant in the file, or no expression.
        """
        self._text, self._at, self._depth = text, 0, 0
        self._r = self._r or _R_PARAMETER.search(text) is not None
        out, assigned = [], {}
        while True:
            begin = self._at
            self._skip()
            if self._at >= len(text):
                break
            if (name := self._assignment()) is not None:
                assigned[name] = self._sum()
                continue
            if letter := _WORD.match(text, self._at):
                self._at = letter.end()
                out.append(self._word(letter[0]))
                continue
            out.append(text[begin : self._at + 1])
            self._at += 1
        self._values |= assigned
        return "".join(out)

    def _word(self, letter: str) -> str:
        """A letter and its number, as written where nothing is to be computed."""
        begin = self._at
        equals = _ASSIGNED.match(self._text, self._at)
        if equals is not None:
            self._at = equals.end()
            return f"{letter}{_shown(self._sum())} "
        self._skip()
        sign = self._text[self._at : self._at + 1] if self._text[self._at : self._at + 1] in ("+", "-") else ""
        after = _SPACE.match(self._text, self._at + len(sign))
        first = self._text[after.end() : after.end() + 1] if after else ""
        if first not in ("#", "[") and not _FUNCTION.match(self._text, after.end() if after else self._at):
            self._at = begin
            number = _NUMBER.match(self._text, after.end() if after else begin)
            self._at = number.end() if number else begin
            return letter + self._text[begin : self._at]
        return f"{letter}{_shown(self._signed())} "

    def _assignment(self) -> str | None:
        """The variable that is assigned here; the place is behind '=' then."""
        begin = self._at
        if self._text[begin] == "#":
            self._at += 1
            name = self._variable()
        elif self._r and (found := _R.match(self._text, begin)):
            self._at, name = found.end(), f"R{found[1]}"
        else:
            return None
        equals = _ASSIGNED.match(self._text, self._at)
        if equals is None:
            self._at = begin
            if self._text[begin] == "#":
                raise ValueError(f"#{name}: a variable without a letter before it, and without '=' behind it")
            return None
        self._at = equals.end()
        if name.isdigit() and int(name) > LARGEST_OWN:
            raise ValueError(f"#{name}: a variable of the controller is set", "Post without it.")
        return name

    def _variable(self) -> str:
        """The name behind '#'."""
        self._skip()
        if name := _NAME.match(self._text, self._at):
            self._at = name.end()
            if not (inner := "".join(name[1].split())):
                raise ValueError("#<>: a variable without a name")
            return f"<{inner}>"
        value = self._signed()
        if value != math.floor(value) or not 0 < value < 1e6:
            raise ValueError(f"#{value:g}: a whole number from 1 on is expected")
        return str(int(value))

    def _value_of(self, name: str) -> float:
        if name in self._values:
            return self._values[name]
        shown = name if name[0] == "R" else f"#{name.lower()}"
        if name.isdigit() and int(name) > LARGEST_OWN:
            problem = f"{shown}: a variable of the controller"
        else:
            problem = f"{shown}: a variable that no line before it sets"
        raise ValueError(f"{problem}: its value is known at the machine only", "Write the number in its place.")

    def _sum(self) -> float:
        """+ and - of products, from left to right."""
        self._depth += 1
        if self._depth > _DEEPEST:
            raise ValueError(f"brackets more than {_DEEPEST} deep")
        value = self._product()
        while (sign := self._peek()) in ("+", "-") and sign:
            self._at += 1
            right = self._product()
            value = value + right if sign == "+" else value - right
        self._depth -= 1
        return value

    def _product(self) -> float:
        value = self._power()
        while True:
            self._skip()
            sign = _PRODUCTS.match(self._text, self._at)
            if sign is None:
                return value
            self._at = sign.end()
            right = self._power()
            if sign[0] != "*" and right == 0.0:
                raise ValueError("division by zero")
            value = value * right if sign[0] == "*" else value / right if sign[0] == "/" else value % right

    def _power(self) -> float:
        value = self._signed()
        while self._text.startswith("**", _end_of_space(self._text, self._at)):
            self._at = _end_of_space(self._text, self._at) + 2
            value = _worked_out(math.pow, value, self._signed())
        return value

    def _signed(self) -> float:
        sign = self._peek()
        if sign in ("+", "-") and sign:
            self._at += 1
            value = self._signed()
            return -value if sign == "-" else value
        return self._primary()

    def _primary(self) -> float:
        self._skip()
        if number := _NUMBER.match(self._text, self._at):
            self._at = number.end()
            return float(number[0])
        if self._peek() == "#":
            self._at += 1
            self._deeper()
            value = self._value_of(self._variable())
            self._depth -= 1
            return value
        if self._peek() == "[":
            return self._bracket()
        if function := _FUNCTION.match(self._text, self._at):
            return self._called(function)
        if self._r and (found := _R.match(self._text, self._at)):
            self._at = found.end()
            return self._value_of(f"R{found[1]}")
        shown = self._text[self._at : self._at + 10].strip()
        raise ValueError(f"{shown!r} where a number, a variable or [ ] is expected")

    def _called(self, function: re.Match[str]) -> float:
        self._at = function.end()
        self._skip()
        value = self._bracket()
        if function[1] != "ATAN":
            return _worked_out(_FUNCTIONS[function[1]], value)
        self._skip()
        if self._peek() != "/":
            return math.degrees(math.atan(value))
        self._at += 1
        self._skip()
        return math.degrees(math.atan2(value, self._bracket()))

    def _bracket(self) -> float:
        if self._peek() != "[":
            raise ValueError("'[' is expected")
        self._at += 1
        self._deeper()
        value = self._sum()
        self._depth -= 1
        if self._peek() != "]":
            shown = self._text[self._at : self._at + 10].strip()
            raise ValueError(f"{shown!r} where ']' is expected: read are + - * / ** MOD and functions")
        self._at += 1
        return value

    def _deeper(self) -> None:
        self._depth += 1
        if self._depth > _DEEPEST:
            raise ValueError(f"brackets more than {_DEEPEST} deep")

    def _peek(self) -> str:
        self._skip()
        return self._text[self._at : self._at + 1]

    def _skip(self) -> None:
        self._at = _end_of_space(self._text, self._at)


def _end_of_space(text: str, at: int) -> int:
    found = _SPACE.match(text, at)
    return found.end() if found else at


def _worked_out(f: Callable[..., float], *values: float) -> float:
    try:
        return float(f(*values))
    except (ValueError, OverflowError, ZeroDivisionError):
        raise ValueError(f"{', '.join(f'{v:g}' for v in values)}: no value of this function") from None


def _shown(value: float) -> str:
    """As a number of G-code: without exponent, to a millionth of a micrometre."""
    if not abs(value) < 1e9:
        raise ValueError(f"{value:g}: beyond 1e+09")
    return f"{value:.12f}".rstrip("0").rstrip(".") or "0"
