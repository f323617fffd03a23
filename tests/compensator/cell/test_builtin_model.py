"""A cell names a built-in robot and the stiffness set that comes with it, both by name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from compensator.cell.arm import load_arm
from compensator.cell.cell_file import load_cell
from compensator.errors import CellError
from stiffness.model.model import builtin_model

CELL = """schema = "cell/1"
robot = "kuka-kr210-r2700"
model = "{}"
[process]
kind = "constant"
frame = "path"
wrench = [-120.0, 80.0, -60.0, 0.0, 0.0, 0.0]
"""


def cell(folder: Path, model: str) -> Path:
    path = folder / "cell.toml"
    path.write_text(CELL.format(model))
    return path


def test_by_name_as_by_its_file(tmp_path: Path) -> None:
    named = load_arm(load_cell(cell(tmp_path, "kuka-kr210-r2700"))).model
    standing = builtin_model("kuka-kr210-r2700")
    assert standing is not None
    (tmp_path / "copy.toml").write_bytes(standing.read_bytes())
    copied = load_arm(load_cell(cell(tmp_path, "copy.toml"))).model
    k = named.values["joint-stiffness"]["k_nm_per_rad"]
    assert np.asarray(k).min() > 1e5
    np.testing.assert_array_equal(k, copied.values["joint-stiffness"]["k_nm_per_rad"])
    assert named.source == "kuka-kr210-r2700"


def test_of_another_robot_and_of_none(tmp_path: Path) -> None:
    with pytest.raises(CellError, match=r"kuka-kr500.*do not belong together"):
        load_arm(load_cell(cell(tmp_path, "kuka-kr500")))
    with pytest.raises(CellError, match=r"model = 'ur10': .*the built-in robots with a stiffness set are abb-irb6600"):
        load_arm(load_cell(cell(tmp_path, "ur10")))
