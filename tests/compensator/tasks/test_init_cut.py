"""`init` with cutter, material and stock: the cell computes the force, runs as it stands, and misfits are refused."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
import trimesh
from click.testing import CliRunner, Result

from benchmarks.milled import MATERIAL
from compensator.cli import main
from compensator.tasks.check import check_files
from compensator.tasks.compensate import preview_file

NC = """%
G21 G90 G17
T1 M6
S6000 M3
G0 X0 Y0 Z80
G0 Z5
G1 Z-2 F300
G1 X60 F900
G0 Z80
M30
%
"""
TWO = NC.replace("M30", "T2 M6\nS8000 M3\nG0 X0 Y20 Z5\nG1 Z-2 F300\nG1 X60 F900\nG0 Z80\nM30")
ANSWERS = {
    "robot": "abb-irb6600-175-255",
    "tool": "0 0 250 35",
    "part": "1500 -100 800",
    "cam": "part.nc",
    "stiffness": "unknown",
    "controller": "krl",
    "cutter": "flat 10 2 25",
    "material": "aluminium-6082-t6",
    "stock": "box -10 -10 -20 80 40 0",
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "part.nc").write_text(NC)
    (tmp_path / "two.nc").write_text(TWO)
    (tmp_path / "slow.nc").write_text(NC.replace("S6000 M3", "M3"))
    trimesh.creation.box(bounds=[[-10, -10, -20], [80, 40, 0]]).export(tmp_path / "my stock.stl")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def init(**changed: str) -> Result:
    """In the working folder; an empty answer leaves the option out."""
    words = [word for key, value in {**ANSWERS, **changed}.items() if value for word in _option(key, value)]
    return CliRunner().invoke(main, ["init", *words])


def _option(key: str, value: str) -> tuple[str, str]:
    return f"--{key.replace('_', '-')}", value


def test_the_force_is_computed(folder: Path) -> None:
    """The cell as it stands; a slot of 2 mm pushes back against the feed; check tells what material and stock are."""
    done = init()
    assert done.exit_code == 0, done.output
    assert "wrench is an assumption" not in done.stderr
    shown = preview_file(folder / "part.nc", folder / "cell.toml").report
    # D10, two flutes, 2 mm deep, 0.075 mm per tooth: the closed form of a slot (docs/cutting.md)
    fx = 0.6366 * (99 * 0.075 * 1.5708 + 2 * 10)
    fy = 0.6366 * (631 * 0.075 * 1.5708 + 2 * 13)
    fz = 0.6366 * (2 * 273 * 0.075 + 3.1416 * 2.8)
    assert shown["cut"]["peak_n"] > shown["cut"]["mean_n"] > 0
    assert shown["cut"]["mean_n"] == pytest.approx((fx**2 + fy**2 + fz**2) ** 0.5, rel=0.08)
    report = check_files(folder / "cell.toml", [folder / "part.nc"]).report
    found = {f["what"].split(":")[0]: f["worth_mm"] for f in report["findings"]}
    material = next(v for k, v in found.items() if k.startswith("the coefficients of the cutting force"))
    tenth, stock = found["the wrench of the process"], found["the stock"]
    assert 1.2 * tenth < material < 4 * tenth
    assert 3 * tenth < stock < 7 * tenth  # half as deep again: 3 mm in place of 2


def test_several_tools_a_mesh_and_a_material_file(folder: Path) -> None:
    """Numbers of the file; paths as seen from the cell; units kept."""
    (folder / "cells").mkdir()
    (folder / "own.toml").write_text(MATERIAL)
    arguments = {"cam": "two.nc", "cutter": "1=bull 10 2 25 1; 2=ball 6 3 20", "material": "own.toml"}
    words = [w for k, v in {**ANSWERS, **arguments, "stock": "'my stock.stl' mm"}.items() for w in _option(k, v)]
    done = CliRunner().invoke(main, ["init", *words, "-o", "cells/a.toml"])
    assert done.exit_code == 0, done.output
    process = tomllib.loads((folder / "cells" / "a.toml").read_text())["process"]
    assert "all are taken to be as long" in done.stderr
    assert process["cutters"]["1"] == {"shape": "bull", "diameter": 10, "flutes": 2, "length": 25, "corner_radius": 1}
    assert process["cutters"]["2"]["shape"] == "ball" and process["material"] == "../own.toml"
    assert process["stock"] == {"file": "../my stock.stl", "units": "mm"}
    assert preview_file(folder / "two.nc", folder / "cells" / "a.toml").report["cut"]["removed_mm3"] > 500


def test_a_stock_that_nobody_gave(folder: Path) -> None:
    """A block around the cuts with its top at z = 0; said; a speed that the file lacks is taken from the answers."""
    done = init(stock="unknown", cam="slow.nc", spindle_rpm="6000")
    assert done.exit_code == 0 and "the stock is an assumption" in done.stderr
    process = tomllib.loads((folder / "cell.toml").read_text())["process"]
    assert process["stock"]["box"] == [[-6.0, -6.0, -3.0], [66.0, 6.0, 0.0]] and process["spindle_rpm"] == 6000
    assert preview_file(folder / "slow.nc", folder / "cell.toml").report["cut"]["mean_n"] > 50


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"cutter": "flat 10 2"}, "2 numbers after 'flat'; expected shape, diameter"),
        ({"cutter": "flat 10 2.5 25"}, "flutes"),
        ({"cutter": "flat 0.01 2 25"}, "looks like metres"),
        ({"cutter": "bull 10 2 25"}, "corner_radius is missing"),
        ({"cutter": "flat 10 2 260"}, "the cutter is longer than its stick-out"),
        ({"cutter": "2=flat 10 2 25"}, "cuts with tool 1 too"),
        ({"cam": "two.nc"}, "cuts with 2 tools: give '1=...; 2=...'"),
        ({"material": "cheese"}, "material = 'cheese' is not known"),
        ({"material": ""}, "--cutter without --material"),
        ({"cutter": ""}, "--material, --stock without --cutter"),
        ({"stock": "box 1 2 3"}, "box has 6 numbers"),
        ({"stock": "box 0 0 0 -1 1 1"}, "least corner first"),
        ({"stock": "lost.stl"}, "lost.stl: cannot read the mesh"),
        ({"stock": "'my stock.stl' inch"}, ""),
        ({"cam": "slow.nc"}, "gives no spindle speed (S) for some cuts: give --spindle-rpm"),
        ({"spindle_rpm": "fast"}, "spindle_rpm = 'fast'"),
    ],
)
def test_misfits(folder: Path, changed: dict[str, str], words: str) -> None:
    """One message, and nothing is left behind."""
    before = sorted(p.name for p in folder.iterdir())
    done = init(**changed)
    if not words:  # a stock of two metres: large, and met
        assert done.exit_code == 0
        return
    assert done.exit_code == 1 and words in done.stderr, done.stderr
    assert sorted(p.name for p in folder.iterdir()) == before


def test_answers_typed_in(folder: Path) -> None:
    """Six, and then three about the cut."""
    six = "\n".join(ANSWERS[k] for k in ("robot", "tool", "part", "cam", "stiffness", "controller"))
    done = CliRunner().invoke(main, ["init"], input=f"{six}\nball 6 2 20\nparticleboard\n\n")
    assert done.exit_code == 0, done.output
    process = tomllib.loads((folder / "cell.toml").read_text())["process"]
    assert process["kind"] == "milling" and process["cutter"]["shape"] == "ball" and "box" in process["stock"]
