"""RAPID text as declarations and routines, each with its place in the text.

Source: ABB 3HAC16585 "RAPID kernel" (grammar), 3HAC16580 "RAPID overview".
"""

from __future__ import annotations

import re

from toolpaths.interpreting.program_text import (
    CHOICE,
    COMMENT,
    DATA,
    LOOP,
    PLAIN,
    Declaration,
    ProgramText,
    Statement,
)
from toolpaths.interpreting.statements import Statements
from toolpaths.languages.rapid.tails import PIECE, ends_value, is_name, refuse_second

_SKIP = re.compile(r"(?:[\s\x1a]++|![^\n\r]*+)*+")
_WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*+")
_REST = re.compile(r'(?:[^;"!]++|"(?:[^"\n\r]|"")*+"|![^\n\r]*+)*+;')
_HEAD = re.compile(r"\s*%%%.*?%%%", re.S)
_MODULE = re.compile(r"\s+([A-Za-z]\w*)(?:[ \t]*\([A-Za-z, \t]*\))?")
_PROC = re.compile(r"\s+([A-Za-z]\w*)\s*\(([^)]*)\)")
_MOVES = re.compile(r"^[ \t]*((?:Move|Trigg|Search)[A-Z]\w*)\s", re.I | re.M)
_DATA = re.compile(r"\s+([A-Za-z]\w*)\s+([A-Za-z]\w*)\s*(\{[^}]*\})?\s*(:=)?")
_FOR = re.compile(r"\s+([A-Za-z]\w*)\s+FROM\s+(.*?)\s+TO\s+(.*?)(?:\s+STEP\s+(.*?))?\s+DO(?!\w)", re.I | re.S)
_IF = re.compile(r'\s*+((?:[^;"]|"[^"\n\r]*+")*?)(?<!\w)THEN(?!\w)', re.I)
_LABEL = re.compile(r"[ \t]*:(?!=)")
_ENDS = {
    "IF": ("ELSEIF", "ELSE", "ENDIF"), "FOR": ("ENDFOR",), "TEST": ("CASE", "DEFAULT", "ENDTEST"),
    "PROC": ("ENDPROC", "ERROR", "UNDO", "BACKWARD"),
}  # fmt: skip
_REFUSED = {
    "WHILE": "a loop that ends when a condition says so", "GOTO": "a jump", "CONNECT": "an interrupt",
}  # fmt: skip
_BLOCKS = ("IF", "FOR", "TEST", "PROC")
_CHOICES = ("ELSE", "ELSEIF", "CASE", "DEFAULT")
_ELSEWHERE = frozenset(("MODULE", "ENDMODULE", "PROC", *_CHOICES, *(f"END{word}" for word in _BLOCKS)))
_CASE = re.compile(r"\s++([^:;]*+):(?!=)")
_TESTED = re.compile(r"\s++([^;]*?)\s(?=(?:CASE|DEFAULT|ENDTEST)(?!\w))", re.I)
_DEEPEST = 60


class RapidModule(ProgramText):
    """The module of a file, scanned; names are in lower case.

    Attributes:
        name: of the module, as written; behind it, at ``body_at``, its declarations begin.
        data: declarations of the module; ``inner`` are those inside routines, by their place.
        routines: those without arguments; ``shown`` are their names as written.
        with_arguments: routines with arguments.
        local: names of data and routines that other modules do not know.
        functions: names of functions.

    Raises:
        ReadError: no module, more than one, or a file that is cut off.
    """

    def __init__(self, text: str, source: str) -> None:
        super().__init__(text, source)
        self.name, self.body_at = "", 0
        self.data: dict[str, Declaration] = {}
        self.inner: dict[int, Declaration] = {}
        self.routines: dict[str, Statements] = {}
        self.shown: dict[str, str] = {}
        self.functions: set[str] = set()
        self.local: set[str] = set()
        self.with_arguments: dict[str, Statements] = {}
        self._at = 3 if text.startswith("\xef\xbb\xbf") else 0
        self._depth = 0
        self._scan()

    def _scan(self) -> None:
        if head := _HEAD.match(self.text, self._at):
            self._at = head.end()
        word = self._word()
        if word != "MODULE":
            shown = self.text[self._at :][:30].split("\n")[0].strip()
            self.refuse(self._at, f"{shown!r}: a RAPID file begins with MODULE", "Give a .mod or .prg file.")
        match = _MODULE.match(self.text, self._at + len(word))
        if not match:
            self.refuse(self._at, "MODULE without a name")
        self.name, self._at = match[1], match.end()
        self.body_at = self._at
        while (word := self._word()) != "ENDMODULE":
            self._module_part(word)
        after = _SKIP.match(self.text, self._at + len(word))
        if after and after.end() < len(self.text):
            self.refuse(after.end(), "text after ENDMODULE", "Two programs in one file: give one module a file.")

    def _word(self, comments: Statements | None = None) -> str:
        """The next word in upper case; ``at`` is its beginning. A file that ends after a routine counts as whole."""
        skipped = _SKIP.match(self.text, self._at)
        begin = self._at
        if skipped:
            self._at = skipped.end()
        if comments is not None and "!" in self.text[begin : self._at]:
            for found in re.finditer(r"!([^\n\r]*)", self.text[begin : self._at]):
                comments.append(Statement(COMMENT, begin + found.start(), begin + found.end(), found[1].strip()))
        match = _WORD.match(self.text, self._at)
        if match:
            return match[0].upper()
        if self._at >= len(self.text):
            if comments is None and self.routines and self.text[-1] in "\n\r":
                return "ENDMODULE"
            self.refuse(len(self.text) - 1, "the file is cut off: ENDMODULE is missing", "Give the whole file.")
        shown = self.text[self._at :].splitlines()[0].strip()[:40]
        if shown.startswith("%"):
            self.refuse(self._at, f"{shown!r}: the routine is known only at run time", "Call it by its name.")
        self.refuse(self._at, f"{shown!r} is no RAPID instruction")

    def _module_part(self, word: str) -> None:
        start, local = self._at, False
        while word in ("LOCAL", "TASK"):
            local = local or word == "LOCAL"
            self._at += len(word)
            word = self._word()
        if word in ("CONST", "PERS", "VAR"):
            d = self._declaration(start, word)
            self._declare(self.data, d)
            self.local.update([d.name.lower()] if local else [])
        elif word == "PROC":
            name = self._routine()
            self.local.update([name] if local else [])
        elif word in ("FUNC", "TRAP", "RECORD"):
            self._skip_to("END" + word)
        elif word == "ALIAS":
            self._statement(word)
        else:
            self.refuse(self._at, f"{self.text[self._at :].split()[0][:40]!r} between the routines of a module")

    def _declare(self, table: dict[str, Declaration], d: Declaration) -> None:
        if d.name.lower() in table:
            first = self.line(table[d.name.lower()].start)
            self.refuse(d.start, f"{d.name} is declared twice, first in line {first}", "Keep one of them.")
        table[d.name.lower()] = d

    def _declaration(self, start: int, storage: str) -> Declaration:
        match = _DATA.match(self.text, self._at + len(storage))
        if not match:
            self.refuse(self._at, f"{storage} needs a type and a name")
        rest = _REST.match(self.text, match.end())
        if not rest:
            self.refuse(self._at, f"the declaration of {match[2]} has no end (;)", "The file may be cut off.")
        self._at = rest.end()
        if self.text.find("\n", match.end(), self._at) >= 0:
            refuse_second(self, start, match.end(), self._at)
        value = (match.end(), rest.end() - 1) if match[4] else (-1, -1)
        if not match[4] and self.text[match.end() : rest.end() - 1].strip():
            self.refuse(match.end(), f"{match[2]}: ':=' or ';' expected")
        return Declaration(
            type=match[1].lower(), name=match[2], start=start, end=self._at, value=value, storage=storage,
            array=match[3] is not None,
        )  # fmt: skip

    def _routine(self) -> str:
        """Take over a routine; its name."""
        match = _PROC.match(self.text, self._at + 4)
        if not match:
            self.refuse(self._at, "PROC without name and ()")
        name = match[1]
        if name.lower() in self.routines:
            self.refuse(self._at, f"PROC {name} stands twice in the module", "Keep one of them.")
        self._at = match.end()
        body, end = self._block("PROC")
        if end != "ENDPROC":
            self._skip_to("ENDPROC")
        if match[2].strip():
            self.with_arguments[name.lower()] = body
            return name.lower()
        self.routines[name.lower()] = body
        self.shown[name.lower()] = name
        return name.lower()

    def _skip_to(self, end: str) -> None:
        begin = self._at
        name = re.compile(r"\w+\s+(?:\w+\s+)?(\w+)").match(self.text, begin)
        self._at += 1
        pattern = re.compile(r'![^\n\r]*+|"[^"\n\r]*+"|(?<!\w)' + end + r"(?!\w)", re.I)
        for found in pattern.finditer(self.text, self._at):
            if found[0].upper() == end:
                self._at = found.end()
                if name and end == "ENDFUNC":
                    self.functions.add(name[1].lower())
                    if moves := _MOVES.search(self.text, begin, found.start()):
                        self.refuse(moves.start(1), f"the function {name[1]} moves the arm", "Make it a PROC.")
                return
        self.refuse(begin, f"{end} is missing", "The file may be cut off.")

    def _block(self, kind: str) -> tuple[Statements, str]:
        """Statements up to the word that ends the block, and that word; ``at`` is behind it."""
        out = Statements()
        ends = _ENDS[kind]
        self._depth += 1
        if self._depth > _DEEPEST:
            self.refuse(self._at, f"blocks more than {_DEEPEST} deep")
        while (word := self._word(out)) not in ends:
            if word in _ELSEWHERE:
                self.refuse(self._at, f"{word}, but {ends[-1] if kind != 'PROC' else ends[0]} is missing before it")
            out.append(self._statement(word))
        self._depth -= 1
        self._at += len(word)
        return out, word

    def _statement(self, word: str) -> Statement:
        start, shown = self._at, self.text[self._at : self._at + len(word)]
        if word in ("CONST", "PERS", "VAR"):
            d = self._declaration(start, word)
            self.inner.setdefault(start, d)
            return Statement(DATA, start, self._at)
        if word == "FOR":
            return self._loop(start)
        if word == "IF":
            return self._choice(start)
        if word == "TEST":
            return self._test(start)
        if label := _LABEL.match(self.text, start + len(word)):  # GOTO is refused: nothing comes here by a jump
            self._at = label.end()
            return Statement(COMMENT, start, self._at, shown)
        if word in _REFUSED:
            self.refuse(start, f"{shown}: {_REFUSED[word]} is not known before it runs", "Write the moves one by one.")
        rest = _REST.match(self.text, start + len(word))
        if not rest:
            self.refuse(start, f"{shown}: the instruction has no end (;)", "The file may be cut off.")
        self._at = rest.end()
        if not word.startswith("MOVE"):
            refuse_second(self, start, start + len(word), self._at)
        return Statement(PLAIN, start, self._at, shown)

    def _loop(self, start: int) -> Statement:
        match = _FOR.match(self.text, start + 3)
        if not match:
            self.refuse(start, "FOR needs FROM, TO and DO")
        self._at = match.end()
        body, _ = self._block("FOR")
        terms = (match[1], match[2], match[3], match[4] or "")
        return Statement(LOOP, start, self._at, body=list(body), terms=terms)

    def _choice(self, start: int) -> Statement:
        branches: list[Statement] = []
        at = start + 2
        while True:
            match = _IF.match(self.text, at)
            if not match:
                return self._short_choice(start, at)
            self._at = match.end()
            body, end = self._block("IF")
            branches.append(Statement(CHOICE, start, self._at, body=list(body), terms=(match[1],)))
            if end == "ELSE":
                body, end = self._block("IF")
                branches.append(Statement(CHOICE, start, self._at, body=list(body), terms=("TRUE",)))
            if end == "ENDIF":
                return Statement(CHOICE, start, self._at, body=branches)
            at = self._at

    def _short_choice(self, start: int, at: int) -> Statement:
        """``IF condition instruction;``: a condition ends where a name follows a value."""
        ended, word = False, ";"
        for piece in PIECE.finditer(self.text, at):
            word = piece[0].upper()
            if word[0] == "!":
                continue
            if word == ";" or (ended and is_name(word)):
                break
            ended = ends_value(word)
        if word == ";" or not ended:
            self.refuse(start, "IF needs a condition, then THEN or one instruction")
        self._at = piece.start()
        first = self._word()
        if first in _BLOCKS or first in _ELSEWHERE:
            self.refuse(start, f"IF with {first} behind its condition: one instruction is expected, or THEN")
        inner = self._statement(first)
        branch = Statement(CHOICE, start, self._at, body=[inner], terms=(self.text[at : piece.start()],))
        return Statement(CHOICE, start, self._at, body=[branch])

    def _test(self, start: int) -> Statement:
        """TEST as a choice: a case holds where one of its values is that of what is tested."""
        match = _TESTED.match(self.text, start + 4)
        if not match:
            self.refuse(start, "TEST needs a value, then CASE")
        self._at = match.end()
        branches, end = [], self._word()
        self._at += len(end)
        while end != "ENDTEST":
            case = _CASE.match(self.text, self._at) if end == "CASE" else re.compile(r"\s*:").match(self.text, self._at)
            if not case:
                self.refuse(self._at, f"{end} needs {'values and ' if end == 'CASE' else ''}a colon")
            values = case[1].split(",") if end == "CASE" else []
            condition = " OR ".join(f"({match[1]})=({v})" for v in values) or "TRUE"
            self._at = case.end()
            body, end = self._block("TEST")
            branches.append(Statement(CHOICE, start, self._at, body=list(body), terms=(condition,)))
        return Statement(CHOICE, start, self._at, body=branches)
