"""Compiled: numba's compiler for the loops of the cut, with a cache that notices a change in any of their files."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import TypeVar

import numba
from numba import config

F = TypeVar("F", bound=Callable[..., object])


def compiled(function: F) -> F:
    """The function as machine code; it takes arrays and makes none.

    Without memory of their own, functions hand arrays on without counting who holds them: most of the time of a call.
    """
    return _compiled(function, _nrt=False)


def compiled_with_memory(function: F) -> F:
    """As ``compiled``; it may make arrays."""
    return _compiled(function)


def _compiled(function: F, **options: bool) -> F:
    """Compiled at the first call, kept on the disk for the next run.

    Numba's own cache looks at the file of the function and not at those of the functions that it calls: machine code
    of two releases would be mixed. Here a cache belongs to the text of all files of this folder.
    """
    before = config.CACHE_DIR  # type: ignore[attr-defined]
    folder = before or _folder()
    try:
        config.CACHE_DIR = folder  # type: ignore[attr-defined]
        made: F = numba.njit(cache=bool(folder), error_model="numpy", **options)(function)  # type: ignore[call-overload]
    finally:
        config.CACHE_DIR = before  # type: ignore[attr-defined]
    return made


@cache
def _folder() -> str:
    """Where the machine code of this text is kept; empty where nothing can be written: then each run compiles."""
    text = hashlib.sha256()
    for file in sorted(Path(__file__).parent.glob("*.py")):
        text.update(file.read_bytes())
    home = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA") or Path.home() / ".cache"
    folder = Path(home) / "toolpath-compensator" / text.hexdigest()[:16]
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return ""
    return str(folder) if os.access(folder, os.W_OK) else ""
