"""KRL text as subprograms and declarations, each with its place in the text."""

from __future__ import annotations

import re
from bisect import bisect_right
from typing import NoReturn

from toolpaths.errors import ReadError
from toolpaths.interpreting.program_text import (
    CHOICE,
    COMMENT,
    LOOP,
    NOTHING,
    PLAIN,
    Declaration,
    ProgramText,
    Statement,
)
from toolpaths.languages.krl.remarks import SWALLOWING

_LINE = re.compile(r"[^\r\n\f\x1a]+")
_CODE = re.compile(r'(?:[^;"]++|"[^"]*+"|"[^"]*+$)*+')
_DEF = re.compile(r"(?:GLOBAL\s+)?DEF\s+([A-Za-z_$][\w$]*)\s*\(([^)]*)\)\s*$", re.I)
_DEFFCT = re.compile(r"(?:GLOBAL\s+)?DEFFCT\s", re.I)
_DECLARED = re.compile(
    r"(?:(?:DECL|GLOBAL|CONST)\s+)*([A-Za-z_]\w*)\s+([A-Za-z_$][\w$]*)\s*(\[[^\]]*\])?\s*(?:=\s*(?=\S)|$)", re.I
)
_SEVERAL = re.compile(
    r"(?:(?:DECL|GLOBAL|CONST)\s+)*([A-Za-z_]\w*)\s+((?:[A-Za-z_$][\w$]*\s*(?:\[[^\]]*\]\s*)?(?:,\s*(?=\S)|$)){2,})$",
    re.I,
)
_GLOBAL = re.compile(r"(?:DECL\s+)?GLOBAL\s", re.I)
_INDEX = re.compile(r"\[[^\]]*\]")
_DECL = re.compile(r"(?:DECL|INT|REAL|BOOL|CHAR|FRAME|POS|E6POS|AXIS|E6AXIS|GLOBAL\s+DECL)\s", re.I)
_MOVES = re.compile(r"S?(?:PTP|LIN|CIRC)(?:_REL)?\b|SPLINE")
_IF = re.compile(r"IF\s+(.*\S)\s+THEN\s*$|IF\s*(\(.*\))\s*THEN\s*$", re.I)
_FOR = re.compile(r"FOR\s+([A-Za-z_]\w*)\s*=\s*(.*?)\s+TO\s+(.*?)(?:\s+STEP\s+(.*?))?\s*$", re.I)
_WORD = re.compile(r"[A-Za-z_$&#]+\w*")
_LABEL = re.compile(r"[A-Za-z_]\w*\s*:$")
REFUSED_BLOCKS = {
    "WHILE": "a loop that ends when a condition says so", "REPEAT": "a loop that ends when a condition says so",
    "LOOP": "a loop without end", "GOTO": "a jump",
    "SPLINE": "a spline block",
}  # fmt: skip
_ENDS = frozenset(("END", "ENDFCT", "ELSE", "ENDIF", "ENDFOR", "ENDSWITCH"))
_CASES = frozenset(("CASE", "DEFAULT"))
_DEEPEST = 60


class KrlModule(ProgramText):
    """A .src with the text of its .dat behind it, scanned.

    Args:
        text: of the .src, one character a byte.
        source: its name, as the user gave it.
        values: text of the .dat.
        beside: name of the .dat.

    Attributes:
        border: where the .dat begins.
        declared: name, upper case -> Declaration.
        routines: name, upper case -> statements; ``first`` is the one that is run, its head ends at ``header_end``.
        shared: routines that other files may call: the first, and those that are GLOBAL.

    Raises:
        ReadError: no DEF, or a file that is cut off.
    """

    def __init__(self, text: str, source: str, values: str = "", beside: str = "") -> None:
        super().__init__(text + "\n" + values, source)
        self.border, self.beside = len(text), beside
        self.declared: dict[str, Declaration] = {}
        self.routines: dict[str, list[Statement]] = {}
        self.shared: set[str] = set()
        self.first = ""
        self.header_end = 0
        self._depth = 0
        self._codes = self._code(3 if text.startswith("\xef\xbb\xbf") else 0, self.border)
        self._at = 0
        self._scan()

    def file(self, at: int) -> str:
        """The .src or the .dat, as messages have it."""
        return self.beside if at > self.border else self.source

    def line(self, at: int) -> int:
        """The line of a place in its file, counted from 1."""
        n = super().line(at)
        return n - bisect_right(self._lines, self.border + 1) if at > self.border else n

    def refuse(self, at: int, problem: str, remedy: str = "") -> NoReturn:
        """Raise ReadError for a place in the text."""
        raise ReadError(self.file(at), self.line(at), problem, remedy)

    def _code(self, first: int, last: int) -> list[tuple[int, int, bool]]:
        """Start and end of the code of every line that has some, and of comments (True)."""
        out = []
        for found in _LINE.finditer(self.text, first, last):
            whole, start = found[0], found.start()
            code = whole
            if ";" in whole and (match := _CODE.match(whole)):
                code = match[0]
            if bare := code.strip():
                at = start + len(code) - len(code.lstrip())
                out.append((at, at + len(bare), False))
            elif len(code) < len(whole):
                out.append((start + len(code), found.end(), True))
        return out

    def _scan(self) -> None:
        """Find subprograms and declarations."""
        for start, end, comment in self._code(self.border + 1, len(self.text)):
            if not comment:
                self._declaration(start, end)
        while self._at < len(self._codes):
            start, end, comment = self._codes[self._at]
            text = self.text[start:end]
            self._at += 1
            if comment or text.startswith("&"):
                continue
            if match := _DEF.match(text):
                self._subprogram(match, start, end)
            elif _DEFFCT.match(text):
                self._function()
            elif text.upper().startswith("EXT"):
                continue
            else:
                remedy = "Give the .src of one program."
                self.refuse(start, f"{text[:40]!r}: a KRL program begins with DEF and ends with END", remedy)
        if not self.first:
            raise ReadError(self.source, None, "no DEF: not a KRL program", "Give the .src of one program.")

    def _function(self) -> None:
        """Pass over a function: what it gives is not known before it runs, and it must not move the arm."""
        while self._at < len(self._codes) and self._upper(self._at) != "ENDFCT":
            if _MOVES.match(self._upper(self._at)):
                self.refuse(self._codes[self._at][0], "a function that moves the arm", "Make it a subprogram.")
            self._at += 1
        self._at += 1

    def _upper(self, index: int) -> str:
        start, end, comment = self._codes[index]
        return "" if comment else self.text[start:end].upper()

    def _declaration(self, start: int, end: int) -> bool:
        """Take over the names that a line declares: one with its value, or several without."""
        if match := _DECLARED.match(self.text, start, end):
            if match[2].upper() not in self.declared or "=" in match[0] or start > self.border:
                self._declare(
                    match[1], name=match[2], start=start, end=end, value=match.end() if "=" in match[0] else -1
                )
            return True
        if match := _SEVERAL.match(self.text, start, end):
            for name in _INDEX.sub("", match[2]).split(","):
                bare = name.strip()
                if bare.upper() not in self.declared or start > self.border:
                    self._declare(match[1], name=bare, start=start, end=end, value=-1)
        return match is not None

    def _declare(self, kind: str, name: str, start: int, end: int, value: int) -> None:
        if name.upper() in self.declared:
            first = self.line(self.declared[name.upper()].start)
            self.refuse(start, f"{name} is declared twice, first in line {first}", "Keep one of them.")
        place = (value, end) if value >= 0 else (-1, -1)
        storage = "GLOBAL" if _GLOBAL.match(self.text, start, end) else ""
        self.declared[name.upper()] = Declaration(
            type=kind.upper(), name=name, start=start, end=end, value=place, storage=storage
        )

    def _subprogram(self, match: re.Match[str], start: int, end: int) -> None:
        name = match[1].upper()
        if name in self.routines:
            self.refuse(start, f"DEF {match[1]} stands twice", "Two programs in one file: give one of them.")
        body, _ = self._block(("END",), start, "END")
        if not self.first:
            self.first, self.header_end = name, end
        if name == self.first or match[0].upper().startswith("GLOBAL"):
            self.shared.add(name)
        self.routines[name] = body
        if match[2].strip():
            self.routines[name] = []

    def _block(self, ends: tuple[str, ...], begin: int, last: str) -> tuple[list[Statement], str]:
        """Statements up to the line that ends the block, and that line in upper case."""
        out: list[Statement] = []
        self._depth += 1
        if self._depth > _DEEPEST:
            self.refuse(begin, f"blocks more than {_DEEPEST} deep")
        while self._at < len(self._codes):
            start, end, comment = self._codes[self._at]
            self._at += 1
            if comment:
                out.append(Statement(COMMENT, start, end, self.text[start + 1 : end].strip()))
                continue
            text = self.text[start:end]
            word = text.upper()
            if word in ends or word.split(maxsplit=1)[0] in _CASES & set(ends):
                self._refuse_swallowed(start, text)
                self._depth -= 1
                return out, word
            if word in _ENDS or word.split(maxsplit=1)[0] in _CASES or _DEF.match(text):
                self.refuse(start, f"{text[:30]}, but {last} is missing before it", "The file may be cut off.")
            out.append(self._statement(start, end, text))
        remedy = "Give the whole file." + (" Where the post leaves END out, put it there." if last == "END" else "")
        self.refuse(begin, f"the file is cut off: {last} is missing", remedy)

    def _statement(self, start: int, end: int, text: str) -> Statement:
        word = _WORD.match(text)
        first = word[0].upper() if word else ""
        if first in REFUSED_BLOCKS:
            why = f"{first}: {REFUSED_BLOCKS[first]}: not known before it runs"
            self.refuse(start, why, "Write the moves one by one.")
        if first == "FOR":
            return self._loop(start, text)
        if first == "IF":
            return self._choice(start, text)
        if first == "SWITCH":
            return self._switch(start, text[len(first) :].strip())
        if _LABEL.match(text):  # GOTO is refused: nothing comes here by a jump
            return Statement(NOTHING, start, start)
        if _DECL.match(text) and self._declaration(start, end):
            self._refuse_swallowed(start, text)
            return Statement(NOTHING, start, start)
        return Statement(PLAIN, start, end)

    def _refuse_swallowed(self, start: int, text: str) -> None:
        if problem := SWALLOWING.problem(text):
            self.refuse(start, problem, SWALLOWING.remedy)

    def _loop(self, start: int, text: str) -> Statement:
        match = _FOR.match(text)
        if not match:
            self.refuse(start, "FOR needs a variable, = , TO")
        body, _ = self._block(("ENDFOR",), start, "ENDFOR")
        terms = (match[1].upper(), match[2], match[3], match[4] or "")
        return Statement(LOOP, start, start, body=body, terms=terms)

    def _choice(self, start: int, text: str) -> Statement:
        match = _IF.match(text)
        if not match:
            self.refuse(start, "IF without THEN at the end of the line")
        out = Statement(CHOICE, start, start)
        body, end = self._block(("ELSE", "ENDIF"), start, "ENDIF")
        out.body.append(Statement(CHOICE, start, start, body=body, terms=(match[1] or match[2],)))
        if end == "ELSE":
            body, _ = self._block(("ENDIF",), start, "ENDIF")
            out.body.append(Statement(CHOICE, start, start, body=body, terms=("TRUE",)))
        return out

    def _switch(self, start: int, chosen: str) -> Statement:
        """SWITCH as a choice: a case holds where one of its values is that of ``chosen``."""
        out = Statement(CHOICE, start, start)
        before, end = self._block(("CASE", "DEFAULT", "ENDSWITCH"), start, "ENDSWITCH")
        if not chosen or any(s.kind not in (COMMENT, NOTHING) for s in before):
            self.refuse(start, "SWITCH needs a value, then CASE")
        while end != "ENDSWITCH":
            at = self._codes[self._at - 1][0]
            values = end.removeprefix("CASE").strip()
            if end.startswith("CASE") and not values:
                self.refuse(at, "CASE without a value")
            condition = "TRUE" if end == "DEFAULT" else " OR ".join(f"({chosen})==({v})" for v in values.split(","))
            body, end = self._block(("CASE", "DEFAULT", "ENDSWITCH"), start, "ENDSWITCH")
            out.body.append(Statement(CHOICE, at, at, body=body, terms=(condition,)))
        return out
