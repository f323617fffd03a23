"""A column on the disk gives back what was put in, to the bit, as one in memory does."""

from __future__ import annotations

import errno
import io
import tempfile

import numpy as np
import numpy.typing as npt
import pytest

from toolpaths import columns
from toolpaths.spilled_rows import SpilledRows

SOME = np.array([3, 19, 0, 3, 12])


@pytest.fixture(autouse=True)
def small_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(columns, "BLOCK", 7)


def numbers(rows: int) -> npt.NDArray[np.float64]:
    return np.random.default_rng(0).normal(size=(rows, 2, 3))


@pytest.mark.parametrize(("rows", "where"), [(7, "in memory"), (20, "on the disk")])
def test_what_was_put_in_comes_out(rows: int, where: str) -> None:
    column, values = SpilledRows(rows, (2, 3)), numbers(rows)
    assert where in repr(column) and len(column) == rows
    assert not column[:].any()
    for b in columns.blocks(rows, 4):
        column.put(b, values[b])
    some = SOME % rows
    assert column[some].tobytes() == values[some].tobytes()
    assert column[2:6].tobytes() == values[2:6].tobytes()
    column.put(slice(2, 4), np.zeros((2, 2, 3)))
    assert not column[2:4].any() and column[4:].tobytes() == values[4:].tobytes()
    assert column[np.empty(0, dtype=np.intp)].shape == (0, 2, 3)


class _Full(io.FileIO):
    """A disk without room, from a while on: it takes a part, or refuses."""

    room = 500
    refuses = False

    def write(self, text: bytes, /) -> int:  # type: ignore[override]
        if self.tell() + len(text) <= self.room:
            return super().write(text)
        if self.refuses:
            raise OSError(errno.ENOSPC, "no space")
        return super().write(text[:10])


@pytest.mark.parametrize("refuses", [True, False])
def test_where_the_disk_is_full_rows_are_kept_in_memory(monkeypatch: pytest.MonkeyPatch, refuses: bool) -> None:
    monkeypatch.setattr(_Full, "refuses", refuses)
    with tempfile.NamedTemporaryFile() as place:
        monkeypatch.setattr(tempfile, "TemporaryFile", lambda buffering: _Full(place.name, "r+"))
        column, values = SpilledRows(20, (2, 3)), numbers(20)
        for b in columns.blocks(20, 4):
            column.put(b, values[b])
    assert "in memory" in repr(column)
    assert column[:].tobytes() == values.tobytes()


def test_where_no_file_can_be_made_rows_are_kept_in_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(buffering: int) -> None:
        raise FileNotFoundError("no usable temporary directory")

    monkeypatch.setattr(tempfile, "TemporaryFile", refused)
    assert "in memory" in repr(SpilledRows(20, (6, 6)))
