"""Statements and moves of a program in columns against the same as objects, row by row."""

from __future__ import annotations

import numpy as np
import pytest

import toolpaths.columns as columns
from toolpaths.interpreting.move_columns import MoveColumns
from toolpaths.interpreting.program_text import CHOICE, COMMENT, PLAIN, Statement
from toolpaths.interpreting.statements import Statements


def test_statements_are_what_was_appended() -> None:
    given = [
        Statement(PLAIN, 5, 17, "MoveL"),
        Statement(COMMENT, 20, 31, "a remark"),
        Statement(CHOICE, 35, 90, body=[Statement(PLAIN, 40, 60, "SetDO")], terms=("x = 1",)),
        Statement(PLAIN, 95, 99, "movel"),
        Statement(PLAIN, 100, 140, "MoveL"),
    ]
    kept = Statements()
    for s in given:
        kept.append(s)
    assert list(kept) == given and len(kept) == 5
    kept.move(1000)
    assert [s.start for s in kept] == [1005, 1020, 1035, 1095, 1100]
    assert [s.end for s in kept] == [1017, 1031, 1090, 1099, 1140]
    assert list(kept)[2].body[0].start == 1040


@pytest.mark.parametrize("rows", [1, 6, 7, 8, 20, 23])
def test_columns_are_what_was_appended(monkeypatch: pytest.MonkeyPatch, rows: int) -> None:
    monkeypatch.setattr(columns, "BLOCK", 7)
    rng = np.random.default_rng(rows)
    numbers, marks = rng.normal(size=(rows, 4)), rng.integers(0, 2**40, (rows, 3))
    numbers[:, 2], numbers[:, 3] = np.nan, np.where(np.arange(rows) < 7, 1.5, 2.5)
    marks[:, 1] = -1
    marks[:, 2] = rng.integers(0, 9, rows)
    kept = MoveColumns("abcd", ("far", "none", "near"))
    for some, others in zip(numbers.tolist(), marks.tolist(), strict=True):
        kept.append(tuple(some), tuple(others))
    assert kept.count == rows
    np.testing.assert_array_equal(kept.numbers("a", "b", "c"), numbers[:, :3])
    np.testing.assert_array_equal(kept.number("d"), numbers[:, 3])
    for k, name in enumerate(("far", "none", "near")):
        np.testing.assert_array_equal(kept.mark(name), marks[:, k])
