"""What a cell must not say: each refusal names the file, the key and the value, and leaves nothing behind."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from compensator.cell.cell_file import load_cell
from compensator.errors import CompensatorError
from compensator.tasks.compensate import compensate_file
from stiffness.errors import StiffnessError
from tests.compensator.small_job import ABB, Files, files, merged
from toolpaths.errors import ToolpathError

REFUSALS = (CompensatorError, StiffnessError, ToolpathError)


def refusal(job: Files) -> str:
    """The message; there must be no output."""
    with pytest.raises(REFUSALS) as caught:
        compensate_file(job.toolpath, job.cell, job.out / "out.csv", json=job.out / "out.json")
    assert job.left() == []
    return str(caught.value)


FREE = {"carries": "robot", "direction": [1.0, 0.0, 0.0], "free": True, "range": [-900.0, 900.0]}
SET = {**FREE, "carries": "part", "center": [1500.0, 0.0, 0.0], "range": [-90.0, 90.0]}
TURNS = {**SET, "speed": 9.0, "acceleration": 9.0}


def free(**changes: Any) -> dict[str, Any]:
    """A free rail, E1, with changes; None takes a key away."""
    return {"external": {"E1": merged(FREE, changes)}}


CASES: list[tuple[str, dict[str, Any], str]] = [
    # unknown keys, at every depth
    ("top", {"robott": "x"}, r"unknown key robott = 'x'"),
    ("tool", {"tool": {"diameter": 12.0}}, r"unknown key tool\.diameter = 12\.0"),
    # free axes
    ("free rail", free(range=None), r"external\.E1: range is missing: the lowest and highest value, mm of a rail"),
    ("free backwards", free(range=[900.0, -900.0]), r"range = \[900, -900\]: the lowest value first"),
    ("free nowhere", free(range=[900.0, 900.0]), r"range = \[900, 900\]: the lowest value first"),
    ("free infinite", free(range=[0.0, float("inf")]), r"external\.E1\.range.*item 2 is not finite"),
    ("free in m", free(range=[0.0, 2.0]), r"2 mm of a rail: is this in m"),
    ("free number", free(range=900.0), r"external\.E1\.range = 900.*expected 2 numbers in brackets"),
    ("free nothing", free(carries="nothing", direction=[0.0] * 3), r"free = true of an axis that carries nothing"),
    ("free word", free(free="yes"), r"external\.E1\.free = 'yes'"),
    ("range alone", free(free=False), r"range is of an axis that is chosen: set free = true"),
    ("speed alone", free(free=None, range=None, speed=10.0), r"speed is of an axis that is chosen: set free = true"),
    ("standing speed", free(speed=0.0), r"external\.E1\.speed = 0\.0"),
    ("fast table", free(carries="part", center=[0.0] * 3, range=[-90.0, 90.0], speed=9.0),
     r"speed without acceleration: a table turns along a path with both"),
    ("hasty table", free(carries="part", center=[0.0] * 3, range=[-90.0, 90.0], acceleration=9.0),
     r"acceleration without speed: .* give speed, or take acceleration away"),
    ("two tables", {"external": {"E1": TURNS, "E2": SET}},
     r"external\.E1\.speed: E1 and E2 are tables: one that turns along a path is alone; take speed"),
    ("unit of a rail", free(unit="T1", unit_xyz=[0.0] * 3), r'unit is of a table \(carries = "part"\)'),
    ("unit nowhere", {"external": {"E1": {**TURNS, "unit": "STN1"}}}, r"unit_xyz is missing: the name of the"),
    ("place of no unit", {"external": {"E1": {**TURNS, "unit_xyz": [0.0] * 3}}}, r"unit is missing: the name of"),
    ("unit in words", {"external": {"E1": {**TURNS, "unit": "my table", "unit_xyz": [0.0] * 3}}},
     r"unit = 'my table': a name such as \"STN1\", or a number such as 2"),
    ("unit 0", {"external": {"E1": {**TURNS, "unit": 0, "unit_xyz": [0.0] * 3}}}, r"unit = 0: a number in MACHINE_DEF"),
    ("unit in m", {"external": {"E1": {**TURNS, "unit": 2, "unit_xyz": [1.6, 0.0, 0.5]}}}, r"this looks like metres"),
    ("narrow table", free(carries="part", center=[0.0] * 3, range=[0.0, 0.05]), r"less than 0\.1 deg of a table"),
    ("free thrice", {"external": {f"E{k}": FREE for k in (1, 2, 3)}}, r"E1, E2, E3 are free: 2 at most"),
    ("free twice", {"external": {"E2": FREE, "eax_b": FREE}}, r"E2 and eax_b are two names of one axis"),
    ("free group", {"external": {"GP2 J1": FREE}}, r"external\.GP2 J1\.free: an axis of another group"),
    ("workobject", {"workobject": {"rpx": [0.0, 0.0, 0.0]}}, r"unknown key workobject\.rpx"),
    ("process", {"process": {"kind": "constant", "frame": "base", "wrench": [0.0] * 6, "file": "a.csv"}},
     r"unknown key process\.file = 'a\.csv'"),
    ("solve", {"solve": {"max_corection": 1.0}}, r"unknown key solve\.max_corection = 1\.0"),
    ("mount", {"mount": {"xyz": [0.0, 0.0, 0.0]}}, r"unknown key mount\.xyz"),
    ("program", {"program": {"title": "A"}}, r"unknown key program\.title = 'A'"),
    ("start", {"start": {"joints": [0.0] * 6, "q": 1}}, r"unknown key start\.q = 1"),
    ("inner names", {"source": "x"}, r"unknown key source"),
    # missing keys
    ("no robot", {"robot": None}, r"robot is missing"),
    ("no model", {"model": None}, r"model is missing"),
    ("no schema", {"schema": None}, r"schema is missing"),
    ("no workobject", {"workobject": None}, r"workobject is missing"),
    ("no tool xyz", {"tool": {"xyz": None}}, r"tool\.xyz is missing"),
    ("no wrench", {"process": {"kind": "constant", "frame": "base"}}, r"process\.wrench is missing"),
    ("no frame", {"process": {"kind": "constant", "wrench": [0.0] * 6}}, r"process\.frame is missing"),
    ("other schema", {"schema": "cell/2"}, r"schema = 'cell/2'.*cell/1"),
    # units
    ("tool in metres", {"tool": {"xyz": [0.03, -0.02, 0.24]}}, r"tool\.xyz.*0\.24\d* mm long.*metres"),
    ("work object in metres", {"workobject": {"xyz": [1.5, -0.15, 0.8]}}, r"workobject\.xyz.*1\.7\d* mm.*metres"),
    ("centre of mass in metres", {"tool": {"com": [0.01, 0.0, 0.11]}}, r"tool\.com.*0\.11\d* mm.*metres"),
    ("tool in rad", {"tool": {"rpy": [0.0, 1.5707963, 0.0]}}, r"tool\.rpy.*1\.5708.*deg"),
    ("work object in rad", {"workobject": {"rpy": [3.14159, 0.0, 0.0]}}, r"workobject\.rpy.*3\.14159.*deg"),
    ("mount in rad", {"mount": {"rpy": [3.14159265, 0.0, 0.0]}}, r"mount\.rpy.*3\.14159.*deg"),
    ("start in rad", {"start": {"joints": [0.0, 0.3, -0.1, 0.0, 1.5708, 0.0]}}, r"start\.joints.*1\.5708.*deg"),
    ("a length as text", {"tool": {"xyz": [0.0, 0.0, "240"]}},
     r"tool\.xyz = .*item 3 is '240': text; write it without quotes"),
    ("a length with unit", {"workobject": {"xyz": ["1500 mm", 0.0, 0.0]}},
     r"workobject\.xyz = .*item 1 is '1500 mm': .*without quotes and unit"),
    ("truth for a number", {"solve": {"max_correction": True}}, r"solve\.max_correction = True"),
    ("number for truth", {"solve": {"free_tool_axis": 1}}, r"solve\.free_tool_axis = 1"),
    # values
    ("two of three", {"workobject": {"xyz": [1500.0, 0.0]}}, r"workobject\.xyz"),
    ("seven of six", {"process": {"kind": "constant", "frame": "base", "wrench": [1.0] * 7}},
     r"process\.wrench = .*: there are 7 \(a decimal sign is a point\), expected 6: fx, fy, fz in N, mx, my, mz in N"),
    ("not a number", {"workobject": {"xyz": [float("nan"), 0.0, 0.0]}}, r"workobject\.xyz = .*item 1 is not finite"),
    ("infinite force", {"process": {"kind": "constant", "frame": "base", "wrench": [float("inf"), *[0.0] * 5]}},
     r"process\.wrench = .*item 1 is not finite"),
    ("negative mass", {"tool": {"mass": -1.0}}, r"tool\.mass = -1\.0"),
    ("mass without centre", {"tool": {"com": None}}, r"tool.*mass.*com"),
    ("no bound", {"solve": {"max_correction": 0.0}}, r"solve\.max_correction = 0\.0: expected a number above 0"),
    ("unknown frame", {"process": {"kind": "constant", "frame": "world", "wrench": [0.0] * 6}},
     r"process\.frame = 'world'.*'path'.*'tool'"),
    ("unknown process", {"process": {"kind": "linear", "frame": "base"}}, r"process.*linear.*constant"),
    ("gravity", {"gravity": "off"}, r"gravity = 'off'.*uncompensated"),
    ("both kinds of tool", {"tools": {"1": {"xyz": [0.0, 0.0, 100.0]}}}, r"\[tool\].*\[tools\.1\]"),
    ("no tool", {"tool": None}, r"\[tool\].*\[tools\.1\]"),
    ("tool by name", {"tool": None, "tools": {"spindle": {"xyz": [0.0, 0.0, 100.0]}}},
     r"tools\.spindle.*expected a whole number"),
    ("unknown key of tool 2", {"tool": None, "tools": {"2": {"xyz": [0.0, 0.0, 100.0], "kg": 3}}},
     r"unknown key tools\.2\.kg = 3"),
    # the robot and its start
    ("no such robot", {"robot": "abb-irb9999"}, r"'abb-irb9999' is no robot.*ur10"),
    ("no such robot file", {"robot": "arm.toml"}, r"arm\.toml"),
    ("no such model", {"model": "none.toml"}, r"model = 'none\.toml': .*none\.toml: there is no such file"),
    ("base of a built-in", {"base": "base_link"}, r"base.*base_link"),
    ("tip of a built-in", {"tip": "gripper"}, r"tip.*gripper"),
    ("five joints", {"start": {"joints": [0.0, 10.0, 20.0, 0.0, 60.0]}}, r"start\.joints has 5 angles.*6 joints"),
    ("start beyond a limit", {"start": {"joints": [0.0, 10.0, 20.0, 0.0, 130.0, 0.0]}},
     r"start\.joints\[5\] = 130 deg.*-120 \.\.\. 120 deg"),
]  # fmt: skip


@pytest.mark.parametrize(("change", "message"), [c[1:] for c in CASES], ids=[c[0] for c in CASES])
def test_refused(tmp_path: Path, change: dict[str, Any], message: str) -> None:
    """The message names the cell file and what is wrong in it."""
    job = files(tmp_path, change)
    text = refusal(job)
    assert re.search(message, text), text
    assert "cell.toml" in text or "none.toml" in text, text


def test_several_findings_stand_in_one_message(tmp_path: Path) -> None:
    """Two mistakes, one run."""
    text = refusal(files(tmp_path, {"robott": "x", "tool": {"xyz": ["a", 0.0, 100.0]}}))
    assert "robott" in text and "tool.xyz = " in text


def test_not_toml_and_not_there(tmp_path: Path) -> None:
    """A file that is no TOML, no text, or not there."""
    job = files(tmp_path)
    job.cell.write_text("schema = cell/1\n")
    assert re.search(r"cell\.toml: is not TOML: line 1, 'schema = cell/1': .*; text stands in quotes", refusal(job))
    job.cell.write_bytes(b"\xff\xfe\x00")
    assert "cell.toml: is UTF-16 text; save it as UTF-8" in refusal(job)
    job.cell.unlink()
    assert "cell.toml: there is no such file" in refusal(job)


def test_a_sound_cell_is_read(tmp_path: Path) -> None:
    """The control of the cases above: unchanged, the cell loads, with the contract's defaults."""
    cell = load_cell(files(tmp_path).cell)
    assert cell.robot == ABB
    assert cell.solve.max_correction == 5.0 and cell.solve.free_tool_axis
    assert cell.tool is not None and cell.tool.name == "tool"
    assert compensate_file(tmp_path / "path.csv", tmp_path / "cell.toml", tmp_path / "out" / "a.csv").files


MODELS: list[tuple[str, dict[str, Any], str]] = [
    ("another robot", {"robot": "kuka-kr500"}, r"cell\.toml.*model\.toml.*kuka-kr500.*do not belong together"),
    ("robot that is not there", {"robot": "lost.urdf"}, r"cell\.toml.*lost\.urdf"),
    ("unknown key", {"stifness": 3}, r"model\.toml: unknown key stifness"),
    ("unknown effect", {"effects": {"backlsh": {"gap_rad": [0.0] * 6}}}, r"model\.toml: unknown effect backlsh"),
    ("unknown parameter", {"effects": {"joint-stiffness": {"k_nm_per_rad": [1e6] * 6, "k": 1}}},
     r"unknown key effects\.joint-stiffness\.k\b"),
    ("no base model", {"effects": {"backlash": {"gap_rad": [0.0] * 6}}}, r"joint-stiffness\] is missing"),
    ("five values", {"effects": {"joint-stiffness": {"k_nm_per_rad": [1e6] * 5}}}, r"k_nm_per_rad.*expected 6 numbers"),
    ("in N*m/deg", {"effects": {"joint-stiffness": {"k_nm_per_rad": [1e6, 1e6, 1e6, 1e5, 1e5, 65.0]}}},
     r"k_nm_per_rad\[6\] = 65 N\*m/rad is outside 100"),
    ("negative stiffness", {"effects": {"joint-stiffness": {"k_nm_per_rad": [1e6, -1e6, 1e6, 1e5, 1e5, 1e5]}}},
     r"k_nm_per_rad\[2\] = -1e\+06"),
    ("other base", {"base": "world"}, r"base.*world"),
]  # fmt: skip


@pytest.mark.parametrize(("change", "message"), [c[1:] for c in MODELS], ids=[c[0] for c in MODELS])
def test_model_refused(tmp_path: Path, change: dict[str, Any], message: str) -> None:
    """A model that is wrong, or not this robot's."""
    text = refusal(files(tmp_path, model=change))
    assert re.search(message, text), text
    assert "model.toml" in text, text
