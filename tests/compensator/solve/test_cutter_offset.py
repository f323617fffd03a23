"""Cutter offset: a cutter that is too small goes towards its wall, with the same material and cutter only."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from compensator.solve.cutter_offset import _mitred
from tests.compensator.plant_bench import MM, Bench, Table, write_poses

K = [3.0e6, 2.7e6, 2.1e6, 4.2e5, 1.4e5, 5.6e4]
CUTTER = {"shape": "flat", "diameter": 10.0, "flutes": 2, "length": 20.0}
NAMES = {"material": "aluminium-7075-t6", "cutter": "diameter 10.0, flutes 2, length 20.0, shape flat"}
LESS = 3e-5  # m


def around(sense: int) -> list[list[object]]:
    """Around a block of 80 mm that has an allowance of 1 mm; counter-clockwise for sense 1."""
    corners = 44.0 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]])
    corners = corners[::sense]
    rows: list[list[object]] = [[-44, -60, 30, 0, 0, 1, 1000, "rapid"], [-44, -60, -5, 0, 0, 1, 500, "cut"]]
    for a, b in pairwise(corners):
        rows += [[*(a + t * (b - a)), -5.0, 0, 0, 1, 1000.0, "cut"] for t in np.linspace(0, 1, 9)[:-1]]
    return [*rows, [*corners[-1], -5.0, 0, 0, 1, 1000.0, "cut"], [-60, -60, 30, 0, 0, 1, 1000, "rapid"]]


def made(
    folder: Path, sizes: Mapping[str, Any] | None, sense: int = 1, **cutter: Any
) -> tuple[dict[str, Any], Table]:
    """The block, milled by a program that knows how large the cutter is."""
    folder.mkdir()
    process = {
        "kind": "milling",
        "material": "aluminium-7075-t6",
        "spindle_rpm": 12000.0,
        "cutter": {**CUTTER, **cutter},
        "stock": {"box": [[-40.0, -40.0, -8.0], [40.0, 40.0, 0.0]], "grid": 0.4},
    }
    effects: dict[str, Any] = {"joint-stiffness": {"k_nm_per_rad": K}}
    if sizes is not None:
        effects["cutter-size"] = dict(sizes)
    bench = Bench(
        folder,
        "abb-irb6600-175-255",
        effects,
        {"xyz": [1500.0, 0.0, 900.0], "rpy": [0.0, 0.0, 0.0]},
        process,
        start=[0.0, 10.0, 20.0, 0.0, 60.0, 0.0],
    )
    done, table = bench.compensate(write_poses(folder / "path.csv", around(sense)))
    return done.report, table


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Table:
    return made(tmp_path_factory.mktemp("plain") / "made", None)[1]


@pytest.mark.parametrize("sense", [1, -1])
def test_a_cutter_that_is_too_small_goes_towards_the_wall(plain: Table, tmp_path: Path, sense: int) -> None:
    report, table = made(tmp_path / "small", {"radius_m": LESS, **NAMES}, sense)
    if sense < 0:
        plain = made(tmp_path / "plain", None, sense)[1]
    assert report["not_applied"] == []
    moved = (table.command - plain.command)[:, :3, 3]
    at = table.nominal[:, :2, 3] / MM
    np.testing.assert_allclose(table.nominal, plain.nominal, atol=1e-12)  # what the part has to be stays
    sides = 0
    for axis, sign in ((0, 1), (0, -1), (1, 1), (1, -1)):
        mid = (np.abs(at[:, axis] - 44 * sign) < 1e-6) & (np.abs(at[:, 1 - axis]) < 35) & table.cut
        inward = np.zeros(3)
        inward[axis] = -sign
        assert mid.sum() >= 5
        np.testing.assert_allclose(moved[mid], np.tile(LESS * inward, (mid.sum(), 1)), atol=2e-7)
        sides += 1
    assert sides == 4
    assert any("30 um too small" in f["what"] and "towards the wall" in f["what"] for f in report["findings"])


@pytest.mark.parametrize("other", [{"material": "steel"}, {"cutter": "another"}], ids=str)
def test_another_material_or_cutter_is_left_alone(plain: Table, tmp_path: Path, other: dict[str, str]) -> None:
    report, table = made(tmp_path / "other", {"radius_m": LESS, **NAMES, **other})
    assert report["not_applied"] == ["cutter-size"]
    np.testing.assert_array_equal(table.command, plain.command)


def test_a_ball_has_no_upright_wall(tmp_path: Path) -> None:
    names = {**NAMES, "cutter": NAMES["cutter"].replace("flat", "ball")}
    report, _ = made(tmp_path / "ball", {"radius_m": LESS, **names}, shape="ball")
    assert report["not_applied"] == ["cutter-size"]


def test_an_inner_corner_is_met_on_both_walls() -> None:
    wall = np.array([[0, 0, 0], [1, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0]], dtype=float)
    np.testing.assert_allclose(_mitred(wall), [[1, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 0]])
