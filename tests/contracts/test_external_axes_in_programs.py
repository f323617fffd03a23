"""External axes in RAPID and KRL: a rail, a table. They pass through; what is not modelled is refused by line."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from tests.oracles.commanded import SHIFT, changed_lines, commanded
from toolpaths.errors import WriteError
from toolpaths.external_axes import places, unmodelled, whole_moves
from toolpaths.files import read_toolpath
from toolpaths.languages.krl import filter as krl_filter
from toolpaths.languages.krl import reader as krl
from toolpaths.languages.rapid import filter as rapid_filter
from toolpaths.languages.rapid import reader as rapid
from toolpaths.rewriting.filter import Rewritten
from toolpaths.toolpath import Toolpath
from toolpaths.writing.marker import MARKER

#: Where the first external axis stands at a rapid and four cuts; None: the pose does not say.
Places = list[float | str | None]
REWRITE = {".mod": rapid_filter.rewrite, ".src": krl_filter.rewrite}
NAME = {".mod": "eax_a", ".src": "E1"}


def program(suffix: str, places: Places) -> str:
    """A rapid, a line, a line, an arc, a line; the number of a line is that of its place plus 4."""
    if suffix == ".mod":
        other = ",-17.5,9E9,9E+09,9E9,9E9]"
        poses = [
            f"[[{10 * k},{k * k},5],[0,1,0,0],[0,0,-1,1],[{'9E9' if e is None else e}{other}]"
            for k, e in enumerate(places)
        ]
        a, b, c, d, e = poses
        via = a.replace("[[0,0,5]", "[[25,2,5]")
        lines = [f"MoveJ {a}", f"MoveL {b}", f"MoveL {c}", f"MoveC {via},{d}", f"MoveL {e}"]
        body = "".join(f"    {line},v20,fine,tool0;\n" for line in lines)
        return f"MODULE M\n  ! four\n  PROC main()\n{body}  ENDPROC\nENDMODULE\n"
    said = ["" if e is None else f",E1 {e}" for e in places]
    poses = [f"{{X {10 * k},Y {k * k},Z 5,A 0,B 0,C 180,S 2,T 35{e},E2 -17.5}}" for k, e in enumerate(said)]
    a, b, c, d, e = poses
    via = "{X 25,Y 2,Z 5,A 0,B 0,C 180}"
    lines = [f"PTP {a}", f"LIN {b}", f"LIN {c}", f"CIRC {via},{d}", f"LIN {e}"]
    return "DEF M()\n; three\n$VEL.CP=0.02\n" + "".join(f"{line} C_DIS\n" for line in lines) + "END\n"


def read(folder: Path, suffix: str, places: Places) -> tuple[Path, Toolpath]:
    file = folder / f"M{suffix}"
    file.write_text(program(suffix, places))
    return file, read_toolpath(file)


def rewritten(file: Path, put_in: list[float]) -> Rewritten:
    """The program with all poses of cuts moved, and poses put in at some rows."""
    read_moves = {".mod": rapid.moves_of, ".src": lambda data, name: krl.moves_of(data, name, file)}[file.suffix]
    path = read_moves(file.read_bytes(), str(file)).toolpath(1e-5)  # what the reader refuses after that, too
    row = np.sort(np.concatenate([path.row, put_in]))
    made, _ = commanded(path, np.searchsorted(path.row, row), SHIFT)
    return REWRITE[file.suffix](file.read_bytes(), made, row, file)


def first_axis(text: bytes) -> list[str]:
    """How the moves of a program spell the first external axis, in their order."""
    found = re.findall(rb"\],\[([^,\[\]]+),-17\.5,|E1 ([^,}]+),E2 -17\.5", text)
    return [(a or b).decode() for a, b in found]


@pytest.mark.parametrize("suffix", [".mod", ".src"])
def test_an_axis_that_stands_still_passes_through_untouched(tmp_path: Path, suffix: str) -> None:
    file, path = read(tmp_path, suffix, ["1500.250"] * 5)
    np.testing.assert_array_equal(path.setting.external[NAME[suffix]], [1500.25] * 5)
    out = rewritten(file, [0.5, 3.25, 3.5])
    gone, come = changed_lines(file.read_bytes(), out.text)
    assert len(gone) == 4 and len(come) == 8 and any(MARKER in line for line in come)
    assert set(first_axis(out.text)) == {"1500.250"} and out.text.count(b"-17.5") == 8 + (suffix == ".mod")
    told = dict(unmodelled(path.setting.external, whole_moves(path)[1]))
    assert told[NAME[suffix]] == "stands at 1500.25 in the cuts"


@pytest.mark.parametrize("suffix", [".mod", ".src"])
@pytest.mark.parametrize("places", [[0.0] * 5, ["0.00"] * 5, [None] * 5])
def test_axes_at_zero_or_not_there_are_not_spoken_of(tmp_path: Path, suffix: str, places: Places) -> None:
    file, path = read(tmp_path, suffix, places)
    assert list(path.setting.external) == [NAME[suffix].replace("a", "b").replace("ebx", "eax").replace("1", "2")]
    told = dict(unmodelled(path.setting.external, whole_moves(path)[1]))
    assert len(told) == 1 and NAME[suffix] not in told  # of the other axis
    rewritten(file, [0.5])


@pytest.mark.parametrize("suffix", [".mod", ".src"])
def test_within_a_move_an_axis_is_on_the_way(tmp_path: Path, suffix: str) -> None:
    """Evenly between the ends of the move, where both are known; arcs and poses put in are such rows."""
    path = read(tmp_path, suffix, [0, 100, 100, 150, -50])[1]
    values = path.setting.external[NAME[suffix]]
    assert places(values, np.array([0.0, 0.25, 1.0, 2.5, 2.75, 4.0])).tolist() == [0, 25, 100, 125, 137.5, -50]
    part = np.array([np.nan, np.nan, 8.0, 10.0])
    assert places(part, np.array([0.0, 1.0, 1.5, 2.0, 2.5])).tolist() == [0, 0, 8, 8, 9]


@pytest.mark.parametrize("suffix", [".mod", ".src"])
def test_an_axis_may_move_between_cuts(tmp_path: Path, suffix: str) -> None:
    one, two = program(suffix, [0, 0, 0, 0, 0]), program(suffix, [90, 90, 90, 90, 90])
    lines = one.split("\n")
    lines[8:8] = [line for line in two.split("\n") if "90" in line]
    file = tmp_path / f"M{suffix}"
    file.write_text("\n".join(lines))
    path = read_toolpath(file)
    told = dict(unmodelled(path.setting.external, whole_moves(path)[1]))
    assert told[NAME[suffix]] == "moves between 0 and 90 in or between the cuts"


@pytest.mark.parametrize("suffix", [".mod", ".src"])
def test_poses_put_in_have_the_axis_where_it_is_on_the_way(tmp_path: Path, suffix: str) -> None:
    """Axes that carry nothing may move in the cut: the controller moves them evenly, together with the TCP."""
    file = tmp_path / f"M{suffix}"
    file.write_text(program(suffix, [100, "100", "200.00", 200, "-40.5"]))
    out = rewritten(file, [0.5, 1.25, 1.5, 2.5, 3.1])
    shown = [float(v) for v in first_axis(out.text)]
    np.testing.assert_allclose(shown[:6], [100, 100, 100, 125, 150, 200])
    np.testing.assert_allclose(shown[-3:], [200, 175.95, -40.5])
    assert "200.00" in first_axis(out.text) and out.text.count(b"-17.5") == len(shown)


@pytest.mark.parametrize("suffix", [".mod", ".src"])
def test_poses_are_not_put_in_where_the_axis_is_not_known(tmp_path: Path, suffix: str) -> None:
    file = tmp_path / f"M{suffix}"
    file.write_text(program(suffix, [None, 100, 100, 100, 130]))
    with pytest.raises(WriteError, match=rf"M{suffix}:5.*where {NAME[suffix]} stands before the move is not known"):
        rewritten(file, [0.5])
    assert first_axis(rewritten(file, [1.5]).text).count("100") == 4


def test_a_target_that_is_split_or_worked_out_keeps_its_axes(tmp_path: Path) -> None:
    axes = "[1500.25,9E9,9E9,9E9,9E9,9E9]"
    text = f"""MODULE M
  CONST robtarget p1:=[[0,0,5],[0,1,0,0],[0,0,-1,1],{axes}];
  PROC main()
    MoveJ Offs(p1,0,0,50),v20,fine,tool0;
    MoveL p1,v20,fine,tool0;
    MoveL RelTool(p1,10,0,0),v20,fine,tool0;
  ENDPROC
ENDMODULE
"""
    file = tmp_path / "M.mod"
    file.write_text(text)
    lines = rewritten(file, [1.5]).text.decode().split("\n")
    assert f"  CONST robtarget p1_c1:=[[0.1200,-0.3400,5.5600],[0,1,0,0],[0,0,-1,1],{axes}];" in lines
    assert sum(axes in line for line in lines) == 4  # p1, p1_c1, and two in numbers


def test_missing_components_of_krl_keep_their_value(tmp_path: Path) -> None:
    pose = "{{X {},Y 0,Z 5,A 0,B 0,C 180{}}}"
    body = "\n".join(f"LIN {pose.format(k, e)}" for k, e in enumerate([",E1 70", "", ",E2 3,E1 70", "", ",S 2"]))
    file = tmp_path / "M.src"
    file.write_text(f"DEF M()\n{body}\nPTP HOME\nPTP {pose.format(1, ',E2 3')}\nEND\n")
    external = read_toolpath(file).setting.external
    np.testing.assert_array_equal(external["E1"], [70, 70, 70, 70, 70, np.nan])
    np.testing.assert_array_equal(external["E2"], [np.nan, np.nan, 3, 3, 3, 3])
