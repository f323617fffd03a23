"""Outputs: the files that a task writes, all of them or none."""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType

from compensator.errors import CompensatorError
from compensator.tasks.run_files import STDOUT, cannot_write, current_run, real
from toolpaths.errors import ToolpathError
from toolpaths.writing.staging import Staging, StagingError

#: What a program on standard output is called, where its language wants a name.
UNNAMED = "PART1"


class Outputs:
    """The files that a task writes, staged until all of them are there; the refusals name them as the user does.

    Use as a context manager: leaving it without ``commit`` leaves nothing behind. What is written has to be among the
    targets that the task declares (``writes``).
    """

    def __init__(self) -> None:
        self._staging = Staging()
        self._staged: dict[Path, Path] = {}
        self._taken: set[Path] = set()
        self._to_stdout: Path | None = None

    def __enter__(self) -> Outputs:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._staging.__exit__(kind, error, trace)
        if self._to_stdout is not None:
            shutil.rmtree(self._to_stdout.parent, ignore_errors=True)

    def _place(self, target: Path, suffix: str = "") -> Path:
        """Where to write ``target`` before it is added."""
        run = current_run()
        if run is not None and target not in run.targets:
            raise RuntimeError(f"{target} is not among the outputs that the task declares")
        if target == STDOUT:
            if self._to_stdout is None:
                self._to_stdout = Path(tempfile.mkdtemp(prefix="compensator-")) / f"{UNNAMED}{suffix}"
            return self._to_stdout
        if target not in self._staged:
            folder = self._folder(target) / str(len(self._staged))
            folder.mkdir()
            self._staged[target] = folder / target.name
        return self._staged[target]

    def _folder(self, target: Path) -> Path:
        try:
            return self._staging.folder(real(target))
        except StagingError as e:
            raise cannot_write(target, e.why) from e

    @contextmanager
    def writing(self, target: Path, suffix: str = "") -> Iterator[Path]:
        """The staged path of ``target``, with room for files beside it; a refusal from inside names ``target`` instead.

        Args:
            suffix: of the staged file where the target is standard output, which has no name.

        Raises:
            CompensatorError: for any refusal of a writer or reader, and where the disk takes no more.
        """
        staged = self._place(target, suffix)
        try:
            yield staged
        except (ToolpathError, CompensatorError) as e:
            shown = str(target)[: -len(target.name)]
            raise CompensatorError(str(e).replace(f"{staged.parent}{os.sep}", shown)) from e
        except OSError as e:
            raise CompensatorError(f"{target}: cannot be written: {e.strerror or e}. Nothing was changed") from e

    def text(self, target: Path, content: str) -> None:
        """Stage one text file.

        Raises:
            CompensatorError: it cannot be written.
        """
        with self.writing(target) as staged:
            staged.write_bytes(content.encode())
        self.add(staged, target)

    def add(self, staged: Path, target: Path, beside: Sequence[Path] = ()) -> tuple[Path, ...]:
        """Take up a staged file, and those that belong to it; a symbolic link stays one.

        Args:
            beside: further files of the same program; they keep their names.

        Returns:
            What will be written.

        Raises:
            CompensatorError: a target is an input of the run, or taken already; a file beside it would be lost.
        """
        if target == STDOUT and beside:
            names = ", ".join(file.name for file in (staged, *beside))
            raise CompensatorError(f"-: the program is {1 + len(beside)} files ({names}); standard output takes one")
        targets = (target, *(target.parent / file.name for file in beside))
        run = current_run()
        for place in targets[1:]:
            if run is not None:
                run.refuse_input(place)
            if place.exists() and not target.exists():
                why = f"stands there and belongs to {target}, which does not: it would be overwritten"
                raise CompensatorError(f"{place}: {why}; take it away, or give the output another name or folder")
        for file, place in zip((staged, *beside), targets, strict=True):
            self._take(file, place)
        return targets

    def _take(self, staged: Path, target: Path) -> None:
        place = target if target == STDOUT else real(target)
        if place in self._taken:
            raise CompensatorError(f"{target}: is asked for twice; give each output a name of its own")
        self._taken.add(place)
        if target != STDOUT:
            self._staging.add(staged, place)

    def are_on_disk(self, staged: Sequence[Path]) -> None:
        """As of ``Staging``."""
        self._staging.are_on_disk(staged)

    def commit(self) -> None:
        """Write to standard output what goes there, then rename everything into place; on a failure or an interrupt
        put back what stood there before.

        Raises:
            CompensatorError: a rename failed, or standard output takes no more.
        """
        if STDOUT in self._taken and self._to_stdout is not None:
            sys.stdout.buffer.write(self._to_stdout.read_bytes())
            sys.stdout.buffer.flush()
        try:
            self._staging.commit()
        except StagingError as e:
            raise CompensatorError(f"{e.target}: cannot be put in place: {e.why}. Nothing was changed") from e
