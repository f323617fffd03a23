"""A robot program in, the same program with better poses out: from files to files."""

from __future__ import annotations

import json
import re
import tomllib
from collections import Counter
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w

from compensator.errors import CompensatorError
from compensator.program.provenance import without_head
from compensator.tasks.compensate import compensate_file, preview_file
from tests.compensator.small_job import CELL, MODEL, WORN, files, merged
from tests.oracles.robot_programs import KRL, KRL_DAT, RAPID
from toolpaths.errors import ReadError, ToolpathError
from toolpaths.files import read_toolpath
from toolpaths.writing.marker import MARKER

PAGE = Path(__file__).parents[3] / "docs" / "filter.md"
STIFF = {"effects": {"joint-stiffness": {"k_nm_per_rad": [1e12] * 6}}}
CALM = {"process": {"kind": "constant", "frame": "workobject", "wrench": [0.0] * 6}}
KUKA_TOOL = {"tool": {"name": "spindle"}}


def job(folder: Path, cell: Mapping[str, Any] | None = None, model: Mapping[str, Any] | None = None) -> Path:
    """The cell of the small jobs, with RAPID and KRL beside it."""
    (folder / "part.mod").write_bytes(RAPID.replace("\n", "\r\n").encode())
    (folder / "part.src").write_bytes(KRL.replace("\n", "\r\n").encode())
    (folder / "part.dat").write_bytes(KRL_DAT.replace("\n", "\r\n").encode())
    return files(folder, cell, model).cell


@pytest.mark.parametrize("suffix", [".mod", ".src"])
def test_the_written_program_stands_where_it_should(tmp_path: Path, suffix: str) -> None:
    source, out = tmp_path / f"part{suffix}", tmp_path / f"part_c{suffix}"
    done = compensate_file(source, job(tmp_path), out, json=tmp_path / "s.json")
    error = done.report["predicted_error_mm"]
    assert error["before"]["mean"] > 0.9 and error["after"]["max"] < 0.006  # half of sampling.chord, and printing
    told = json.loads((tmp_path / "s.json").read_text())["changes"]
    assert any("became numbers" in c["what"] for c in told) and all(c["where"].startswith("line ") for c in told)
    before, after = read_toolpath(source), read_toolpath(out)
    ends = [p.position[np.abs(p.row - np.rint(p.row)) < 1e-9] for p in (before, after)]
    assert len(ends[1]) >= len(ends[0])
    assert np.linalg.norm(ends[1][-1] - ends[0][-1]) * 1e3 == pytest.approx(1.0, abs=0.1)
    assert out.read_bytes().count(MARKER.encode()) == 1
    assert (tmp_path / "part_c.dat").exists() == (suffix == ".src")


@pytest.mark.parametrize("suffix", [".mod", ".src"])
def test_a_rigid_robot_without_load_changes_nothing(tmp_path: Path, suffix: str) -> None:
    source, out = tmp_path / f"part{suffix}", tmp_path / f"part_c{suffix}"
    done = compensate_file(source, job(tmp_path, CALM, STIFF), out)
    lines = out.read_bytes().split(b"\r\n")
    rest = [line for line in lines if MARKER.encode() not in line]
    assert len(rest) == len(lines) - 1 and b"\r\n".join(rest) == source.read_bytes()
    assert done.report["changes"] == []


TWO = """MODULE TWO
  PERS tooldata tA:=[TRUE,[[0,0,250],[1,0,0,0]],[30,[0,0,110],[1,0,0,0],0,0,0]];
  PERS tooldata tB:=[TRUE,[[0,0,300],[1,0,0,0]],[30,[0,0,110],[1,0,0,0],0,0,0]];
  PERS wobjdata w1:=[FALSE,TRUE,"",[[1500,-150,800],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
  PERS wobjdata w2:=[FALSE,TRUE,"",[[1500,250,800],[0.984807753,0,0,0.173648178]],[[0,0,0],[1,0,0,0]]];
  CONST robtarget p10:=[[0,0,-2],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget p20:=[[100,0,-2],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    MoveJ Offs(p10,0,0,50),v1000,z10,tA\\WObj:=w1;
    MoveL p10,v20,fine,tA\\WObj:=w1;
    MoveL p20,v20,fine,tA\\WObj:=w1;
    MoveL Offs(p20,0,0,50),v1000,z10,tA\\WObj:=w1;
    MoveJ Offs(p10,0,0,50),v1000,z10,tB\\WObj:=w2;
    MoveL p10,v20,fine,tB\\WObj:=w2;
    MoveL p20,v20,fine,tB\\WObj:=w2;
    MoveL Offs(p20,0,0,50),v1000,z10,tB\\WObj:=w2;
  ENDPROC
ENDMODULE
"""
LIGHT = {"process": {"kind": "constant", "frame": "workobject", "wrench": [-120.0, 80.0, 60.0, 0.0, 0.0, 0.0]}}


def test_rapids_stay_and_the_flanks_behind_them_are_known(tmp_path: Path) -> None:
    """Two tools, two work objects, worn joints: what the rapids between two cuts do to the gaps is that of the file."""
    cell = job(tmp_path, {"tool": None, "workobject": None, **LIGHT}, WORN)
    (tmp_path / "two.mod").write_text(TWO)
    done = compensate_file(tmp_path / "two.mod", cell, tmp_path / "c.mod")
    error = done.report["predicted_error_mm"]
    assert error["before"]["mean"] > 0.4 and error["after"]["max"] < 0.006  # 0.04 and more with another rapid
    joint_moves = [
        [line for line in f.read_text().split("\n") if "MoveJ" in line] for f in (tmp_path / "two.mod", done.files[0])
    ]
    assert joint_moves[0] == joint_moves[1] and len(joint_moves[0]) == 2


def test_poses_put_in_may_make_another_work_object_the_first(tmp_path: Path) -> None:
    """The source cuts most in w1, the written program in w2: it is the same program all the same."""
    text = TWO.replace("Offs(p20,0,0,50),v1000,z10,tA", "Offs(p20,5,0,0),v20,z10,tA")
    (tmp_path / "two.mod").write_text(text)
    cell = job(tmp_path, {"tool": None, "workobject": None, **LIGHT}, WORN)
    done = compensate_file(tmp_path / "two.mod", cell, tmp_path / "c.mod")
    cuts = Counter(re.findall(r"MoveL.*:=(w.);", (tmp_path / "c.mod").read_text()))
    assert text.count("MoveL") == 6 and cuts["w2"] > cuts["w1"] > 2
    assert done.report["predicted_error_mm"]["after"]["max"] < 0.006


def test_every_line_that_changed_is_told(tmp_path: Path) -> None:
    """Repeats are merged in words; ``lines`` has each of them."""
    cell = job(tmp_path, {"tool": None, "workobject": None, **LIGHT}, WORN)
    (tmp_path / "two.mod").write_text(TWO)
    compensate_file(tmp_path / "two.mod", cell, tmp_path / "c.mod", json=tmp_path / "s.json")
    (told,) = (c for c in json.loads((tmp_path / "s.json").read_text())["changes"] if "put in" in c["what"])
    written = [line for line in (tmp_path / "c.mod").read_text().split("\n") if "MoveL" in line]
    grown = [",z0," in before for before, line in pairwise(["", *written]) if ",fine," in line]
    lines = [k for k, line in enumerate(TWO.split("\n"), 1) if "MoveL" in line and ",fine," in line]
    assert [k in told["lines"] for k in lines] == grown and sum(grown) > 1
    assert told["where"] == f"line {told['lines'][0]}" and told["count"] == len(written) - TWO.count("MoveL")


def test_a_compensated_program_is_refused(tmp_path: Path) -> None:
    cell = job(tmp_path)
    compensate_file(tmp_path / "part.mod", cell, tmp_path / "a.mod")
    with pytest.raises(ReadError, match=r"a\.mod:6: this program is compensated already"):
        compensate_file(tmp_path / "a.mod", cell, tmp_path / "b.mod")
    assert not (tmp_path / "b.mod").exists()
    compensate_file(tmp_path / "path.csv", cell, tmp_path / "export.mod")  # written, not filtered: the same
    with pytest.raises(ReadError, match="compensated already"):
        compensate_file(tmp_path / "export.mod", cell, tmp_path / "b.mod")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"tool": {"xyz": [30.0, -20.0, 241.0]}}, ["tool 'tool'", "spindle", "240.000", "241.000"]),
        ({"tool": {"rpy": [0.0, 25.1, 0.0]}}, ["0.1000 deg"]),
        ({"workobject": {"xyz": [1500.0, -150.0, 801.0]}}, ["[workobject]", "801.000", "800.000"]),
    ],
)
def test_a_cell_that_contradicts_the_program(tmp_path: Path, change: dict[str, Any], words: list[str]) -> None:
    with pytest.raises(CompensatorError) as caught:
        compensate_file(tmp_path / "part.mod", job(tmp_path, change), tmp_path / "c.mod")
    assert all(word in str(caught.value) for word in [*words, "cell.toml", "part.mod"])


def test_a_program_brings_its_tool_and_work_object(tmp_path: Path) -> None:
    cell = job(tmp_path)
    compensate_file(tmp_path / "part.mod", cell, tmp_path / "a.mod")
    bare = tomllib.loads(cell.read_text())
    del bare["tool"], bare["workobject"]
    cell.write_text(tomli_w.dumps(bare))
    done = compensate_file(tmp_path / "part.mod", cell, tmp_path / "b.mod")
    assert done.report["predicted_error_mm"]["before"]["mean"] > 0.9
    assert without_head((tmp_path / "a.mod").read_bytes()) == without_head((tmp_path / "b.mod").read_bytes())
    with pytest.raises(CompensatorError, match=r"cell\.toml: workobject is missing; to copy"):
        preview_file(tmp_path / "path.csv", cell)
    cell.write_text(tomli_w.dumps({**bare, "workobject": {"xyz": [1500.0, -150.0, 800.0]}}))
    with pytest.raises(CompensatorError, match=r"give either \[tool\] or \[tools\.1\]"):
        preview_file(tmp_path / "path.csv", cell)


def test_tools_by_name_and_another_language(tmp_path: Path) -> None:
    cell = tmp_path / "cell.toml"
    job(tmp_path)
    tools = {"tool": None, "tools": {"7": {**CELL["tool"], "name": "Spindle"}}}
    cell.write_text(tomli_w.dumps(merged(CELL, tools)))
    done = compensate_file(tmp_path / "part.mod", cell, tmp_path / "c.csv")
    assert done.report["predicted_error_mm"]["after"]["max"] < 1e-4 and "changes" not in done.report
    assert preview_file(tmp_path / "part.mod", cell).report["n_cut"] == done.report["n_cut"]


LINKS = """DEF PART()
$TOOL={X 0,Y 0,Z 250,A 0,B 0,C 0}
$BASE={X 1500,Y 0,Z 800,A 0,B 0,C 0}
$VEL.CP=0.02
PTP {X 0,Y 0,Z 50,A 0,B 0,C 180}
LIN {X 0,Y 0,Z -5,A 0,B 0,C 180}
LIN {X 100,Y 0,Z -5,A 0,B 0,C 180}
PTP {X 100,Y 0,Z 100,A 0,B 0,C 180}
PTP {X 0,Y 100,Z 100,A 0,B 0,C 180}
PTP {X 0,Y 100,Z 3,A 0,B 0,C 180}
LIN {X 0,Y 100,Z -5,A 0,B 0,C 180}
LIN {X 100,Y 100,Z -5,A 0,B 0,C 180}
PTP {X 100,Y 100,Z 100,A 0,B 0,C 180}
END
"""


def test_another_language_keeps_the_retracts(tmp_path: Path) -> None:
    """Written anew, the arm goes between two cuts where the source goes, not through the part, and leaves it."""
    (tmp_path / "links.src").write_text(LINKS)
    cell = files(tmp_path, {"tool": None, "workobject": None}, STIFF).cell
    compensate_file(tmp_path / "links.src", cell, tmp_path / "o.csv")
    rows = np.genfromtxt(tmp_path / "o.csv", delimiter=",", names=True, dtype=None, encoding="ascii")
    x, y, z = (rows[f"{c}_mm"] for c in "xyz")
    between = (y > 1.0) & (y < 99.0)
    assert between.sum() > 5 and z[between].min() > 99.0 and z[-1] > 99.0
    high = np.flatnonzero((z > 99.0) & (y < 1.0))
    assert x[high].min() > 99.0 and rows["kind"][high].tolist() == ["rapid"] * len(high)


def test_moves_in_joint_angles_go_through_the_robot(tmp_path: Path) -> None:
    """The first pose in joint angles instead: what cuts is compensated as before."""
    cell = job(tmp_path)
    compensate_file(tmp_path / "part.mod", cell, tmp_path / "a.mod")
    preview_file(tmp_path / "part.mod", cell, csv=tmp_path / "a.csv")
    first = (tmp_path / "a.csv").read_text().split("\n")[:2]
    row = dict(zip(first[0].split(","), first[1].split(","), strict=True))
    angles = ",".join(row[f"q{k}_deg"] for k in range(1, 7))
    text = RAPID.replace("MoveJ safe,v1000", f"MoveAbsJ [[{angles}],[9E9,9E9,9E9,9E9,9E9,9E9]],v1000", 1)
    (tmp_path / "part.mod").write_bytes(text.replace("\n", "\r\n").encode())
    compensate_file(tmp_path / "part.mod", cell, tmp_path / "b.mod")
    a, b = (tmp_path / n for n in ("a.mod", "b.mod"))
    pick = re.compile(rb"    Move[LC] .*")
    numbers = [np.array(re.findall(rb"-?\d+\.\d+", b" ".join(pick.findall(f.read_bytes()))), float) for f in (a, b)]
    np.testing.assert_allclose(*numbers, atol=2e-3)


def test_the_suffix_of_the_source_says_the_language(tmp_path: Path) -> None:
    cell = job(tmp_path)
    (tmp_path / "part.mod").rename(tmp_path / "part.prg")
    done = compensate_file(tmp_path / "part.prg", cell, tmp_path / "c.PRG")
    assert done.report["changes"] and MARKER in done.files[0].read_text()
    with pytest.raises(ToolpathError, match=r"suffix '\.prg' is no language's"):
        compensate_file(tmp_path / "part.src", cell, tmp_path / "d.prg")
    with pytest.raises(ToolpathError, match="there is no format 'apt'"):
        compensate_file(tmp_path / "part.apt", cell, tmp_path / "d.apt")


def test_a_program_of_another_robot(tmp_path: Path) -> None:
    cell = job(tmp_path)
    bare = tomllib.loads(cell.read_text())
    bare.pop("start", None)
    cell.write_text(tomli_w.dumps(bare))
    angles = "0,0,0,0,200,0"
    text = RAPID.replace("MoveJ safe,v1000", f"MoveAbsJ [[{angles}],[9E9,9E9,9E9,9E9,9E9,9E9]],v1000", 1)
    (tmp_path / "part.mod").write_text(text)
    with pytest.raises(CompensatorError, match=r"part\.mod:\d+: joint 5 at 200\.000 deg is outside .* another robot"):
        preview_file(tmp_path / "part.mod", cell)


def test_nothing_is_left_behind(tmp_path: Path) -> None:
    cell = job(tmp_path, {"workobject": {"xyz": [1500.0, -150.0, 801.0]}})
    before = sorted(p.name for p in tmp_path.iterdir())
    with pytest.raises((CompensatorError, ToolpathError)):
        compensate_file(tmp_path / "part.src", cell, tmp_path / "c.src")
    assert sorted(p.name for p in tmp_path.iterdir()) == before


def test_the_example_of_the_page(tmp_path: Path) -> None:
    blocks = dict(re.findall(r"^```(\w+) ?\w*\n(.*?)^```$", PAGE.read_text(), re.M | re.S))
    (tmp_path / "cell.toml").write_text(blocks["toml"])
    (tmp_path / "model.toml").write_text(tomli_w.dumps(MODEL))
    (tmp_path / "part.mod").write_text(blocks["mod"])
    compensate_file(tmp_path / "part.mod", tmp_path / "cell.toml", tmp_path / "part_c.mod")
    old, new = (set((tmp_path / n).read_text().split("\n")) for n in ("part.mod", "part_c.mod"))
    number = re.compile(r"-?\d+\.\d+")
    shown = [line[1:] for line in blocks["diff"].split("\n") if line.startswith("+")]
    came = [line for line in (tmp_path / "part_c.mod").read_text().split("\n") if line not in old]
    came, shown = ([re.sub("sha256:[0-9a-f]{12}", "sha256:", line) for line in lines] for lines in (came, shown))
    assert [number.sub("#", line) for line in came] == [number.sub("#", line) for line in shown]
    for a, b in zip(came, shown, strict=True):
        values = [[float(v) for v in number.findall(text)] for text in (a, b)]
        np.testing.assert_allclose(*values, atol=2e-3)
    gone = [line[1:] for line in blocks["diff"].split("\n") if line.startswith("-")]
    assert set(gone) == old - new
