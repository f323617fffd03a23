"""Machine code of C text, where this machine has a compiler: kept on the disk for the next run, never required.

Nothing is reordered or contracted: the same operations in the same order give the same numbers as without.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from functools import lru_cache
from pathlib import Path

OPTIONS = ("-O2", "-fPIC", "-shared", "-ffp-contract=off", "-fno-fast-math")
LONGEST = 60.0  # s that a compiler may take


@lru_cache(maxsize=64)
def machine_code(text: str, *, compiles: bool = True) -> ctypes.CDLL | None:
    """The functions of a C text; None where there is no compiler, where it fails, or, unless it ``compiles``, none are
    kept."""
    compiler, folder = _compiler(), _folder()
    if compiler is None or folder is None:
        return None
    key = "\n".join((text, compiler, *OPTIONS, platform.machine(), platform.platform()))
    file = folder / f"{hashlib.sha256(key.encode()).hexdigest()[:32]}.so"
    try:
        if not file.exists():
            if not compiles:
                return None
            _compile(compiler, text, file)
        return ctypes.CDLL(str(file))
    except (OSError, subprocess.SubprocessError):
        return None


def _compile(compiler: str, text: str, file: Path) -> None:
    with tempfile.TemporaryDirectory(dir=file.parent) as name:
        made = Path(name) / "made.so"
        command = [compiler, *OPTIONS, "-x", "c", "-", "-o", str(made), "-lm"]
        subprocess.run(command, input=text.encode(), capture_output=True, check=True, timeout=LONGEST, cwd=name)
        os.replace(made, file)  # whole, or not there


@lru_cache(maxsize=1)
def _compiler() -> str | None:
    """Where a C compiler is; those of Windows take other options."""
    if sys.platform == "win32":
        return None
    return next((found for name in ("cc", "gcc", "clang") if (found := shutil.which(name))), None)


@lru_cache(maxsize=1)
def _folder() -> Path | None:
    """Where machine code is kept; None where nothing can be written, or where others could write."""
    home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    folder = Path(home) / "toolpath-compensator" / "c"
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        mine = folder.stat().st_uid == os.getuid() and not folder.stat().st_mode & 0o022
    except (OSError, RuntimeError, AttributeError):
        return None
    return folder if mine and os.access(folder, os.W_OK) else None
