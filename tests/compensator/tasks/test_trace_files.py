"""The verb trace, from files to files: what is asked for, what is written, what is refused."""

from __future__ import annotations

import csv
import json
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from compensator.cli import main
from compensator.devices.index_rows import index_rows
from compensator.devices.order import TraceOrder
from compensator.errors import CompensatorError, DeviceError
from compensator.tasks.trace import TraceMade, trace_file
from tests.compensator.devices.device_samples import BAR, NOMINALS, PCDMIS, PROBE, QIF, SA, SA_BARE, TABLE

PROGRAM = "index,kind,q1_deg\n" + "".join(f"{k},cut,0\n" for k in range(6))


def made(folder: Path, text: str, name: str = "device.txt", *, order: dict[str, Any], **options: Any) -> TraceMade:
    (folder / name).write_text(text, newline="")
    return trace_file(folder / name, folder / "trace.toml", order=TraceOrder(**order), **options)


def rows(folder: Path, name: str = "samples.csv") -> dict[str, list[float]]:
    table = list(csv.DictReader((folder / name).read_text().splitlines()))
    return {key: [float(row[key]) for row in table] for key in table[0]}


def test_a_stream_of_positions(tmp_path: Path) -> None:
    done = made(tmp_path, SA, order={"frame": "free", "noise": 0.01, "dry": True})
    assert [f.name for f in done.files] == ["trace.toml", "samples.csv"]
    assert tomllib.loads((tmp_path / "trace.toml").read_text()) == {
        "schema": "trace/1",
        "cell": "cell.toml",
        "program": "run.csv",
        "samples": "samples.csv",
        "kind": "positions",
        "registered": False,
        "dry": True,
        "instrument": {"noise": 0.01},
    }
    assert rows(tmp_path) == {
        "x": [100, 101, 102], "y": [-200.5] * 3, "z": [30.25] * 3, "time": [0.0, 0.5, 1.25]
    }  # fmt: skip
    levels = [(f["level"], f["what"].split(":")[0]) for f in done.report["findings"]]
    assert ("note", "no index") in levels and ("warning", "cell = 'cell.toml'") in levels
    assert done.report["duration_s"] == 1.25 and done.report["n_samples"] == 3


def test_everything_that_is_missing_is_asked_for_at_once(tmp_path: Path) -> None:
    with pytest.raises(DeviceError) as refused:
        made(tmp_path, SA_BARE, order={"point": "1"})
    told = str(refused.value)
    assert all(option in told for option in ("--units mm | inch", "--frame base", "--noise MM", "--index ROWS"))
    with pytest.raises(DeviceError, match=r"--frame free .*calls its frame 'A::WORLD'"):
        made(tmp_path, SA, order={"noise": 0.01})
    with pytest.raises(DeviceError, match=r"--center X Y Z.*\n.*--radius MM"):
        made(tmp_path, BAR, order={"noise": 0.001})
    assert sorted(p.name for p in tmp_path.iterdir()) == ["device.txt"]


def test_several_visits_are_runs(tmp_path: Path) -> None:
    order = {"units": "mm", "frame": "base", "noise": 0.01, "index": "4", "point": "2"}
    done = made(tmp_path, SA_BARE, order=order)
    assert rows(tmp_path) == {
        "index": [4, 4], "x": [2331.349757] * 2, "y": [-2328.039341] * 2, "z": [-547.862927] * 2, "run": [1, 2]
    }  # fmt: skip
    assert done.report["n_runs"] == 2 and done.report["registered"] is True
    with pytest.raises(DeviceError, match=r"'1' \(2 points\), '2' \(2 points\).*give it as --point"):
        made(tmp_path, SA_BARE, order={**order, "point": None})


def test_strays_of_another_group_are_counted(tmp_path: Path) -> None:
    head, *body = SA.split("Run,", 1)
    many = "".join(f"Run,  Fast,  {k},  {k}.000000,  0.000000,  0.000000,  02/12/25 16:56:08\n" for k in range(120))
    stray = "Other,  Set,  1,  9.000000,  0.000000,  0.000000,  02/12/25 16:25:00\n"
    done = made(tmp_path, head + many + stray, order={"frame": "free", "noise": 0.01})
    found = next(f for f in done.report["findings"] if "other groups" in f["what"])
    assert (found["level"], found["source_line"], found["count"]) == ("warning", 124, 1)
    assert done.report["n_read"] == 121 and len(rows(tmp_path)["x"]) == 120 and body
    with pytest.raises(DeviceError, match=r"several groups of points: 'Run::Fast' \(3 points\), 'Other::Set'"):
        made(tmp_path, SA + stray, order={"frame": "free", "noise": 0.01})
    chosen = made(tmp_path, SA + stray, order={"frame": "free", "noise": 0.01, "group": "Other::Set"})
    assert chosen.report["n_samples"] == 1


def test_a_report_without_normals_takes_them_from_the_drawing(tmp_path: Path) -> None:
    order = {"frame": "workobject", "noise": 0.002}
    with pytest.raises(DeviceError, match=r"--nominals FILE\.csv.*\n    name,x,y,z,i,j,k\n    PLN4,\?,42\.5,\?"):
        made(tmp_path, PCDMIS, order=order)
    (tmp_path / "nominals.csv").write_text(NOMINALS)
    made(tmp_path, PCDMIS, order=order, nominals=tmp_path / "nominals.csv")
    got = rows(tmp_path)
    assert got["deviation"] == pytest.approx([0.02, 0.03 * 0.6 + 0.04 * 0.8, -0.061])
    assert [got[k] for k in "xyzijk"] == [[1, 10, 4], [42.5, 5, 5], [3, -7, 6], [0, 0.6, 0], [1, 0.8, 0], [0, 0, -1]]
    (tmp_path / "some.csv").write_text("name,x,y,z,i,j,k\nPLN4,1,42.5,3,0,1,0\nPNT1,10,5,-7,0,0,1\nXX,1,1,1,0,0,1\n")
    done = made(tmp_path, PCDMIS, order=order, nominals=tmp_path / "some.csv")
    whats = [f["what"] for f in done.report["findings"]]
    assert any("are left out: PNT2" in w for w in whats) and any("that it has not: XX" in w for w in whats)
    assert rows(tmp_path)["deviation"] == [0.02, 0.0]


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ("PLN4,1,42.5", "PLN4,1,43.5", r"line 3: y of 'PLN4' is 42\.5 there, but 43\.5 at line 2"),
        ("0,1,0\nPNT1", "0,2,0\nPNT1", r"line 3: point 'PLN4': the normal .* has length 2"),
        ("PNT1,", "PLN4,", r"nominals\.csv: line 3: 'PLN4' stands twice"),
        ("name,x", "nom,x", r"nominals\.csv: line 1: no column name"),
        ("4,5,6", "4,5,b", r"nominals\.csv: line 4: column z is 'b'"),
    ],
)
def test_refused_nominals(tmp_path: Path, old: str, new: str, why: str) -> None:
    assert old in NOMINALS
    (tmp_path / "nominals.csv").write_text(NOMINALS.replace(old, new))
    with pytest.raises(DeviceError, match=why):
        made(tmp_path, PCDMIS, order={"frame": "workobject", "noise": 1}, nominals=tmp_path / "nominals.csv")


def test_inches_become_millimetres(tmp_path: Path) -> None:
    done = made(tmp_path, QIF, order={"frame": "workobject", "noise": 0.002})
    got = rows(tmp_path)
    assert got["deviation"] == pytest.approx([0.022 * 25.4, -0.001 * 25.4], abs=1e-6)
    assert got["x"] == pytest.approx([101.6, 25.4]) and done.report["mm_per_unit"] == 25.4
    size = np.array(got["deviation"])
    assert done.report["deviation_mm"]["rms"] == pytest.approx(np.sqrt(np.mean(size**2)), abs=1e-6)
    with pytest.raises(DeviceError, match=r"--units mm: but the file has a unit of 25\.4 mm"):
        made(tmp_path, QIF, order={"frame": "workobject", "noise": 0.002, "units": "mm"})


def test_probe_results_in_inches(tmp_path: Path) -> None:
    done = made(tmp_path, PROBE, order={"units": "inch", "frame": "workobject", "noise": 0.002})
    assert rows(tmp_path)["deviation"][1] == pytest.approx(2.54)
    assert tomllib.loads((tmp_path / "trace.toml").read_text())["probe"] == {"calibrated": False}
    out = next(f for f in done.report["findings"] if "out of their tolerance" in f["what"])
    assert (out["source_line"], out["count"]) == (14, 1)
    turned = PROBE.replace("G330 N1 A0.", "G330 N1 A30.")
    with pytest.raises(DeviceError, match=r"G330 30, .*give --frame free"):
        made(tmp_path, turned, order={"units": "inch", "frame": "workobject", "noise": 0.002})
    free = made(tmp_path, turned, order={"units": "inch", "frame": "free", "noise": 0.002})
    assert free.report["registered"] is False


def test_a_ball_bar(tmp_path: Path) -> None:
    order = {"noise": 0.001, "center": (1500.0, 0.0, 900.0), "radius": 150.0}
    made(tmp_path, BAR, order=order)
    told = tomllib.loads((tmp_path / "trace.toml").read_text())
    assert told["ballbar"] == {"center": [1500.0, 0.0, 900.0], "radius": 150.0, "calibrated": False}
    assert "registered" not in told and rows(tmp_path) == {"index": [3, 4], "radius": [150.0015, 150.003]}
    made(tmp_path, "index;dev_um\n3;1,5\n4;-2\n", order=order, columns=["index=index", "deviation=dev_um"])
    assert rows(tmp_path)["radius"] == pytest.approx([150.0015, 149.998])
    with pytest.raises(DeviceError, match=r"line 2: radius 1\.5 mm, nominal 150: .*--column deviation="):
        made(tmp_path, "radius_mm,index\n1.5,1\n", order=order)
    with pytest.raises(DeviceError, match=r"--frame: a ball-bar has no frame"):
        made(tmp_path, BAR, order={**order, "frame": "base"})


def test_the_program_bounds_the_index(tmp_path: Path) -> None:
    (tmp_path / "run.csv").write_text(PROGRAM)
    (tmp_path / "cell.toml").write_text('schema = "cell/1"\n')
    options = {"program": tmp_path / "run.csv", "cell": tmp_path / "cell.toml"}
    order = {"frame": "base", "noise": 0.01}
    done = made(tmp_path, TABLE, order=order, **options)
    assert [f["level"] for f in done.report["findings"]] == ["note"] and rows(tmp_path)["index"] == [0, 2.5]
    with pytest.raises(DeviceError, match=r"line 3: index 5\.5 is beyond 5, the last row of the program"):
        made(tmp_path, TABLE.replace("2.5", "5.5"), order=order, **options)
    with pytest.raises(DeviceError, match=r"device\.txt: line 1: no column kind, q1_deg"):
        made(tmp_path, TABLE, order=order, program=tmp_path / "device.txt")
    (tmp_path / "cell.toml").write_text('schema = "model/1"\n')
    with pytest.raises(DeviceError, match=r"schema = 'model/1', expected 'cell/1'"):
        made(tmp_path, TABLE, order=order, **options)


@pytest.mark.parametrize(
    ("text", "order", "why"),
    [
        (TABLE, {"frame": "workobject"}, "--frame workobject: positions stand in base"),
        (TABLE, {"noise": 20.0}, "--noise 20: expected mm above 0"),
        (TABLE, {"index": "1,2"}, "--index: the file has a column index"),
        (TABLE, {"radius": 150.0}, "belong to a ball-bar"),
        (TABLE, {"group": "X"}, "--group 'X': no such group"),
        (TABLE, {"point": "X"}, "--point 'X': no such point"),
        ("x_mm,y_mm,z_mm\n1,2,3\n4,5,6\n", {"index": "1,2,3"}, "--index 1,2,3: 3 rows for 2 readings"),
        ("x_m,y_m,z_m\n1,2,3000\n4,5,6\n", {"index": "1,2"}, r"line 2: z = 3e\+06 mm is beyond"),
        ("x_mm,y_mm,z_mm,time\n1,2,3,1\n4,5,6,0.5\n", {}, "line 3: time runs backwards"),
        ("x_mm,y_mm,z_mm,time,sd_mm\n1,2,3,1,0\n", {}, "line 2: sd = 0 mm, expected above 0"),
        ("x_mm,y_mm,z_mm,index,run\n1,2,3,1,0.5\n", {}, r"line 2: run 0\.5: expected a whole number"),
    ],
)
def test_refusals_at_the_door(tmp_path: Path, text: str, order: dict[str, Any], why: str) -> None:
    with pytest.raises(DeviceError, match=why):
        made(tmp_path, text, order={"frame": "base", "noise": 0.01, **order})
    assert sorted(p.name for p in tmp_path.iterdir()) == ["device.txt"]


@pytest.mark.parametrize(
    ("text", "expected"),
    [("4,8,12", [4, 8, 12]), ("0:6:2", [0, 2, 4, 6]), ("1:3,3.5,7", [1, 2, 3, 3.5, 7]), ("5", [5])],
)
def test_rows_of_the_command_line(text: str, expected: list[float]) -> None:
    assert index_rows(text).tolist() == expected


@pytest.mark.parametrize("text", ["", "a", "3,2", "5:1", "1:9:0", "-1", "1;2"])
def test_rows_that_are_none(text: str) -> None:
    with pytest.raises(DeviceError, match=f"--index {text}"):
        index_rows(text)


def test_the_command_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("cmm.csv").write_text("Nom X;Nom Y;Err\n1;2;0,5\n3;4;-0,25\n")
    Path("out").mkdir()
    words = ["trace", "cmm.csv", "-o", "out/t.toml", "--samples", "out/s.csv", "--json", "out/t.json"]
    words += ["--noise", "0.01"]
    words += ["--column", "x=Nom X", "--column", "y=Nom Y", "--column", "z=5", "--column", "deviation=Err"]
    words += ["--column", "i=1", "--column", "j=0", "--column", "k=0", "--units", "mm", "--frame", "workobject"]
    done = CliRunner().invoke(main, words)
    assert done.exit_code == 0 and done.stdout == "", done.output
    assert rows(Path("out"), "s.csv")["deviation"] == [0.5, -0.25]
    assert tomllib.loads(Path("out/t.toml").read_text())["samples"] == "s.csv"
    assert json.loads(Path("out/t.json").read_text())["kind"] == "surface"
    before = Path("out/t.toml").read_bytes(), Path("out/s.csv").read_bytes()
    assert CliRunner().invoke(main, words).exit_code == 0
    assert (Path("out/t.toml").read_bytes(), Path("out/s.csv").read_bytes()) == before
    strict = CliRunner().invoke(main, [*words, "--strict"])  # neither cell nor program stand beside it
    assert strict.exit_code == 1 and "--strict: 2 warnings refuse" in strict.stderr
    again = CliRunner().invoke(main, [*words, "--column", "x=Err"])
    assert again.exit_code == 1 and "x is given twice" in again.stderr
    assert "expected NAME=HEADING" in CliRunner().invoke(main, [*words[:4], "--column", "x"]).stderr


def test_another_samples_file_is_not_overwritten(tmp_path: Path) -> None:
    (tmp_path / "samples.csv").write_text("mine")
    with pytest.raises(CompensatorError, match=r"samples\.csv: stands there and belongs to"):
        made(tmp_path, TABLE, order={"frame": "base", "noise": 0.01})
    assert (tmp_path / "samples.csv").read_text() == "mine" and not (tmp_path / "trace.toml").exists()
    with pytest.raises(CompensatorError, match="a trace is two files"):
        trace_file(tmp_path / "device.txt", Path("-"), order=TraceOrder())
    (tmp_path / "samples.csv").write_text(TABLE)
    (tmp_path / "trace.toml").write_text("")
    with pytest.raises(CompensatorError, match=r"samples\.csv: is an input of this run"):
        made(tmp_path, TABLE, "samples.csv", order={"frame": "base", "noise": 0.01})
