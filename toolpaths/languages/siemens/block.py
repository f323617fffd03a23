"""A block of a SINUMERIK program as words: G and M words, addresses with their values, bare words, calls."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field

from toolpaths.interpreting.values import ExpressionError, Runtime
from toolpaths.languages.siemens.expressions import SiemensExpression, Value, as_number
from toolpaths.languages.siemens.words import REFUSED, SETTING_VALUES

#: A plain block is made of these alone: a letter with its number, or a name, '=' and a number.
_WORD = re.compile(
    r"\s*(?:([A-Z])\s*([-+]?(?:\d+\.?\d*|\.\d+))(?!\d*\s*[=(\[])|"
    r"([A-Z_][A-Z0-9_]*)\s*=\s*([-+]?(?:\d+\.?\d*|\.\d+))(?![\w.]*\s*[-+*/(\[<>=])|(\S))"
)
_R_PARAMETER = re.compile(r"R\d+")
_EXTENDED = re.compile(r"([MSTDH])(\d+)")  # of a spindle: M2=3
MODES = frozenset(("AC", "IC", "DC", "ACP", "ACN"))
#: Addresses of more than one letter that are read.
_ADDRESSES = (
    "CR AR TURN I1 J1 K1 AP RP RPL RND CHF CHR FRC FB A2 B2 C2 A3 B3 C3 A4 B4 C4 A5 B5 C5 X1 Y1 Z1 FP"
)
ADDRESSES = frozenset(_ADDRESSES.split())
LARGEST = 1e9
Given = float | str | tuple[str, float]
Arguments = list[Value | None]


@dataclass(slots=True)
class SiemensBlock:
    """One block.

    Attributes:
        gs: numbers of the G words.
        ms: extension (0: none) and number of the M words.
        values: address -> number, number with its mode (AC, IC ...), or text (T="NAME").
        words: bare words.
        calls: name and arguments, None for one that is left out.
        sets: variable -> value.
        unknown: addresses whose value only the controller knows, and why; they are NaN in ``values``.
    """

    gs: list[int] = field(default_factory=list)
    ms: list[tuple[int, int]] = field(default_factory=list)
    values: dict[str, Given] = field(default_factory=dict)
    words: list[str] = field(default_factory=list)
    calls: list[tuple[str, Arguments]] = field(default_factory=list)
    sets: list[tuple[str, Value]] = field(default_factory=list)
    unknown: dict[str, str] = field(default_factory=dict)


_G_NUMBERS: dict[str, int] = {}  # as written -> number; a file repeats a few


def plain_block(text: str) -> SiemensBlock | None:
    """A block of nothing but letters with numbers, and addresses with '=' and a number; None: it has more.

    Args:
        text: in capitals, without comment.

    Raises:
        ValueError: an address twice, or a number beyond what is read.
    """
    block = SiemensBlock()
    values = block.values
    for letter, number, name, value, other in _WORD.findall(text):
        if other:
            return None
        if letter == "G":
            known = _G_NUMBERS.get(number)
            block.gs.append(_g_number(number) if known is None else known)
        elif letter:
            if letter == "M":
                block.ms.append((0, _whole("M", float(number))))
            elif letter != "N":
                if letter in values and letter != "H":
                    raise ValueError(f"the address {letter} stands twice")
                values[letter] = v = float(number)
                if not -LARGEST < v < LARGEST:
                    raise ValueError(f"{letter}{number[:20]}: beyond {LARGEST:g}")
        elif name in ADDRESSES:
            _put(block, name, float(value))
        else:
            return None
    return block


def _g_number(number: str) -> int:
    value = _whole("G", float(number))
    if len(_G_NUMBERS) < 1000:
        _G_NUMBERS[number] = value
    return value


def _whole(letter: str, value: float) -> int:
    if value != value or not 0 <= value < LARGEST or value != int(value):
        raise ValueError(f"{letter}{value:g}: a whole number from 0 on is expected")
    return int(value)


def _put(block: SiemensBlock, name: str, value: Given) -> None:
    if name in block.values and name != "H":
        raise ValueError(f"the address {name} stands twice")
    v = value[1] if isinstance(value, tuple) else value
    if isinstance(v, float) and not -LARGEST < v < LARGEST:
        raise ValueError(f"{name}={v:g}: beyond {LARGEST:g}")
    block.values[name] = value


class BlockParser:
    """The words of a block that is more than plain, one after the other.

    Args:
        tokens: of the block.
    """

    def __init__(self, tokens: SiemensExpression) -> None:
        self.tokens = tokens
        self._set_at: list[int] = []

    def block(self) -> SiemensBlock:
        """The whole block.

        Raises:
            ExpressionError: it cannot be read, or depends on what only the controller knows.
            ValueError: a word that is refused.
        """
        block, tokens = SiemensBlock(), self.tokens
        while kind := tokens.kind():
            if kind == "address":
                word = tokens.take()
                self._letter(block, word[0], float(word[1:]))
            elif kind == "name":
                self._name(block)
            else:
                raise ExpressionError(f"{tokens.peek()!r} is not expected here")
        self._check_sets(block)
        return block

    def _check_sets(self, block: SiemensBlock) -> None:
        """A variable that is set and used behind it: which value counts, no manual says."""
        for (name, _), end in zip(block.sets, self._set_at, strict=True):
            if any(word.upper() == name for _, word in self.tokens.tokens[end:]):
                raise ValueError(f"{name} is set and used in one block", "Write them into blocks of their own.")

    def arguments(self) -> Arguments:
        """What stands in the brackets of a call."""
        tokens = self.tokens
        given: Arguments = []
        tokens.take("(")
        while True:
            given.append(None if tokens.peek() in (",", ")") else tokens.value())
            if tokens.peek() == ")":
                tokens.take()
                return given
            tokens.take(",")

    def _letter(self, block: SiemensBlock, letter: str, value: float) -> None:
        if letter == "G":
            block.gs.append(_whole("G", value))
        elif letter == "M":
            block.ms.append((0, _whole("M", value)))
        elif letter != "N" or block.gs or block.values:
            _put(block, letter, value)

    def _name(self, block: SiemensBlock) -> None:
        tokens = self.tokens
        word, follows = tokens.peek(), tokens.peek(1)
        if follows == "(":
            tokens.take()
            self._refuse(word)
            block.calls.append((word, self.arguments()))
        elif follows == "=" or follows == "[":
            self._assigned(block)
        elif len(word) == 1 and (tokens.kind(1) == "number" or follows in ("+", "-")):
            tokens.take()
            sign = -1.0 if tokens.peek() == "-" else 1.0
            if tokens.kind() == "sign":
                tokens.take()
            if tokens.kind() != "number":
                raise ExpressionError(f"a number is expected behind {word}")
            self._letter(block, word, sign * float(tokens.take().replace("EX", "E")))
        else:
            tokens.take()
            self._refuse(word)
            block.words.append(word)

    def _assigned(self, block: SiemensBlock) -> None:
        tokens = self.tokens
        word = tokens.peek()
        self._refuse(word)
        if word in SETTING_VALUES:
            self._setting(block)
            return
        name = tokens.name()
        tokens.take("=")
        if (extended := _EXTENDED.fullmatch(name)) and extended[1] == "M":
            block.ms.append((int(extended[2]), _whole(name, as_number(tokens.value()))))
        elif extended:
            given = self._given(texts=True)
            _put(block, name, as_number(given) if isinstance(given, Runtime) else given)
        elif len(name) == 1 or name in ADDRESSES:
            self._address(block, name)
        else:
            block.sets.append((name, tokens.value()))
            self._set_at.append(tokens.at)

    def _setting(self, block: SiemensBlock) -> None:
        """CTOL=0.01, ACC[X]=80, SPOS=DC(0): whatever the value is."""
        tokens = self.tokens
        name = tokens.take().upper()
        if tokens.peek() == "[":
            tokens.skip_brackets()
        tokens.take("=")
        if tokens.peek() in MODES and tokens.peek(1) == "(":
            tokens.take()
        tokens.value()
        block.words.append(name)

    def _address(self, block: SiemensBlock, name: str) -> None:
        value = self._given(texts=name == "T")
        if isinstance(value, Runtime):
            if name in block.values:
                raise ValueError(f"the address {name} stands twice")
            block.values[name], block.unknown[name] = math.nan, value.reason
        elif name in ("G", "M") and isinstance(value, float):
            self._letter(block, name, value)
        else:
            _put(block, name, value)

    def _given(self, *, texts: bool = False) -> Given | Runtime:
        """The value of an address."""
        tokens = self.tokens
        if tokens.peek() in MODES and tokens.peek(1) == "(":
            mode = tokens.take().upper()
            tokens.take("(")
            value = tokens.number()
            tokens.take(")")
            return mode, value
        found = tokens.value()
        if isinstance(found, Runtime) or (texts and isinstance(found, str)):
            return found
        return as_number(found)

    @staticmethod
    def _refuse(word: str) -> None:
        if why := REFUSED.get(word):
            raise ValueError(f"{word}: {why}")


def shown(name: str, given: Given) -> str:
    """A word as the program has it."""
    if isinstance(given, float):
        return f"{name}{given:g}" if len(name) == 1 else f"{name}={given:g}"
    return f'{name}="{given}"' if isinstance(given, str) else f"{name}={given[0]}({given[1]:g})"


def is_parameter(name: str) -> bool:
    """R and a number."""
    return _R_PARAMETER.fullmatch(name) is not None


def stored(name: str) -> str:
    """The name that a variable is kept under: R[5] is R5."""
    return f"R{name[2:-1]}" if name.startswith("R[") else name


def unknown(name: str) -> Runtime:
    """The value of a variable that the file gives none."""
    return Runtime(f"{name}, which has no value in the file")
