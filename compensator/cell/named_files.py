"""The files that a cell names: what a run depends on besides its toolpath, and their hashes."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from compensator.cell.cell_file import Cell
from stiffness.model.model import builtin_model

DIGITS = 12  # of a shortened sha256: 48 bits tell files of one workshop apart


@dataclass(frozen=True)
class NamedFiles:
    """Files of a cell.

    Attributes:
        cell: the cell file; ``beside``: those that it names besides the model: robot, tables; ``model``.
    """

    cell: Path
    beside: tuple[Path, ...]
    model: Path

    @property
    def all(self) -> tuple[Path, ...]:
        """Every one of them."""
        return self.cell, *self.beside, self.model


def named_files(cell: Cell) -> NamedFiles:
    """The files that stand behind a cell; one that is not there is left out of ``beside``."""
    model = builtin_model(cell.model) or cell.folder / cell.model
    words = sorted({word for word in _words(cell.model_dump(exclude={"model"})) if "." in word and "\n" not in word})
    found = [cell.folder / word for word in words]
    return NamedFiles(Path(cell.source), tuple(p for p in found if _is_file(p)), model)


def sha256_of(paths: Iterable[Path]) -> str:
    """Hash of the contents of files in their order, shortened; names and folders take no part."""
    whole = hashlib.sha256()
    for path in paths:
        data = path.read_bytes()
        whole.update(len(data).to_bytes(8, "big") + data)
    return whole.hexdigest()[:DIGITS]


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # too long, or no name at all
        return False


def _words(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        for inner in value.values():
            yield from _words(inner)
    elif isinstance(value, list | tuple):
        for inner in value:
            yield from _words(inner)
