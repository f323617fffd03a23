"""KrlProgram: a .src and those that it calls, read together; each .src with its .dat is a module of its own."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from toolpaths.errors import ReadError
from toolpaths.interpreting.program_text import Declaration, LinkedText, Statement
from toolpaths.languages.krl.scan import KrlModule
from toolpaths.reading.source_text import load_lines


class KrlProgram(LinkedText):
    """Modules, the main one first.

    Args:
        main: the module whose first DEF is run.
        path: its file.
        others: the other files of the program; None: those beside ``path``.

    Attributes:
        declared: per module: name, upper case -> Declaration.
        shared: GLOBAL names of all modules.
    """

    def __init__(self, main: KrlModule, path: Path, others: Sequence[Path] | None = None) -> None:
        super().__init__(main)
        self.modules: list[KrlModule] = []
        self.declared: list[dict[str, Declaration]] = []
        self.shared: dict[str, Declaration] = {}
        self._path, self._others = path, others
        self._join(main)

    @property
    def first(self) -> str:
        """The routine that is run."""
        return self.modules[0].first

    def _join(self, module: KrlModule) -> None:
        """A module joins: its places count in the whole from here on."""
        by = self.begins[-1]
        self.modules.append(module)
        for d in module.declared.values():
            d.move(by)
        for s in (s for body in module.routines.values() for s in body if by):
            s.move(by)
        self.declared.append(module.declared)
        self.shared |= {key: d for key, d in module.declared.items() if d.storage == "GLOBAL"}

    def routine(self, name: str, module: int) -> tuple[list[Statement], int] | None:
        """Statements and module of a subprogram as it is called in ``module``; its file is read where it has to be.

        Raises:
            ReadError: the file beside that has the name is refused.
        """
        if name in self.modules[module].routines:
            return self.modules[module].routines[name], module
        for number, other in enumerate(self.modules):
            if name in other.shared:
                return other.routines[name], number
        file = self._file(name)
        if file is None:
            return None
        loaded = module_of(file.read_bytes(), str(file), file)
        if loaded.first != name:
            problem = f"{name}() is called, and this file begins with DEF {loaded.first}"
            remedy = "A file has the name of its program."
            raise ReadError(str(file), loaded.line(loaded.header_end - 1), problem, remedy)
        self.add(loaded)
        self._join(loaded)
        return loaded.routines[name], len(self.modules) - 1

    def _file(self, name: str) -> Path | None:
        if self._others is not None:
            files = list(self._others)
        elif self._path.parent.is_dir():
            files = list(self._path.parent.iterdir())
        else:
            return None
        return next((f for f in sorted(files) if f.stem.upper() == name and f.suffix.lower() == ".src"), None)

    def scope(self, d: Declaration) -> tuple[int, int]:
        """Where a declared name is known: in its module; one that is GLOBAL in all of them."""
        if d.storage == "GLOBAL":
            return 0, len(self.text)
        k = self.part(d.start)
        return self.begins[k], self.begins[k] + len(self.modules[k].text)


def module_of(data: bytes, source: str, path: Path) -> KrlModule:
    """A .src with the .dat beside it, scanned.

    Raises:
        ReadError: one of them is no KRL.
    """
    beside = next((p for p in (path.with_suffix(".dat"), path.with_suffix(".DAT")) if p.is_file()), None)
    values = ""
    if beside is not None:
        load_lines(beside, str(beside))
        values = beside.read_bytes().decode("latin-1")
    return KrlModule(data.decode("latin-1"), source, values, "" if beside is None else str(beside))
