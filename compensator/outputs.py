"""Outputs: several files that appear together or not at all."""

from __future__ import annotations

import os
import shutil
import tempfile
from pathlib import Path
from types import TracebackType

from compensator.errors import CompensatorError


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
        parent = target.parent
        if target.is_dir():
            raise CompensatorError(f"{target}: is a folder; expected the name of a file")
        if parent not in self._folders:
            try:
                self._folders[parent] = Path(tempfile.mkdtemp(prefix=".compensator-", dir=parent))
            except OSError as e:
                raise CompensatorError(f"{target}: cannot write there: {e.strerror or e}") from e
        return self._folders[parent]

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
        self._staged.append((staged, target))

    def add(self, staged: Path, target: Path) -> None:
        """Take up a file that something else wrote into ``folder(target)``."""
        self._staged.append((staged, target))

    def commit(self) -> None:
        """Rename everything into place; on a failure put back what stood there before."""
        done: list[tuple[Path, Path | None]] = []
        try:
            for staged, target in self._staged:
                old: Path | None = None
                if target.exists():
                    old = staged.with_name(staged.name + ".old")
                    os.replace(target, old)
                done.append((target, old))
                os.replace(staged, target)
        except OSError as e:
            for target, old in reversed(done):
                if old is not None:
                    os.replace(old, target)
                else:
                    target.unlink(missing_ok=True)
            raise CompensatorError(f"{target}: cannot be put in place: {e.strerror or e}. Nothing was changed") from e
