"""Files of a run: what it writes is known before it begins, and nothing that it reads can be among that.

Python raises the audit event ``open`` (PEP 578) for every file that it opens, whoever opens it: no reader of the
project or of a plugin can be forgotten. A file is known by device and number, so that a symbolic link, a hard link,
another spelling, or other letters where the disk does not tell them apart, is the same file. What a C library opens
by itself has to be told: ``current_run().opened(path)``.
"""

from __future__ import annotations

import inspect
import os
import sys
from collections.abc import Callable, Sequence
from contextvars import ContextVar
from functools import cache, wraps
from importlib.util import find_spec
from pathlib import Path
from typing import ParamSpec, TypeVar

from compensator.errors import CompensatorError, OutputError
from toolpaths.writing.staging import Staging, StagingError

P = ParamSpec("P")
R = TypeVar("R")
Identity = tuple[int, int]

STDOUT = Path("-")
PACKAGES = ("compensator", "stiffness", "toolpaths")


class RunFiles:
    """The files of one run.

    Args:
        targets: what it will write; ``STDOUT`` is standard output.
        outer: the run that this one is a part of.

    Raises:
        CompensatorError: a target cannot be written, belongs to this program, or is given twice.
    """

    def __init__(self, targets: Sequence[Path], outer: RunFiles | None = None) -> None:
        _check_targets(targets)
        self.targets, self.outer = frozenset(targets), outer
        found = ((identity(target), target) for target in targets if target != STDOUT)
        self._standing = {file: target for file, target in found if file is not None}
        self._read: dict[Identity, str] = {}

    def __repr__(self) -> str:
        return f"RunFiles({sorted(map(str, self.targets))}, {len(self._read)} read)"

    def opened(self, path: str | os.PathLike[str]) -> None:
        """Take down that a file is read.

        Raises:
            CompensatorError: it is to be written, too.
        """
        file = identity(path)
        if file is None:
            return
        target = self._standing.get(file)
        if target is not None and identity(target) == file:  # what was there is replaced, its number is free again
            raise _input(target, os.fspath(path))
        self._read[file] = os.fspath(path)
        if self.outer is not None:
            self.outer.opened(path)

    def refuse_input(self, target: Path) -> None:
        """Refuse a target that was not known before, such as the second file of a program.

        Raises:
            CompensatorError: it has been read.
        """
        file = identity(target)
        read = None if file is None else self._read.get(file)
        if read is not None and identity(read) == file:
            raise _input(target, read)


_RUN: ContextVar[RunFiles | None] = ContextVar("run", default=None)


def current_run() -> RunFiles | None:
    """The run that goes on; None outside of a task."""
    return _RUN.get()


def writes(*names: str) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """A task whose arguments ``names`` are the files that it writes; None: it does not write that one.

    The task raises CompensatorError before it computes anything where one of them cannot be written or is read.
    """

    def decorate(task: Callable[P, R]) -> Callable[P, R]:
        signature = inspect.signature(task)

        @wraps(task)
        def run(*args: P.args, **kwargs: P.kwargs) -> R:
            given = signature.bind(*args, **kwargs).arguments
            targets = [given[name] for name in names if given.get(name) is not None]
            _watch_openings()
            token = _RUN.set(RunFiles(targets, _RUN.get()))
            try:
                return task(*args, **kwargs)
            finally:
                _RUN.reset(token)

        return run

    return decorate


def identity(path: str | os.PathLike[str]) -> Identity | None:
    """Device and number of a file, links followed; None where there is none."""
    try:
        found = os.stat(path)
    except (OSError, ValueError):
        return None
    return found.st_dev, found.st_ino


def real(target: Path) -> Path:
    """Where a target really lies, links followed.

    Raises:
        CompensatorError: its links lead in a circle.
    """
    try:
        return target.resolve()
    except (OSError, RuntimeError) as e:
        raise CompensatorError(f"{target}: cannot write there: its symbolic links lead in a circle") from e


def cannot_write(target: Path, why: str) -> CompensatorError:
    """The refusal of a target that the system does not let be written."""
    parent = target.parent
    if not parent.is_dir():
        why = f"{parent} is a file, not a folder" if parent.exists() else f"there is no folder {parent}: make it first"
    return CompensatorError(f"{target}: cannot write there: {why}")


@cache
def _watch_openings() -> None:
    """Once for all: audit hooks stay until Python ends."""
    sys.addaudithook(_audit)


def _audit(event: str, args: tuple[object, ...]) -> None:
    if event != "open":
        return
    run = _RUN.get()
    if run is None:
        return
    path, _, flags = args
    if isinstance(path, bytes):
        path = os.fsdecode(path)
    if isinstance(path, str | os.PathLike) and isinstance(flags, int) and not flags & os.O_WRONLY:
        run.opened(path)


def _input(target: Path, read: str) -> OutputError:
    spelled = "" if os.path.normpath(read) == os.path.normpath(target) else f" (read as {read})"
    return OutputError(f"{target}: is an input of this run{spelled}; give the output another name")


def _check_targets(targets: Sequence[Path]) -> None:
    """Refuse what cannot be written before anything is read: each name is tried in a hidden folder beside it."""
    if targets.count(STDOUT) > 1:
        raise CompensatorError("-: is asked for twice; standard output takes one file")
    with Staging() as staging:
        for target in targets:
            if target != STDOUT:
                _check_place(target)
                _try_name(staging, target)


def _check_place(target: Path) -> None:
    try:
        if target.is_dir():
            raise CompensatorError(f"{target}: is a folder; expected the name of a file")
        if target.exists() and not target.is_file():
            what = "is a device or a pipe; outputs are renamed into place"
            raise CompensatorError(f"{target}: {what}: name a file, or - for standard output")
    except OSError as e:
        raise cannot_write(target, str(e.strerror)) from e
    if any(real(target).is_relative_to(folder) for folder in _own_folders()):
        raise CompensatorError(f"{target}: lies among the files of this program; give the output another folder")


def _try_name(staging: Staging, target: Path) -> None:
    place = real(target)
    try:
        os.close(os.open(staging.folder(place) / place.name, os.O_WRONLY | os.O_CREAT | os.O_EXCL))
    except FileExistsError as e:
        raise CompensatorError(f"{target}: is asked for twice; give each output a name of its own") from e
    except StagingError as e:
        raise cannot_write(target, e.why) from e
    except OSError as e:
        raise cannot_write(target, str(e.strerror)) from e


@cache
def _own_folders() -> tuple[Path, ...]:
    found = (find_spec(name) for name in PACKAGES)
    return tuple(Path(spec.origin).resolve().parent for spec in found if spec is not None and spec.origin)
