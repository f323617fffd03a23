"""Staging: several files that appear together or not at all."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from types import TracebackType


class StagingError(Exception):
    """A file cannot be written or put in place; what stood there is as it was.

    Args:
        target: the file.
        why: in the words of the operating system.
    """

    def __init__(self, target: Path, error: OSError) -> None:
        self.target, self.why = target, str(error.strerror or error)
        super().__init__(f"{target}: {self.why}")


class Staging:
    """Stages files in a hidden folder beside their target and renames them into place at the end.

    Use as a context manager: leaving it without ``commit`` leaves nothing behind.

    Args:
        flush: False where the targets are themselves staged: the disk need not have them yet.
    """

    def __init__(self, *, flush: bool = True) -> None:
        self._flush = flush
        self._folders: dict[Path, Path] = {}
        self._staged: list[tuple[Path, Path]] = []
        self._on_disk: set[Path] = set()

    def __enter__(self) -> Staging:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for folder in self._folders.values():
            shutil.rmtree(folder, ignore_errors=True)

    def folder(self, target: Path) -> Path:
        """Where files for the folder of ``target`` are staged; they keep their names.

        Raises:
            StagingError: nothing can be written there.
        """
        parent = target.parent
        if parent not in self._folders:
            try:
                self._folders[parent] = Path(tempfile.mkdtemp(prefix=".compensator-", dir=parent))
            except OSError as e:
                raise StagingError(target, e) from e
        return self._folders[parent]

    def take_up(self, targets: Sequence[Path]) -> None:
        """Files that ``fill`` will write.

        Raises:
            StagingError: nothing can be written there.
        """
        for target in targets:
            self.add(self.folder(target) / target.name, target)

    def fill(self, target: Path, pieces: Iterable[bytes]) -> None:
        """Write one of them; another process may do it.

        Raises:
            StagingError: it cannot be written.
        """
        try:
            if target.is_dir():
                raise IsADirectoryError(21, "a folder of this name is in the way")
            with open(self.folder(target) / target.name, "wb") as stream:
                for piece in pieces:
                    stream.write(piece)
        except OSError as e:
            raise StagingError(target, e) from e

    def add(self, staged: Path, target: Path) -> None:
        """Take up a file that something else wrote into ``folder(target)``."""
        self._staged.append((staged, target))

    def are_on_disk(self, files: Iterable[Path]) -> None:
        """Staged files that ``flushed`` took to the disk, and that nobody changed since: ``commit`` does not wait for
        them again."""
        self._on_disk.update(files)

    def commit(self) -> None:
        """Flush everything to the disk and rename it into place; a failure or an interrupt puts back what stood there.

        Raises:
            StagingError: a rename failed, or the disk is full.
        """
        for staged, target in self._staged if self._flush else ():
            if staged not in self._on_disk:
                _flush(staged, target)
        backups = self._set_aside() if len(self._staged) > 1 else {}
        renamed: list[Path] = []
        try:
            for staged, target in self._staged:
                renamed.append(target)
                os.replace(staged, target)
        except BaseException as e:
            for place in renamed:
                if place in backups:
                    os.replace(backups[place], place)
                elif len(self._staged) > 1:
                    place.unlink(missing_ok=True)
            if isinstance(e, OSError):
                raise StagingError(renamed[-1], e) from e
            raise

    def _set_aside(self) -> dict[Path, Path]:
        """Target -> second name (or copy, where the disk knows no links) of the file that stands there."""
        backups: dict[Path, Path] = {}
        for staged, target in self._staged:
            if target.exists():
                backup = staged.with_name(staged.name + ".old")
                try:
                    _second_name(target, backup)
                except OSError as e:
                    raise StagingError(target, e) from e
                backups[target] = backup
        return backups


def flushed(files: Sequence[Path]) -> Sequence[Path]:
    """Take files to the disk, and wait until they are there."""
    for file in files:
        with open(file, "rb+") as stream:
            os.fsync(stream.fileno())
    return files


def _flush(staged: Path, target: Path) -> None:
    """Without it a power failure after the rename may leave an empty file where the old one was."""
    try:
        flushed([staged])
    except OSError as e:
        raise StagingError(target, e) from e


def _second_name(target: Path, backup: Path) -> None:
    try:
        os.link(target, backup)
    except OSError:
        shutil.copy2(target, backup)
