"""A program of several files is compensated as one: the same poses as when it stands in one file."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from compensator.errors import CompensatorError
from compensator.tasks.compensate import compensate_file, preview_file
from tests.compensator.small_job import WORN, files
from tests.toolpaths.languages.test_programs_of_several_files import (
    FACE,
    KRL_FILES,
    KRL_MAIN,
    POCKET,
    POINT,
    RAPID_FILES,
    put,
)
from toolpaths.errors import ReadError, WriteError
from toolpaths.files import read_toolpath
from toolpaths.writing.marker import MARKER

OWN = {
    "tool": None, "workobject": None,
    "process": {"kind": "constant", "frame": "workobject", "wrench": [-120.0, 80.0, 60.0, 0.0, 0.0, 0.0]},
}  # fmt: skip


START = "{A1 5,A2 -80,A3 100,A4 75,A5 -60,A6 -65", "{A1 0,A2 10,A3 20,A4 0,A5 60,A6 0"


def one_module() -> str:
    """The modules of RAPID_FILES as one: the same moves in the same order."""
    bodies = []
    for name in ("Face", "Pocket"):
        text = RAPID_FILES[f"m{name}.mod"].replace("p1", f"p{name}1")
        bodies.append(text[text.index("  LOCAL") : text.index("ENDMODULE")])
    cell = RAPID_FILES["Cell.sys"]
    data = cell[cell.index("  PERS tool") : cell.index("ENDMODULE")]
    return RAPID_FILES["mAutodesk.mod"].replace("ENDMODULE", data + "".join(bodies) + "ENDMODULE")


@pytest.mark.parametrize("way", ["main", "folder", "files"])
def test_rapid_as_one(tmp_path: Path, way: str) -> None:
    """Joint states run through all modules: the home moves between the operations are those of the file."""
    cell = files(tmp_path, OWN, WORN).cell
    (tmp_path / "one.mod").write_text(one_module())
    single = compensate_file(tmp_path / "one.mod", cell, tmp_path / "one_c.mod")
    source = put(tmp_path / "in", RAPID_FILES)
    before = {f.name: f.read_bytes() for f in source.iterdir()}
    every = [*source.glob("*.mod"), source / "Cell.sys"]
    given = {"main": source / "mAutodesk.mod", "folder": source, "files": every}[way]
    page = tmp_path / "r.html"
    done = compensate_file(given, cell, tmp_path / "out" / "JOB.mod", json=tmp_path / "s.json", report=page)
    assert re.search(r"line \d+ of m(Face|Pocket)\.mod, pose", page.read_text())
    assert {f.name: f.read_bytes() for f in source.iterdir()} == before
    assert sorted(f.name for f in (tmp_path / "out").iterdir()) == ["JOB.mod", "mFace.mod", "mPocket.mod"]
    written = [tmp_path / "out" / name for name in ("JOB.mod", "mFace.mod", "mPocket.mod")]
    assert all(f.read_text().count(MARKER) == 1 for f in written) and done.files[:3] == tuple(written)
    a = read_toolpath(tmp_path / "one_c.mod")
    b = read_toolpath(written[0], others=[*written[1:], source / "Cell.sys"])
    np.testing.assert_array_equal(a.position, b.position)
    np.testing.assert_array_equal(a.quaternion, b.quaternion)
    assert done.report["predicted_error_mm"] == single.report["predicted_error_mm"]
    assert done.report["predicted_error_mm"]["before"]["mean"] > 0.4
    told = json.loads((tmp_path / "s.json").read_text())
    turned = {Path(r["source_file"]).name for r in told["reversals"]}
    assert turned <= {"mAutodesk.mod", "mFace.mod", "mPocket.mod"} and len(turned) > 1
    with pytest.raises(ReadError, match="compensated already"):
        compensate_file(written, cell, tmp_path / "again.mod")


def test_krl_as_one(tmp_path: Path) -> None:
    """Two operations with a point of the same name, each in its own .dat."""
    cell = files(tmp_path, {**OWN, "tool": {"xyz": [30.0, -20.0, 240.0], "rpy": [0.0, 0.0, 0.0]}}, WORN).cell
    bodies = [t[t.index("DEF") :] for t in (FACE.replace(*START), POCKET.replace("XP1", "XP2"))]
    tool = ("TOOL_DATA[3]", "{X 30,Y -20,Z 240,A 0,B 0,C 0}")
    (tmp_path / "one.src").write_text(KRL_MAIN.replace(*tool) + "".join(bodies))
    points = f"DECL E6POS XP1={POINT.format(100, 0)}\nDECL E6POS XP2={POINT.format(30, 40)}\n"
    (tmp_path / "one.dat").write_text(f"DEFDAT one\n{points}ENDDAT\n")
    compensate_file(tmp_path / "one.src", cell, tmp_path / "one_c.src")
    several = {name: t.replace(*tool).replace(*START) for name, t in KRL_FILES.items()}
    source = put(tmp_path / "in", several)
    done = compensate_file(source, cell, tmp_path / "out" / "JOB.src")
    names = ["JOB.dat", "JOB.src", "sFace.dat", "sFace.src", "sPocket.dat", "sPocket.src"]
    assert sorted(f.name for f in (tmp_path / "out").iterdir()) == names and len(done.files) == 6
    a, b = read_toolpath(tmp_path / "one_c.src"), read_toolpath(tmp_path / "out" / "JOB.src")
    cut = a.kind == 1
    np.testing.assert_array_equal(a.position[cut], b.position[cut])
    for name in ("sFace", "sPocket"):  # the points themselves were changed, each in its own file
        text = (tmp_path / "out" / f"{name}.dat").read_text()
        assert text.count("DECL") == 1 and "XP1={X" in text and several[f"{name}.dat"] != text


def test_the_folder_of_the_source_is_not_written_to(tmp_path: Path) -> None:
    cell = files(tmp_path, OWN, WORN).cell
    source = put(tmp_path / "in", RAPID_FILES)
    with pytest.raises(WriteError, match=r"other files of the program change, too \(mFace\.mod, mPocket\.mod\)"):
        compensate_file(source / "mAutodesk.mod", cell, source / "new.mod")
    assert not (source / "new.mod").exists()
    compensate_file(source / "mAutodesk.mod", cell, tmp_path / "new.src")  # another language: one program
    assert (tmp_path / "new.src").exists()


def test_a_target_of_another_module_changes_there(tmp_path: Path) -> None:
    """It holds no moves, so that this is known only when the program is written."""
    cell = files(tmp_path, OWN, WORN).cell
    moved = RAPID_FILES["mFace.mod"].replace("  LOCAL CONST robtarget p1:=", "  CONST robtarget pIn:=").split("\n")
    point = next(line for line in moved if "pIn:=" in line)
    face = "\n".join(line for line in moved if line != point).replace("p1,", "pIn,")
    source = put(tmp_path / "in", {k: v for k, v in RAPID_FILES.items() if k not in ("JOB.pgf", "mPocket.mod")})
    put(source, {
        "mAutodesk.mod": RAPID_FILES["mAutodesk.mod"].replace("    pPocket;\n", ""), "mFace.mod": face,
        "data.mod": f"MODULE data\n{point}\nENDMODULE\n",
    })  # fmt: skip
    compensate_file(source, cell, tmp_path / "out" / "JOB.mod")
    text = (tmp_path / "out" / "data.mod").read_text()
    assert MARKER in text and "pIn:=[[" in text and point not in text
    assert sorted(f.name for f in (tmp_path / "out").iterdir()) == ["JOB.mod", "data.mod", "mFace.mod"]


def test_a_wrench_table_counts_lines_of_one_file(tmp_path: Path) -> None:
    (tmp_path / "w.csv").write_text("index,fx,fy,fz,mx,my,mz\n10,1,0,0,0,0,0\n")
    cell = files(tmp_path, {**OWN, "process": {"kind": "table", "file": "w.csv", "frame": "base"}}, WORN).cell
    with pytest.raises(CompensatorError, match=r"its index counts lines, and .* is a program of 4 files"):
        preview_file(put(tmp_path / "in", RAPID_FILES), cell)
