"""RapidProgram: the modules that a program needs, read together; what is not LOCAL is known in all of them.

The controller loads all modules of a task. Here the main one is given, and another one joins when a name is asked for
that it declares: from the files that were named, else from those in the folder.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from toolpaths.errors import ReadError
from toolpaths.interpreting.program_text import Declaration
from toolpaths.interpreting.reread_text import RereadText
from toolpaths.interpreting.statements import Statements
from toolpaths.languages.rapid.scan import RapidModule
from toolpaths.reading.source_text import load_lines

SUFFIXES = (".mod", ".modx", ".prg", ".sys", ".sysx")
_DECLARED = re.compile(
    r"^[ \t]*+(?:TASK[ \t]++)?"
    r"(?:(?:CONST|PERS|VAR)[ \t]++\w++[ \t]++(\w++)|(?:PROC|FUNC[ \t]++\w++)[ \t]++(\w++)[ \t]*\()",
    re.I | re.M,
)
_MOVING = re.compile(r"^[ \t]*+(?:Move|Trigg|Search|Arc|Spot|Paint|Disp)[A-Za-z]*\s", re.I | re.M)
_END = re.compile(r"\bENDPROC\b", re.I)


class RapidProgram(RereadText):
    """Modules, the main one first; names are in lower case.

    Args:
        main: the module that everything starts from.
        others: the files of the program; None: those in the folder of ``folder`` (a file), main aside.
        folder: where main lies; None: it stands alone.

    Attributes:
        data: names that all modules know.
        local: names that only the module of this number knows.
        inner: declarations in routines, by their place.
    """

    def __init__(self, main: RapidModule, others: Sequence[Path] | None = None, folder: Path | None = None) -> None:
        super().__init__(main)
        self.modules: list[RapidModule] = []
        self.data: dict[str, Declaration] = {}
        self.local: list[dict[str, Declaration]] = []
        self.inner: dict[int, Declaration] = {}
        self._routines: dict[str, int] = {}  # what all modules may call -> module
        self._others, self._folder = others, folder
        self._index: dict[str, list[Path]] | None = None
        self.unread: dict[Path, str] = {}  # file beside that cannot be read, and why
        self._loaded: set[Path] = set()
        self._join(main)

    def _join(self, module: RapidModule) -> None:
        """A module joins: its places count in the whole from here on."""
        number, by = len(self.modules), self.begins[-1]
        module.forget_text()  # the whole has it: once is enough
        self.modules.append(module)
        local: dict[str, Declaration] = {}
        for key, d in module.data.items():
            d.move(by)
            if key in module.local:
                local[key] = d
            elif key in self.data:
                self.refuse(d.start, f"{d.name} is declared in {self.file(self.data[key].start)} as well")
            else:
                self.data[key] = d
        for d in module.inner.values():
            d.move(by)
            self.inner[d.start] = d
        for table in (module.routines, module.with_arguments):
            for name, body in table.items():
                if by:
                    body.move(by)
                if name not in module.local and self._routines.setdefault(name, number) != number:
                    other = self.modules[self._routines[name]].source
                    self.refuse(by, f"PROC {name} stands in {other} as well", "Give the files of one program.")
        self.local.append(local)

    def declarations(self) -> Iterator[Declaration]:
        """All declarations, also those in routines."""
        yield from self.data.values()
        for local in self.local:
            yield from local.values()
        yield from self.inner.values()

    def scope(self, d: Declaration) -> tuple[int, int]:
        """Where a declared name is known: in its module, or in all of them."""
        k = self.part(d.start)
        if d.start not in self.inner and d.name.lower() not in self.modules[k].local:
            return 0, self.length
        return self.begins[k], self.begins[k] + len(self.text_of(k))

    def forget_routines(self) -> None:
        """They have run: their statements are not needed any more."""
        for module in self.modules:
            module.routines.clear()
            module.with_arguments.clear()

    def routine(self, name: str, module: int) -> tuple[Statements, int] | None:
        """Statements and module of a routine without arguments, as it is called in ``module``."""
        home = self._home(name, module)
        body = None if home is None else self.modules[home].routines.get(name)
        return None if body is None or home is None else (body, home)

    def with_arguments(self, name: str, module: int) -> Statements | None:
        """Statements of a routine with arguments."""
        home = self._home(name, module)
        return None if home is None else self.modules[home].with_arguments.get(name)

    def is_function(self, name: str) -> bool:
        """Whether a module that was read has a function of this name."""
        return any(name in module.functions for module in self.modules)

    def _home(self, name: str, module: int) -> int | None:
        own = self.modules[module]
        if name in own.routines or name in own.with_arguments:
            return module
        return self._routines.get(name)

    # --- files beside ------------------------------------------------------------------------------------------

    def find(self, name: str) -> bool:
        """Let the module join that declares a name, which no module so far does; whether there is one.

        Raises:
            ReadError: several files declare it.
        """
        if self._index is None:
            self._index = self._declared_beside()
        files = self._index.get(name.lower(), [])
        if not files:
            return False
        if len(files) > 1:
            shown = ", ".join(file.name for file in files)
            problem = f"{name} is declared in several files: {shown}"
            raise ReadError(self.source, None, problem, "Name the files of the program, one behind the other.")
        return self._load(files[0])

    def _load(self, file: Path) -> bool:
        if file in self.unread or file in self._loaded:
            return False
        self._loaded.add(file)
        shown = str(file)
        try:
            load_lines(file, shown)
            module = RapidModule(file.read_bytes().decode("latin-1"), shown)
        except ReadError as problem:
            if self._others is not None:
                raise
            self.unread[file] = str(problem)
            return False
        self.add(module)
        self._join(module)
        return True

    def moves_beside(self, name: str) -> str | None:
        """The refusal of a file that cannot be read and holds a routine that moves the arm; None: there is none."""
        for file in (self._index or {}).get(name.lower(), []):
            if file in self.unread:
                text = file.read_bytes().decode("latin-1")
                begin = re.compile(rf"^[ \t]*PROC[ \t]+{re.escape(name)}\b", re.I | re.M).search(text)
                end = _END.search(text, begin.end()) if begin else None
                if begin and _MOVING.search(text, begin.end(), end.start() if end else len(text)):
                    return self.unread[file]
        return None

    def _declared_beside(self) -> dict[str, list[Path]]:
        """Names of the other modules -> files."""
        out: dict[str, list[Path]] = {}
        for file in self._candidates():
            names = {(a or b).lower() for a, b in _DECLARED.findall(file.read_bytes().decode("latin-1"))}
            if self._others is None and "main" in names and "main" in self.modules[0].routines:
                continue  # another program
            for name in names:
                out.setdefault(name, []).append(file)
        return out

    def _candidates(self) -> list[Path]:
        if self._others is not None:
            return list(self._others)
        if self._folder is None or not self._folder.parent.is_dir():
            return []
        beside = sorted(self._folder.parent.iterdir())
        return [f for f in beside if f.suffix.lower() in SUFFIXES and f.name != self._folder.name and f.is_file()]
