"""Outputs: the files that a task writes, all of them or none."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType

from compensator.errors import CompensatorError
from toolpaths.errors import ToolpathError
from toolpaths.writing.staging import Staging, StagingError


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
    """The files that a task writes, staged until all of them are there; the refusals name them as the user does.

    Use as a context manager: leaving it without ``commit`` leaves nothing behind.
    """

    def __init__(self) -> None:
        self._staging = Staging()

    def __enter__(self) -> Outputs:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._staging.__exit__(kind, error, trace)

    def folder(self, target: Path) -> Path:
        """Where files for the folder of ``target`` are staged; they keep their names.

        Raises:
            CompensatorError: the folder cannot be written to.
        """
        if target.is_dir():
            raise CompensatorError(f"{target}: is a folder; expected the name of a file")
        if target.exists() and not target.is_file():
            raise CompensatorError(f"{target}: is a device or a pipe; outputs are renamed into place: name a file")
        try:
            return self._staging.folder(target.resolve())
        except StagingError as e:
            raise CompensatorError(f"{target}: cannot write there: {e.why}") from e

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
        """Stage one text file.

        Raises:
            CompensatorError: it cannot be written.
        """
        self.folder(target)
        try:
            self._staging.write(target.resolve(), [content.encode()])
        except StagingError as e:
            raise CompensatorError(f"{target}: cannot be written: {e.why}. Nothing was changed") from e

    def add(self, staged: Path, target: Path) -> None:
        """Take up a file that something else wrote into ``folder(target)``; a symbolic link stays one."""
        self._staging.add(staged, target.resolve())

    def commit(self) -> None:
        """Rename everything into place; on a failure or an interrupt put back what stood there before.

        Raises:
            CompensatorError: a rename failed.
        """
        try:
            self._staging.commit()
        except StagingError as e:
            raise CompensatorError(f"{e.target}: cannot be put in place: {e.why}. Nothing was changed") from e
