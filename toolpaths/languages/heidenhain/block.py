"""A block of HEIDENHAIN Klartext: lines joined at '~', comments taken off, words with their values."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from toolpaths.errors import ReadError
from toolpaths.interpreting.values import ExpressionError, Runtime
from toolpaths.languages.heidenhain.formula import NUMBER, PARAMETER, QParameters
from toolpaths.languages.heidenhain.words import M_WORDS
from toolpaths.reading.swallowed import Swallowing, shown

_HEAD = re.compile(r"\s*(/)?\s*(?:N?\s*\d+)?\s*(/)?\s*", re.I)
_VALUE = rf"[-+]?\s*(?:{NUMBER}|{PARAMETER})"
_NAMES = (
    "IPR|IPA|IX|IY|IZ|IA|IB|IC|IU|IV|IW|PR|PA|NX|NY|NZ|TX|TY|TZ|FMAX|FAUTO|FU|FZ|FT|MAX|AUTO|RL|RR|MB|LA|BT|VT|DL|CCA|LEN|"
    "X|Y|Z|A|B|C|U|V|W|F|R|M|S|T"
)
#: A word of a block that moves: a name with its value or without, DR with its sign, or anything else.
_WORD = re.compile(rf"\s*(?:({_NAMES})\s*({_VALUE})?|DR\s*([-+])|(\S))")
LARGEST = 1e9
#: A line that is no part of the block before it: it has a block number, or begins as a block does.
_OWN = re.compile(
    r"\s*/?\s*(?:N?\s*\d+\s*[A-Z*/;]|(?:L|LN|LP|C|CP|CC|CR|CT|CTP)(?:\s+(?:I?[XYZ]|PR|IPR|PA|IPA)|\s*$)|"
    r"(?:RND|CHF|LBL|CALL|CYCL|TOOL|PLANE|FUNCTION|TRANS|STOP|END|BEGIN|BLK|FN|APPR|DEP)(?![A-Z])|\*)", re.I,
)  # fmt: skip
#: Blocks that move, call or end inside of one that is kept as a remark.
_SWALLOWED = re.compile(
    r"(?<![\w.])(?:(?:L|LN|LP|C|CP|CC|CR|CT|CTP)\s+(?:I?[XYZABC]|PR|IPR|PA|IPA)\s*[-+.\dQ]|"
    r"(?:CALL|CYCL|TOOL)\s+(?:LBL|PGM|CALL|DEF)(?![A-Z])|M\s*0*(?:89|99)(?!\d))"
)
SWALLOWING = Swallowing(_SWALLOWED)


@dataclass(slots=True)
class KlartextBlock:
    """The words of a block that moves.

    Attributes:
        values: name -> number.
        unknown: names whose value only the control knows.
        feed: F, MAX or AUTO; None: the block has none.
        compensation: R0, RL, RR; empty: the block has none.
        turn: 1 for DR+, -1 for DR-, 0: the block has none.
        ms: M function -> the words that belong to it.
    """

    values: dict[str, float] = field(default_factory=dict)
    unknown: list[str] = field(default_factory=list)
    feed: float | str | None = None
    compensation: str = ""
    turn: int = 0
    ms: dict[int, dict[str, float]] = field(default_factory=dict)

    def give_turn(self, sign: str) -> None:
        """DR+ or DR-."""
        self.turn = 1 if sign == "+" else -1

    def give_feed(self, name: str, number: float | None) -> None:
        """F with what follows it.

        Raises:
            ValueError: a second one, or one that is not read.
        """
        if name in ("MAX", "AUTO"):
            if self.feed != "F":
                raise ValueError(f"{name} without F before it")
            self.feed = name
        elif self.feed is not None:
            raise ValueError("F stands twice")
        elif name in ("FMAX", "FAUTO"):
            self.feed = name[1:]
        elif name != "F":
            raise ValueError(f"{name}: a feed by the turn, by the tooth or by the time", "Post F in mm/min.")
        else:
            self.feed = "F" if number is None else number

    def compensate(self, name: str, value: str) -> None:
        """R0, RL, RR, or R alone.

        Raises:
            ValueError: R with another number.
        """
        if name == "R" and value.strip("+ ") not in ("0", ""):
            raise ValueError(f"R{value}: R0, RL or RR is expected")
        self.compensation = name if name != "R" else "R0"


def blocks(lines: list[str], source: str) -> Iterator[tuple[int, str, str]]:
    """Line (from 1), text without number and comment, and comment of each block; continued lines are joined.

    A text that begins with '/' may be skipped at the machine.

    Raises:
        ReadError: a block goes on ('~') into one that is a block of its own.
    """
    begin, pending = 0, ""
    for count, raw in enumerate(lines, 1):
        text = raw.rstrip()
        if begin and _OWN.match(text):
            problem = f"the block goes on ('~') into line {count}, {shown(text)!r}, which is a block of its own"
            raise ReadError(source, begin, problem, "Take the last '~' of the block away.")
        goes_on = text.endswith("~")
        if not begin:
            head = _HEAD.match(text)
            at = head.end() if head else 0
            begin, pending = count, "/" if head and (head[1] or head[2]) else ""
            text = text[at:]
        text, comment = _split(text[:-1] if goes_on else text)
        text = text.strip()
        if text.endswith("~"):  # and its comment behind that
            goes_on, text = True, text[:-1].rstrip()
        pending += text if pending in ("", "/") else f" {text}"
        if not goes_on:
            yield begin, pending, comment
            begin, pending = 0, ""
    if begin:
        yield begin, pending, ""


def _split(text: str) -> tuple[str, str]:
    """A line and its comment, after ';' outside of quotes."""
    if ";" not in text:
        return text, ""
    if '"' not in text:
        plain, _, comment = text.partition(";")
        return plain, comment.strip("; -*")
    quoted = False
    for k, c in enumerate(text):
        if c == '"':
            quoted = not quoted
        elif c == ";" and not quoted:
            return text[:k], text[k:].strip("; -*")
    return text, ""


def words(text: str, parameters: QParameters, *, radius: bool = False) -> KlartextBlock:
    """The words behind L, C and their like.

    Args:
        text: in capitals, without the first word.
        parameters: what Q parameters stand for.
        radius: R with a value is a radius, not R0.

    Raises:
        ValueError: a word that is not known, or twice.
        ExpressionError: a value that only the control knows, where it matters.
    """
    block = KlartextBlock()
    belongs: tuple[int, list[str]] = 0, []
    for name, value, turn, other in _WORD.findall(text):
        if other:
            raise ValueError(f"{other!r} in {text.strip()[:60]!r}: no word of Klartext that is read")
        if turn:
            block.give_turn(turn)
            continue
        if belongs[0] and name in belongs[1]:
            block.ms[belongs[0]][name] = parameters.number(value) if value else float("inf")
            continue
        if name == "M":
            belongs = _m_function(block, value, parameters)
            continue
        if name != "MAX" and name != "AUTO":
            belongs = 0, []
        _put(block, name, value, parameters, radius=radius)
    if block.feed == "F":
        raise ValueError("F without a number, MAX or AUTO")
    return block


def _m_function(block: KlartextBlock, value: str, parameters: QParameters) -> tuple[int, list[str]]:
    number = parameters.number(value) if value else -1.0
    if number != int(number) or not 0 <= number < LARGEST:
        raise ValueError(f"M{value}: a whole number from 0 on is expected")
    m = int(number)
    block.ms.setdefault(m, {})
    return m, M_WORDS.get(m, "").split()


def _put(block: KlartextBlock, name: str, value: str, parameters: QParameters, *, radius: bool) -> None:
    if name in ("RL", "RR") or (name == "R" and (not radius or value.strip() == "0")):
        block.compensate(name, value)
    elif name[0] == "F" or name in ("MAX", "AUTO"):
        block.give_feed(name, parameters.number(value) if value else None)
    elif not value:
        raise ValueError(f"{name} without a value")
    elif name in block.values or name in block.unknown:
        raise ValueError(f"{name} stands twice")
    elif name[-1] in "ABC" and isinstance(parameters.operand(value), Runtime):
        block.unknown.append(name)
    else:
        number = parameters.number(value)
        if not abs(number) < LARGEST:
            raise ValueError(f"{name}{value[:20]}: beyond {LARGEST:g}")
        block.values[name] = number


def expected(text: str, pattern: re.Pattern[str], what: str) -> re.Match[str]:
    """The match of a whole block.

    Raises:
        ExpressionError: it has another form.
    """
    if match := pattern.fullmatch(text.strip()):
        return match
    raise ExpressionError(f"{text.strip()[:60]!r}: {what} is expected")

