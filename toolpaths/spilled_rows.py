"""SpilledRows: a wide column of a long path, of which a few rows are read: on the disk, and not in memory."""

from __future__ import annotations

import os
import tempfile
import weakref
from typing import IO

import numpy as np
import numpy.typing as npt

from toolpaths import columns

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]


class SpilledRows:
    """N rows of numbers, 0 until they are set, in a file without a name, which goes when nobody has it any more.

    Those of a short path, and where no file can be written, are kept in memory.

    Args:
        count: N. shape: of a row.
    """

    def __init__(self, count: int, shape: tuple[int, ...]) -> None:
        self.shape = (count, *shape)
        self._size = 8 * int(np.prod(shape))  # bytes a row
        self._file = _empty_file(count * self._size) if count > columns.BLOCK else None
        self._held = np.zeros(self.shape if self._file is None else (0, *shape))
        if self._file is not None:
            weakref.finalize(self, self._file.close)

    def __repr__(self) -> str:
        return f"SpilledRows({self.shape}, {'in memory' if self._file is None else 'on the disk'})"

    def __len__(self) -> int:
        return self.shape[0]

    def put(self, b: slice, values: Floats) -> None:
        """Set the rows of a block."""
        if self._file is not None and not self._written(self._file, b.start * self._size, values):
            self._held = self[:]
            self._file.close()
            self._file = None
        if self._file is None:
            self._held[b] = values

    def __getitem__(self, rows: Rows | slice) -> Floats:
        if self._file is None:
            return np.array(self._held[rows])
        chosen = np.arange(len(self))[rows]
        read = b"".join(self._read(self._file, k * self._size) for k in chosen.tolist())
        return np.frombuffer(read).reshape(len(chosen), *self.shape[1:]).copy()

    def _written(self, file: IO[bytes], at: int, values: Floats) -> bool:
        """Whether the disk had room for them."""
        text = np.asarray(values, dtype=np.float64).tobytes()
        try:
            file.seek(at)
            return file.write(text) == len(text)
        except OSError:
            return False

    def _read(self, file: IO[bytes], at: int) -> bytes:
        """A row; a file that is mapped would bring its neighbours into memory."""
        if hasattr(os, "pread"):  # a process that was forked has the same file, and the same place in it
            return os.pread(file.fileno(), self._size, at)
        file.seek(at)
        return file.read(self._size)


def _empty_file(size: int) -> IO[bytes] | None:
    """One of ``size`` bytes, all of them 0; None where none can be made."""
    try:
        file = tempfile.TemporaryFile(buffering=0)  # noqa: SIM115  (as long as the column)
        file.truncate(size)
    except OSError:
        return None
    return file
