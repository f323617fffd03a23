"""Where contacts close every place and every way, the bodies are named."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from compensator.errors import CompensatorError
from compensator.tasks.compensate import compensate_file
from tests.compensator.axes.test_free_axes_files import LONG, RAIL
from tests.compensator.scene.test_collisions_of_a_path import STRAIGHT
from tests.compensator.small_job import ROWS, files

TABLE = {"carries": "part", "direction": [0.0, 0.0, 1.0], "center": [1500.0, -150.0, 700.0], "free": True,
         "range": [-180.0, 180.0]}  # fmt: skip
CLAMP = {"name": "clamp", "box": [[15.0, -20.0, -5.0], [85.0, 20.0, 30.0]], "frame": "workobject"}


def refused(
    folder: Path, axis: dict[str, Any], scene: dict[str, Any], rows: list[list[Any]] = ROWS, **cell: Any
) -> str:
    tables = {"external": {"E1": axis}, "sampling": {"spacing": 20.0}, "scene": [scene], **cell}
    made = files(folder, tables, rows=rows)
    with pytest.raises(CompensatorError) as error:
        compensate_file(made.toolpath, made.cell, made.out / "c.mod")
    assert made.left() == []
    return str(error.value)


def test_a_clamp_that_turns_with_the_table(tmp_path: Path) -> None:
    """On the cut, wherever the table stands."""
    said = refused(tmp_path, TABLE, CLAMP, tool=STRAIGHT)
    assert "contacts are in the way: where it stands at E1 = " in said and "tool and clamp touch at " in said


def test_a_block_on_the_rail(tmp_path: Path) -> None:
    """No fixed place reaches the whole path, and the base cannot go by."""
    block = {"name": "block", "box": [[-150.0, 1600.0, 0.0], [150.0, 1700.0, 300.0]]}
    longer = [[5200 if v == 3800 else v for v in row] for row in LONG]
    work = {"xyz": [1500.0, -150.0, 800.0], "rpy": [0.0, 0.0, 0.0]}
    said = refused(tmp_path, {**RAIL, "range": [-1500.0, 5500.0]}, block, rows=longer, workobject=work)
    assert "contacts are in the way: where it goes from E1 = " in said and "base and block touch at " in said
