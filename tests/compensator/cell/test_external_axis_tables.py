"""[external.NAME]: directions, names and units that are taken, and what is said of the others."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from compensator.cell.cell_file import load_cell
from compensator.cell.placement_tables import ExternalAxisTable
from compensator.errors import CellError
from tests.compensator.small_job import files

RAIL: dict[str, Any] = {"carries": "robot", "direction": [0.0, 1.0, 0.0]}
TABLE: dict[str, Any] = {"carries": "part", "direction": [0.0, 0.0, 1.0], "center": [1500.0, 0.0, 700.0], "free": True}


def axis(folder: Path, name: str, **table: Any) -> ExternalAxisTable:
    return load_cell(files(folder, {"external": {name: table}}).cell).external[name]


def refused(folder: Path, name: str, **table: Any) -> str:
    with pytest.raises(CellError) as error:
        axis(folder, name, **table)
    return str(error.value)


def test_a_rounded_direction_is_of_length_one(tmp_path: Path) -> None:
    found = axis(tmp_path, "E1", carries="robot", direction=[0.7071, -0.7071, 0.0]).direction
    np.testing.assert_allclose(found, [np.sqrt(0.5), -np.sqrt(0.5), 0.0], rtol=0.0, atol=1e-15)
    assert axis(tmp_path, "E1", **RAIL).direction == (0.0, 1.0, 0.0)


def test_another_length_is_refused_with_the_direction_to_copy(tmp_path: Path) -> None:
    said = refused(tmp_path, "E1", carries="robot", direction=[1.0, 1.0, 0.0])
    assert "external.E1: direction = [1.0, 1.0, 0.0]: its length is 1.414" in said
    assert "of length 1 it is [0.7071068, 0.7071068, 0.0]" in said
    assert axis(tmp_path, "E1", carries="robot", direction=[0.7071068, 0.7071068, 0.0]).carries == "robot"
    assert "of length 1 in base axes is expected" in refused(tmp_path, "E1", carries="robot", direction=[0.0, 0.0, 0.0])


def test_a_missing_direction_is_named(tmp_path: Path) -> None:
    assert "external.E1: direction is missing" in refused(tmp_path, "E1", carries="robot")
    assert "external.E2: direction is missing" in refused(tmp_path, "E2", carries="part", center=[1.0, 2.0, 700.0])


@pytest.mark.parametrize("name", ["rail", "E7", "eax_g", "e1"])
def test_names_that_there_are(tmp_path: Path, name: str) -> None:
    said = refused(tmp_path, name, **RAIL)
    assert f"external.{name}" in said and "E1 ... E6 or eax_a ... eax_f" in said and "pattern" not in said
    assert axis(tmp_path, "GP2 J1", carries="nothing").carries == "nothing"


@pytest.mark.parametrize("given", [[-3.14159, 3.14159], [0.0, 6.283], [-1.57, 1.57]])
def test_the_range_of_a_table_in_rad(tmp_path: Path, given: list[float]) -> None:
    assert "in rad? deg are expected" in refused(tmp_path, "E2", **TABLE, range=given)
    assert axis(tmp_path, "E2", **TABLE, range=[-3.0, 3.0]).range == (-3.0, 3.0)
