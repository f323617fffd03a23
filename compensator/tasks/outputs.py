"""Outputs: several files that appear together or not at all."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType

from compensator.errors import CompensatorError
from toolpaths.errors import ToolpathError


def refuse_clashes(inputs: Sequence[Path], outputs: Sequence[Path | None]) -> None:
    """Refuse to write over an input, or two outputs over each other.

    Raises:
        CompensatorError: names the file.
    """
    taken = {path.resolve(): "is an input of this run" for path in inputs}
    for path in outputs:
        if path is None:
            continue
        if path.resolve() in taken:
            raise CompensatorError(f"{path}: {taken[path.resolve()]}; give the output another name")
        taken[path.resolve()] = "is asked for twice"


class Outputs:
    """Stages files in a hidden folder beside their target and renames them into place at the end.

    Use as a context manager: leaving it without ``commit`` leaves nothing behind.
    """

    def __init__(self) -> None:
        self._folders: dict[Path, Path] = {}
        self._staged: list[tuple[Path, Path]] = []

    def __enter__(self) -> Outputs:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for folder in self._folders.values():
            shutil.rmtree(folder, ignore_errors=True)

    def folder(self, target: Path) -> Path:
        """Where files for the folder of ``target`` are staged; they keep their names.

        Raises:
            CompensatorError: the folder cannot be written to.
        """
        parent = target.resolve().parent
        if target.is_dir():
            raise CompensatorError(f"{target}: is a folder; expected the name of a file")
        if target.exists() and not target.is_file():
            raise CompensatorError(f"{target}: is a device or a pipe; outputs are renamed into place: name a file")
        if parent not in self._folders:
            try:
                self._folders[parent] = Path(tempfile.mkdtemp(prefix=".compensator-", dir=parent))
            except OSError as e:
                raise CompensatorError(f"{target}: cannot write there: {e.strerror or e}") from e
        return self._folders[parent]

    @contextmanager
    def writing(self, target: Path) -> Iterator[Path]:
        """The staged path of ``target``; a refusal from inside names ``target`` instead.

        Raises:
            CompensatorError: for any refusal of a writer or reader.
        """
        staged = self.folder(target) / target.name
        try:
            yield staged
        except (ToolpathError, CompensatorError) as e:
            shown = str(target)[: -len(target.name)]
            raise CompensatorError(str(e).replace(f"{staged.parent}{os.sep}", shown)) from e

    def text(self, target: Path, content: str) -> None:
        """Stage one text file."""
        staged = self.folder(target) / target.name
        try:
            with open(staged, "w", encoding="utf-8", newline="\n") as stream:
                stream.write(content)
                stream.flush()
                os.fsync(stream.fileno())
        except OSError as e:
            raise CompensatorError(f"{target}: cannot be written: {e.strerror or e}. Nothing was changed") from e
        self.add(staged, target)

    def add(self, staged: Path, target: Path) -> None:
        """Take up a file that something else wrote into ``folder(target)``; a symbolic link stays one."""
        self._staged.append((staged, target.resolve()))

    def commit(self) -> None:
        """Rename everything into place; on a failure or an interrupt put back what stood there before."""
        done: list[tuple[Path, Path, bool]] = []
        try:
            for staged, target in self._staged:
                old = staged.with_name(staged.name + ".old")
                done.append((target, old, target.exists()))
                if target.exists():
                    os.replace(target, old)
                os.replace(staged, target)
        except BaseException as e:
            for place, old, existed in reversed(done):
                if old.exists():
                    os.replace(old, place)
                elif not existed:
                    place.unlink(missing_ok=True)
            if not isinstance(e, OSError):
                raise
            why = e.strerror or e
            raise CompensatorError(f"{target}: cannot be put in place: {why}. Nothing was changed") from e
