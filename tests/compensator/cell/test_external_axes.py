"""Rails and tables that the cell declares: what matters is where the part is, seen from the robot's base."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w
from scipy.spatial.transform import Rotation

from compensator.errors import CompensatorError
from compensator.tasks.compensate import compensate_file, preview_file
from tests.compensator.small_job import CELL, WORN, files, merged
from tests.oracles.robot_programs import RAPID, TURN
from toolpaths.files import read_toolpath

WORK = np.array([1500.0, -150.0, 800.0])
WORK_TURN = Rotation.from_euler("z", 20, degrees=True)
BASE_WRENCH = {"process": {"kind": "constant", "frame": "base", "wrench": [-300.0, 200.0, 250.0, 5.0, -4.0, 3.0]}}
RAIL = {"carries": "robot", "direction": [0.6, 0.8, 0.0]}
TABLE = {"carries": "part", "direction": [0.0, 0.6, 0.8], "center": [1400.0, 100.0, 700.0]}


QP = ("q.csv", "p.csv")


def quaternion(turn: Rotation) -> str:
    return ",".join(f"{v:.15f}" for v in turn.as_quat(scalar_first=True))


def part(folder: Path, place: float | None, work: np.ndarray, turn: Rotation) -> Path:
    """The part of the other tests, with an external axis at ``place`` and the work object elsewhere."""
    text = RAPID if place is None else RAPID.replace("[9E9,9E9,", f"[9E9,{place},")
    text = text.replace(f"[[1500,-150,800],[{TURN}]]", f"[{[float(v) for v in work]},[{quaternion(turn)}]]")
    file = folder / "part.mod"
    file.write_text(text)
    return file


def cell(folder: Path, external: dict[str, Any], change: dict[str, Any] | None = None) -> Path:
    table = merged({**CELL, "workobject": None}, {**(change or {})})
    table = {k: v for k, v in table.items() if v is not None}
    folder.mkdir(exist_ok=True)
    file = files(folder).cell
    file.write_text(tomli_w.dumps({**table, "external": external} if external else table))
    return file


def poses(file: Path) -> np.ndarray:
    """All numbers of the robtargets of straight moves and arcs."""
    found = re.findall(r"\[\[(-?[\d.]+),(-?[\d.]+),(-?[\d.]+)\],\[(.*?)\]", file.read_text().split("PROC main")[1])
    return np.array([[float(v) for v in (*m[:3], *m[3].split(","))] for m in found])


def without_axis(folder: Path, change: dict[str, Any] | None = None) -> np.ndarray:
    (folder / "plain").mkdir()
    table = cell(folder / "plain", {}, change)
    compensate_file(part(folder / "plain", None, WORK, WORK_TURN), table, folder / "plain" / "c.mod")
    return poses(folder / "plain" / "c.mod")


def test_a_rail_moves_the_base(tmp_path: Path) -> None:
    expected = without_axis(tmp_path)
    place = 1234.5
    source = part(tmp_path, place, WORK + place * np.array(RAIL["direction"]), WORK_TURN)
    table = cell(tmp_path, {"eax_b": RAIL})
    done = compensate_file(source, table, tmp_path / "c.mod")
    np.testing.assert_allclose(poses(tmp_path / "c.mod"), expected, atol=2e-4)
    assert done.report["predicted_error_mm"]["after"]["max"] < 0.006
    assert (tmp_path / "c.mod").read_text().count("[9E9,1234.5,") >= 9
    assert not any("eax_b" in str(f) for f in done.findings)


def test_a_rail_under_a_worn_robot(tmp_path: Path) -> None:
    """Poses are put in at flank changes: what stands there has to be seen from the base, too."""
    place, out = 1234.5, {}
    for name, axis, at in (("plain", None, WORK), ("rail", place, WORK + place * np.array(RAIL["direction"]))):
        table = cell(tmp_path / name, {} if axis is None else {"eax_b": RAIL})
        (tmp_path / name / "model.toml").write_text(tomli_w.dumps(WORN))
        done = compensate_file(part(tmp_path / name, axis, at, WORK_TURN), table, tmp_path / name / "c.mod")
        assert done.report["inserted_poses"] > 0 and done.report["predicted_error_mm"]["after"]["max"] < 0.02
        out[name] = poses(tmp_path / name / "c.mod")
    np.testing.assert_allclose(out["rail"], out["plain"], atol=2e-4)


def test_joint_angles_are_seen_from_the_base(tmp_path: Path) -> None:
    """A start in joint angles, and an arc from there: the same with the rail at 0 and elsewhere."""
    (tmp_path / "plain").mkdir()
    table = cell(tmp_path / "plain", {})
    plain = part(tmp_path / "plain", None, WORK, WORK_TURN)
    preview_file(plain, table, csv=tmp_path / "p.csv")
    header, first = (line.split(",") for line in (tmp_path / "p.csv").read_text().split("\n")[:2])
    row = dict(zip(header, first, strict=True))
    angles = ",".join(row[f"q{k}_deg"] for k in range(1, 7))
    place = 1234.5
    far = part(tmp_path, place, WORK + place * np.array(RAIL["direction"]), WORK_TURN)
    for file, axis in ((plain, "9E9"), (far, str(place))):
        text = file.read_text().replace("MoveJ safe", f"MoveAbsJ [[{angles}],[9E9,{axis},9E9,9E9,9E9,9E9]]", 1)
        via = f"[[-30,0,40],[0,1,0,0],[0,0,0,0],[9E9,{axis},9E9,9E9,9E9,9E9]]"
        file.write_text(re.sub(r"MoveL (.*plunge)", lambda m, v=via: f"MoveC {v},{m[1]}", text, count=1))
    compensate_file(plain, table, tmp_path / "plain" / "c.mod")
    done = compensate_file(far, cell(tmp_path, {"eax_b": RAIL}), tmp_path / "c.mod")
    np.testing.assert_allclose(poses(tmp_path / "c.mod"), poses(tmp_path / "plain" / "c.mod"), atol=3e-4)
    assert done.report["predicted_error_mm"]["after"]["max"] < 0.02


def test_a_table_turns_the_part(tmp_path: Path) -> None:
    expected = without_axis(tmp_path, BASE_WRENCH)
    place = 70.0
    turn = Rotation.from_rotvec(np.radians(place) * np.array(TABLE["direction"]))
    center = np.array(TABLE["center"])
    source = part(tmp_path, place, turn.inv().apply(WORK - center) + center, turn.inv() * WORK_TURN)
    table = cell(tmp_path, {"eax_b": TABLE}, BASE_WRENCH)
    compensate_file(source, table, tmp_path / "c.mod")
    np.testing.assert_allclose(poses(tmp_path / "c.mod"), expected, atol=2e-4)
    preview_file(source, table, csv=tmp_path / "p.csv")
    preview_file(tmp_path / "plain" / "part.mod", tmp_path / "plain" / "cell.toml", csv=tmp_path / "q.csv")
    shown, plain = (np.genfromtxt(tmp_path / n, delimiter=",", skip_header=1, usecols=range(2, 15)) for n in QP)
    np.testing.assert_allclose(shown, plain, atol=1e-5)


def test_places_may_differ_between_cuts(tmp_path: Path) -> None:
    """The second routine cuts 500 mm along the rail, at a part that stands so much further."""
    expected = without_axis(tmp_path)
    source = part(tmp_path, 0, WORK, WORK_TURN)
    step = WORK_TURN.inv().apply(500.0 * np.array(RAIL["direction"]))
    head, tail = source.read_text().split("PROC cut2()")
    frame = quaternion(WORK_TURN)
    place = [float(v) for v in step]
    moved = f'  PERS wobjdata two:=[FALSE,TRUE,"",[[1500,-150,800],[{frame}]],[{place},[1,0,0,0]]];\n'
    head = head.replace("  CONST robtarget p10", f"{moved}  CONST robtarget p10", 1)
    corner = re.search(r"p10:=(.*?);", head)
    assert corner
    far = corner[1].replace("[9E9,0,", "[9E9,500,")
    head = head.replace("    cut2;", f"    MoveJ {far},v100,fine,spindle\\WObj:=two;\n    cut2;")
    tail = tail.replace("[9E9,0,", "[9E9,500,").replace("MoveL p10", f"MoveL {far}").replace("WObj:=table", "WObj:=two")
    source.write_text(head + "PROC cut2()" + tail)
    done = compensate_file(source, cell(tmp_path, {}), tmp_path / "c.mod")
    (note,) = (n for n in done.report["notes"] if "eax_b" in n)
    assert "eax_b moves between 0 and 500" in note and "[external.eax_b]" in note
    compensate_file(source, cell(tmp_path, {"eax_b": RAIL}), tmp_path / "c.mod")
    shown = poses(tmp_path / "c.mod")
    np.testing.assert_allclose(shown[-2], expected[-1], atol=2e-4)
    np.testing.assert_allclose(shown[-1, :3], [100, 60, -2], atol=2.0)


def along(folder: Path, ends: np.ndarray, axis: np.ndarray | None, home: np.ndarray) -> Path:
    """A straight run over ``ends`` (K, 3) mm in the work object, with eax_b at ``axis`` (K,), from a rapid before."""
    folder.mkdir(exist_ok=True)
    shown = ["9E9"] * len(ends) if axis is None else [f"{v:.10f}" for v in axis]
    poses = [
        f"[[{','.join(f'{v:.10f}' for v in p)}],[0,1,0,0],[0,0,0,0],[9E9,{e},9E9,9E9,9E9,9E9]]"
        for p, e in zip([home, *ends], [shown[0], *shown], strict=True)
    ]
    moves = [f"    MoveJ {poses[0]},v1000,fine,t\\WObj:=w;"] + [f"    MoveL {p},v20,z1,t\\WObj:=w;" for p in poses[1:]]
    tool = "  PERS tooldata t:=[TRUE,[[30,-20,240],[1,0,0,0]],[30,[10,0,110],[1,0,0,0],0,0,0]];"
    work = f"  PERS wobjdata w:=[FALSE,TRUE,\"\",[[1500,-150,800],[{TURN}]],[[0,0,0],[1,0,0,0]]];"
    text = "\n".join(["MODULE run", tool, work, "  PROC main()", *moves, "  ENDPROC", "ENDMODULE", ""])
    (folder / "run.mod").write_text(text)
    return folder / "run.mod"


def commands(file: Path, table: Path, out: Path) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Positions of the straight moves as written, and the table of the nominal poses: mm."""
    compensate_file(file, table, out)
    preview_file(file, table, csv=out.with_suffix(".csv"))
    rows = np.genfromtxt(out.with_suffix(".csv"), delimiter=",", names=True, dtype=None, encoding="ascii")
    columns = {k: np.stack([rows[f"{v}"] for v in names], axis=1) for k, names in COLUMNS.items()}
    written = read_toolpath(out)
    whole = np.abs(written.row - np.rint(written.row)) < 1e-9
    return written.position[whole & (written.kind == 1)] * 1e3, columns


COLUMNS = {
    "q": [f"q{k}_deg" for k in range(1, 7)], "force": ["fx_n", "fy_n", "fz_n"],
}  # fmt: skip
PATH_WRENCH = {"process": {"kind": "constant", "frame": "path", "wrench": [-120.0, 80.0, -60.0, 0.0, 0.0, 0.0]}}


def test_a_rail_that_moves_in_every_cut(tmp_path: Path) -> None:
    """The arm sees each pose less what the rail is at, as if the part went the other way; the feed is that on it."""
    ends = np.array([[k * 20.0, 5.0 * (k % 2), -2.0] for k in range(6)])
    rail = np.linspace(-40.0, 260.0, 6)
    step = WORK_TURN.inv().apply(np.outer(rail, RAIL["direction"]))
    home = np.array([0.0, 0.0, 40.0])
    change = {"tool": None, **BASE_WRENCH}
    file = along(tmp_path / "rail", ends, rail, home)
    got, on_rail = commands(file, cell(tmp_path / "rail", {"eax_b": RAIL}, change), tmp_path / "rail" / "c.mod")
    plain = along(tmp_path / "plain", ends - step, None, home - step[0])
    expected, alone = commands(plain, cell(tmp_path / "plain", {}, change), tmp_path / "plain" / "c.mod")
    np.testing.assert_allclose(got[[0, -1]], (expected + 0.0)[[0, -1]] + step[[0, -1]], atol=3e-4)
    np.testing.assert_allclose(on_rail["q"][-1], alone["q"][-1], atol=1e-6)
    written = read_toolpath(tmp_path / "rail" / "c.mod")
    np.testing.assert_allclose(written.setting.external["eax_b"][[0, -1]], rail[[0, -1]], atol=1e-9)
    assert (np.diff(written.setting.external["eax_b"]) >= -1e-9).all()  # poses put in have their place on the rail
    by_feed = cell(tmp_path / "rail", {"eax_b": RAIL}, {"tool": None, **PATH_WRENCH})
    _, turned = commands(file, by_feed, tmp_path / "d.mod")
    feed = WORK_TURN.apply((ends[-1] - ends[-2]) / np.linalg.norm(ends[-1] - ends[-2]))  # not that of the arm
    down = np.array([0.0, 0.0, -1.0])
    np.testing.assert_allclose(turned["force"][-1], -120 * feed + 80 * np.cross(down, feed) - 60 * down, atol=1e-3)


def test_a_table_that_turns_under_a_tool_at_rest(tmp_path: Path) -> None:
    """The arm stands still, the part turns: the correction is the same all along, the feed is against the turn."""
    center, axis = np.array([1400.0, 100.0, 798.0]), np.array([0.0, 0.0, 1.0])
    table = {"carries": "part", "direction": axis.tolist(), "center": center.tolist()}
    tip = np.array([1500.0, -100.0, 798.0])
    angle = np.linspace(0.0, 40.0, 81)
    turns = Rotation.from_rotvec(np.radians(angle)[:, None] * axis)
    ends = WORK_TURN.inv().apply(turns.inv().apply(tip - center) + center - WORK)  # of one point in the base
    file = along(tmp_path / "t", ends, angle, ends[0])
    text = file.read_text().split("\n")
    turned = WORK_TURN.inv() * turns.inv() * WORK_TURN * Rotation.from_quat([0, 1, 0, 0], scalar_first=True)
    q = iter([turned[0], *turned])
    lines = [x.replace("[0,1,0,0]", f"[{quaternion(next(q))}]") if "    Move" in x else x for x in text]
    file.write_text("\n".join(lines))
    by_feed = cell(tmp_path / "t", {"eax_b": table}, {"tool": None, **PATH_WRENCH})
    _, seen = commands(file, by_feed, tmp_path / "c.mod")
    cut = np.abs(seen["force"]).max(axis=1) > 0
    np.testing.assert_allclose(np.ptp(seen["q"][cut], axis=0), 0.0, atol=2e-3)  # what lies between two poses is a chord
    feed = np.cross(-axis, tip - center)
    feed /= np.linalg.norm(feed)
    wanted = -120 * feed + 80 * np.cross([0, 0, -1.0], feed) + [0, 0, 60.0]
    np.testing.assert_allclose(seen["force"][cut][:-1], np.tile(wanted, (cut.sum() - 1, 1)), atol=0.6)
    written = read_toolpath(tmp_path / "c.mod")
    whole = np.flatnonzero((np.abs(written.row - np.rint(written.row)) < 1e-9) & (written.kind == 1))
    stands = written.setting.external["eax_b"][written.row[whole].astype(int)]
    on_table = WORK_TURN.apply(written.position[whole] * 1e3) + WORK - center
    back = Rotation.from_rotvec(np.radians(stands)[:, None] * axis).apply(on_table) + center
    assert np.ptp(back, axis=0).max() < 0.02 and np.linalg.norm(back[0] - tip) > 0.05


def test_a_wrench_in_work_object_axes_turns_with_the_table(tmp_path: Path) -> None:
    place = 70.0
    turn = Rotation.from_rotvec(np.radians(place) * np.array(TABLE["direction"]))
    center = np.array(TABLE["center"])
    source = part(tmp_path, place, turn.inv().apply(WORK - center) + center, turn.inv() * WORK_TURN)
    preview_file(source, cell(tmp_path, {"eax_b": TABLE}), csv=tmp_path / "p.csv")
    (tmp_path / "plain").mkdir()
    preview_file(part(tmp_path / "plain", None, WORK, WORK_TURN), cell(tmp_path / "plain", {}), csv=tmp_path / "q.csv")
    shown, plain = (np.genfromtxt(tmp_path / n, delimiter=",", skip_header=1, usecols=range(23, 29)) for n in QP)
    np.testing.assert_allclose(shown, plain, atol=1e-9)


def test_another_language_would_lose_them(tmp_path: Path) -> None:
    source = part(tmp_path, 300, WORK, WORK_TURN)
    for external in ({}, {"eax_b": RAIL}):
        with pytest.raises(CompensatorError, match=r"part.mod:13.*eax_b stands at 300: written without external axes"):
            compensate_file(source, cell(tmp_path, external), tmp_path / "c.src")
    for carries, name in ({"carries": "nothing"}, "c.src"), (RAIL, "c.csv"):
        done = compensate_file(source, cell(tmp_path, {"eax_b": carries}), tmp_path / name)
        assert any("without external axes" in str(f) for f in done.findings)


@pytest.mark.parametrize(("axis", "words"), [
    ({"carries": "robot"}, "length 1"),
    ({"carries": "robot", "direction": [2.0, 0.0, 0.0]}, "length 1"),
    ({"carries": "part", "direction": [0.0, 0.0, 1.0]}, "center is missing"),
    ({"carries": "part", "direction": [0.0, 0.0, 1.0], "center": [1.4, 0.1, 0.7]}, "mm"),
    ({**RAIL, "center": [0.0, 0.0, 0.0]}, "a rail has none"),
    ({"carries": "table"}, "carries"),
])  # fmt: skip
def test_declarations_are_checked(tmp_path: Path, axis: dict[str, Any], words: str) -> None:
    source = part(tmp_path, 300, WORK, WORK_TURN)
    with pytest.raises(CompensatorError, match=words):
        compensate_file(source, cell(tmp_path, {"eax_b": axis}), tmp_path / "c.mod")
    with pytest.raises(CompensatorError, match="external"):
        compensate_file(source, cell(tmp_path, {"rail": RAIL}), tmp_path / "c.mod")


def test_the_axes_of_the_page(tmp_path: Path) -> None:
    """The declaration in docs/filter.md, with a rail and a table at 0: as if they were not there."""
    page = (Path(__file__).parents[3] / "docs" / "filter.md").read_text()
    block = page[page.index("    [external.E1]") :].split("\n\nThen")[0]
    expected = without_axis(tmp_path, BASE_WRENCH)
    table = cell(tmp_path, {}, BASE_WRENCH)
    table.write_text(table.read_text() + "\n" + re.sub("^    ", "", block, flags=re.M))
    compensate_file(part(tmp_path, None, WORK, WORK_TURN), table, tmp_path / "c.mod")
    np.testing.assert_allclose(poses(tmp_path / "c.mod"), expected, atol=1e-9)


def test_two_work_objects_that_cut_equally_often(tmp_path: Path) -> None:
    """Lines put in make the second one that of most cuts: the written program is still checked in the first."""
    source = part(tmp_path, None, WORK, WORK_TURN)
    head, frame = source.read_text().split("PROC cut2()")[0], quaternion(WORK_TURN)
    two = f'  PERS wobjdata two:=[FALSE,TRUE,"",[[1500,-150,800],[{frame}]],[[50,0,0],[1,0,0,0]]];\n'
    corner = "[[{},{},{}],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    near, wide = [(0, 0, -2), (20, 0, -2), (20, 20, -2)], [(0, 0, -2), (300, 0, -2), (300, 0, 50)]
    lines = "".join(f"MoveL {corner.format(*p)},v20,z1,spindle\\WObj:=table;\n" for p in near)
    far = "".join(f"MoveL {corner.format(*p)},v20,z1,spindle\\WObj:=two;\n" for p in wide)
    head = head.split("  PROC main()")[0].replace("  CONST robtarget p10", f"{two}  CONST robtarget p10", 1)
    rapids = [f"MoveJ {corner.format(0, 0, 50)},v500,fine,spindle\\WObj:={w};\n" for w in ("table", "two")]
    source.write_text(f"{head}  PROC main()\n{rapids[0]}{lines}{rapids[1]}{far}  ENDPROC\nENDMODULE\n")
    done = compensate_file(source, cell(tmp_path, {}), tmp_path / "c.mod")
    assert done.report["predicted_error_mm"]["after"]["max"] < 0.006
    after = read_toolpath(tmp_path / "c.mod").setting.workobject.matrix
    assert np.abs(after - read_toolpath(source).setting.workobject.matrix).max() > 0.04
