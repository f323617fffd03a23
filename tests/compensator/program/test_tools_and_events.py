"""Several tools, spindle and coolant: from a CAM file and a cell to the program."""

from __future__ import annotations

import csv
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from compensator.errors import CellError, CompensatorError, PathError
from compensator.tasks.compensate import compensate_file, preview_file
from stiffness.robot.load import load_robot
from tests.compensator.small_job import ABB, files
from toolpaths.errors import ToolpathError
from toolpaths.rotation import matrix_from_quaternion, matrix_from_rpy

MILL: dict[str, Any] = {"name": "mill", "xyz": [0.0, 0.0, 250.0]}
DRILL: dict[str, Any] = {"name": "drill", "xyz": [40.0, 0.0, 320.0], "rpy": [0.0, 35.0, 0.0]}
TOOLS: dict[str, Any] = {"tool": None, "tools": {"1": MILL, "2": DRILL}, "workobject": {"rpy": [0.0, 0.0, 0.0]}}
JOB = """G21 G90
G0 X0 Y0 Z200
T1 M6
S5000 M3
M8
G0 Z2
G1 Z-2 F300
X100 F1000
G0 Z200
M9
M5
T2 M6
S8000 M4
G0 X50 Y50
Z2
G1 Z-3 F200
G0 Z200
M5
M30
"""


def job(folder: Path, cell: dict[str, Any], text: str = JOB, name: str = "part.nc") -> tuple[Path, Path]:
    (folder / name).write_text(text)
    return folder / name, files(folder, cell).cell


def test_one_tool_for_two_is_refused_by_line(tmp_path: Path) -> None:
    """Rapids may call what they like; a file that cuts with one tool needs no [tools.N]."""
    toolpath, cell = job(tmp_path, {})
    words = r"part\.nc:16: a cut with tool 2 after cuts with tool 1 \(line 7\).*\[tools\.1\], \[tools\.2\]"
    with pytest.raises(CellError, match=words):
        compensate_file(toolpath, cell, tmp_path / "out" / "o.mod")
    assert list((tmp_path / "out").iterdir()) == []
    one = JOB[: JOB.index("S8000")] + "G0 X10\nM30\n"
    assert preview_file(job(tmp_path, {}, one)[0], cell).report["n_cut"] > 0


def test_a_tool_without_an_entry_is_refused_where_it_cuts(tmp_path: Path) -> None:
    toolpath, cell = job(tmp_path, {**TOOLS, "tools": {"1": MILL, "3": DRILL}})
    with pytest.raises(CellError, match=r"part\.nc:16: tool 2 cuts, but .*cell\.toml has \[tools\.N\] for 1, 3 only"):
        preview_file(toolpath, cell)
    toolpath, cell = job(tmp_path, TOOLS, JOB.replace("T1 M6\n", ""))
    with pytest.raises(CellError, match=r"part\.nc:6: a cut before any tool call"):
        preview_file(toolpath, cell)


def test_every_tool_is_planned_with_its_own_frame(tmp_path: Path) -> None:
    """At the change the joints jump, elsewhere they do not; the tip stands where the file wants it."""
    toolpath, cell = job(tmp_path, TOOLS)
    compensate_file(toolpath, cell, tmp_path / "o.csv")
    with open(tmp_path / "o.csv", newline="") as stream:
        rows = list(csv.DictReader(stream))
    line = np.array([int(r["source_line"]) for r in rows])
    q = np.radians([[float(r[f"q{j}_deg"]) for j in range(1, 7)] for r in rows])
    xyz = np.array([[float(r[f"{c}_mm"]) for c in "xyz"] for r in rows])
    turn = matrix_from_quaternion(np.array([[float(r[f"q{c}"]) for c in "wxyz"] for r in rows]))
    robot = load_robot(ABB)
    for k in range(len(rows)):
        tool = MILL if line[k] < 12 else DRILL
        flange = robot.pose(q[k])
        tip = flange[:3, :3] @ np.array(tool["xyz"]) + flange[:3, 3] * 1e3
        np.testing.assert_allclose(tip - [1500.0, -150.0, 800.0], xyz[k], atol=1e-5)
        rpy = np.radians(np.array(tool.get("rpy", [0.0, 0.0, 0.0])))
        np.testing.assert_allclose(flange[:3, :3] @ matrix_from_rpy(rpy), turn[k], atol=1e-8)
    jump = np.degrees(np.abs(np.diff(q, axis=0)).max(axis=1))
    change = int(np.argmax(line > 12))
    assert jump[change - 1] > 30.0 and np.delete(jump, change - 1).max() < 10.0


def test_a_jump_under_one_tool_is_refused_still(tmp_path: Path) -> None:
    toolpath, cell = job(tmp_path, {**TOOLS, "solve": {"max_joint_step": 0.01}})
    with pytest.raises(PathError, match=r"part\.nc:\d+ \(pose \d+\): joint \d would jump"):
        preview_file(toolpath, cell)


def test_poses_of_a_later_tool_are_counted_in_the_whole_path(tmp_path: Path) -> None:
    """A refusal names the pose as the csv of the program counts it."""
    toolpath, cell = job(tmp_path, TOOLS, JOB.replace("G0 X50 Y50\n", "G0 X9000 Y50\n"))
    with pytest.raises(PathError, match=r"part\.nc:14 \(pose (\d+)\)") as caught:
        preview_file(toolpath, cell)
    found = re.search(r"pose (\d+)", str(caught.value))
    assert found is not None and int(found[1]) > 40


EVENTS = {"M03": ["SetAO aoSpindle, {S};", "WaitTime 2;"], "M4": ["SetAO aoBack, {S};"], "m5": ["Reset doSpindle;"],
          "M9": []}  # fmt: skip


def test_events_become_lines_of_the_program(tmp_path: Path) -> None:
    toolpath, cell = job(tmp_path, {**TOOLS, "program": {"events": EVENTS}})
    done = compensate_file(toolpath, cell, tmp_path / "part_c.mod")
    text = (tmp_path / "part_c.mod").read_text()
    wanted = ["MoveAbsJ", "SetAO aoSpindle, 5000;", "WaitTime 2;", "Reset doSpindle;", "mount tool 2 (drill)", "Stop;",
              "SetAO aoBack, 8000;", "MoveAbsJ", "Reset doSpindle;", "ENDPROC"]  # fmt: skip
    places = [text.index(wanted[0])]
    for words in wanted[1:]:
        places.append(text.index(words, places[-1] + 1))
    assert text.count("SetAO") == 2 and text.count("Reset doSpindle;") == 2 and "MODULE part_c\n" in text
    (listed,) = [f for f in done.findings if "no words of its own" in f.what]
    assert "for M8:" in listed.what and listed.lines == (5,)


def test_events_of_apt_have_the_words_of_gcode(tmp_path: Path) -> None:
    text = ("UNITS/MM\nLOADTL/1\nSPINDL/RPM,4000,CCLW\nCOOLNT/MIST\nRAPID\nGOTO/0,0,50\nFEDRAT/600,MMPM\nGOTO/0,0,-2\n"
            "DELAY/1.5\nAUXFUN/12\nSTOP\nGOTO/50,0,-2\nSPINDL/OFF\nCOOLNT/OFF\nFINI\n")  # fmt: skip
    lines = {"M4": ["A {S}"], "M5": ["B"], "M7": ["C"], "M9": ["D"], "G4": ["E {P}"], "M12": ["F"], "M6": ["G {T}"]}
    toolpath, cell = job(tmp_path, {**TOOLS, "program": {"events": lines}}, text, "part.apt")
    compensate_file(toolpath, cell, tmp_path / "o.src")
    program = (tmp_path / "o.src").read_text()
    found = re.findall(r"^  ([A-G](?: [\d.]+)?|HALT|PTP|LIN)(?=[\r\n ])", program, re.M)
    kinds = [k for i, k in enumerate(found) if k != "LIN" or found[i - 1] != "LIN"]
    assert kinds == ["G 1", "A 4000", "C", "PTP", "LIN", "E 1.5", "F", "HALT", "LIN", "B", "D"]


@pytest.mark.parametrize(
    ("events", "words"),
    [
        ({"M3": ["SetAO a, {RPM};"]}, r"program\.events.*M3: 'SetAO a, \{RPM\};': \{RPM\} is not known"),
        ({"M3": ["a\nb"]}, r"program\.events.*one line of printable ASCII"),
        ({"M3": [""]}, r"program\.events.*one line"),
        ({"M6": ["MoveJ pChange,v500,z10,tool0;"]}, r"program\.events.*a move is not known to the solve"),
        ({"3": ["x"]}, r"program\.events.*'3' is no word of a toolpath"),
        ({"M3": ["x"], "M03": ["y"]}, r"program\.events.*'M03' stands twice"),
        ({"M3": "SetDO a, 1;"}, r"program\.events\.M3"),
    ],
)
def test_events_that_are_none(tmp_path: Path, events: dict[str, Any], words: str) -> None:
    toolpath, cell = job(tmp_path, {**TOOLS, "program": {"events": events}})
    with pytest.raises(CompensatorError, match=words):
        preview_file(toolpath, cell)


def test_a_number_that_the_file_does_not_give(tmp_path: Path) -> None:
    toolpath, cell = job(tmp_path, {**TOOLS, "program": {"events": EVENTS}}, JOB.replace("S5000 M3", "M3"))
    with pytest.raises(CellError, match=r"part\.nc:4: 'M3' gives no S, and .*cell\.toml writes 'SetAO aoSpindle, \{S"):
        compensate_file(toolpath, cell, tmp_path / "o.mod")


def test_where_the_next_tool_is_mounted(tmp_path: Path) -> None:
    """Its tip is where the flange puts it: below the part's top if the arm has not gone up far enough."""
    low = JOB.replace("G0 Z200\nM9", "G0 Z40\nM9")
    toolpath, cell = job(tmp_path, TOOLS, low)
    words = "its tip would be"
    deep = [f for f in compensate_file(toolpath, cell, tmp_path / "o.mod").findings if words in f.what]
    assert len(deep) == 1 and "tool 2 is mounted where the arm stands then" in deep[0].what and deep[0].lines == (14,)
    toolpath, cell = job(tmp_path, {**TOOLS, "program": {"events": {"M6": ["Changer {T};"]}}}, low)
    assert not [f for f in compensate_file(toolpath, cell, tmp_path / "o.mod").findings if words in f.what]
    toolpath, cell = job(tmp_path, TOOLS)
    assert not [f for f in compensate_file(toolpath, cell, tmp_path / "o.mod").findings if words in f.what]


def test_instructions_of_another_robot_are_listed(tmp_path: Path) -> None:
    """A spindle that a KRL program switches on is not switched on by RAPID: that is said, by line."""
    text = """DEF PART()
$TOOL={X 0,Y 0,Z 250,A 0,B 0,C 0}
$BASE={X 1500,Y 0,Z 800,A 0,B 0,C 0}
$VEL.CP=0.02
$OUT[5]=TRUE
SPINDLE_ON(8000,#CW,"x",TRUE)
PTP {X 0,Y 0,Z 50,A 0,B 0,C 180}
LIN {X 0,Y 0,Z -5,A 0,B 0,C 180}
WAIT SEC 2
LIN {X 50,Y 0,Z -5,A 0,B 0,C 180}
END
"""
    toolpath, cell = job(tmp_path, {"tool": None, "workobject": None}, text, "part.src")
    done = compensate_file(toolpath, cell, tmp_path / "o.mod")
    (listed,) = [f for f in done.findings if "no words of its own" in f.what]
    assert "for $OUT, WAIT, SPINDLE_ON:" in listed.what and listed.lines == (5, 6, 9)
    assert not [f for f in compensate_file(toolpath, cell, tmp_path / "o.src").findings if "no words" in f.what]


@pytest.mark.parametrize(
    ("name", "given", "words"),
    [
        ("my-part.src", None, r"'my-part' is no KRL name"),
        ("1part.ls", None, r"'1part' is no TP program name"),
        ("while.pgx", None, r"'while' is no VAL3 name"),
        ("a b.jbi", None, r"'a b' is no INFORM name"),
        ("ok.mod", "1 PART", r"'1 PART' is no RAPID name"),
        ("ok.script", "movel", r"'movel' is no URScript name"),
    ],
)
def test_names_are_refused_before_the_solve(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, given: str | None, words: str
) -> None:
    monkeypatch.setattr("compensator.tasks.compensate.planned", lambda *_: pytest.fail("it was planned"))
    toolpath, cell = job(tmp_path, {**TOOLS, "program": {} if given is None else {"name": given}})
    with pytest.raises(ToolpathError, match=words):
        compensate_file(toolpath, cell, tmp_path / name)


def test_the_module_has_the_name_of_its_file(tmp_path: Path) -> None:
    """[program] name wins; a file may be called as the module may not."""
    for file, given, module in [("a1.mod", None, "a1"), ("a1.mod", "JOB7", "JOB7"), ("1-x.mod", None, "P_1_x")]:
        toolpath, cell = job(tmp_path, {**TOOLS, "program": {} if given is None else {"name": given}})
        done = compensate_file(toolpath, cell, tmp_path / file)
        assert f"MODULE {module}\r\n" in (tmp_path / file).read_bytes().decode()
        assert any("no RAPID name" in f.what for f in done.findings) == (module == "P_1_x")
