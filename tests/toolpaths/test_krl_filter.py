"""KRL in place: only pose numbers of cutting moves change, in the .src and its .dat."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.oracles.robot_programs import KRL, KRL_DAT
from tests.toolpaths.test_rapid_filter import SHIFT, TURN, bent, changed, commanded, whole, without_marker
from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath
from toolpaths.languages.krl.filter import rewrite
from toolpaths.rewriting.filter import Rewritten
from toolpaths.toolpath import Toolpath
from toolpaths.writing.marker import MARKER, refuse_compensated


def written(folder: Path, end: str = "\r\n") -> Path:
    file = folder / "PART.src"
    file.write_bytes(KRL.replace("\n", end).encode())
    file.with_suffix(".dat").write_bytes(KRL_DAT.replace("\n", end).encode())
    return file


def filtered(file: Path, shift: np.ndarray = SHIFT, turn: Rotation = TURN) -> tuple[Toolpath, Rewritten]:
    path = read_toolpath(file)
    return path, rewrite(file.read_bytes(), commanded(path, shift, turn), path.row, file)


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_nothing_changes_but_the_marker(tmp_path: Path, end: str) -> None:
    file = written(tmp_path, end)
    _, out = filtered(file, 0 * SHIFT, Rotation.identity())
    lines = out.text.split(end.encode())
    assert lines.pop(3) == f"; {MARKER}".encode()
    assert end.encode().join(lines) == file.read_bytes() and out.changes == ()
    assert out.beside == ((".dat", file.with_suffix(".dat").read_bytes()),)
    with pytest.raises(ReadError, match="compensated already"):
        refuse_compensated(out.text, "x.src")


def test_only_poses_of_cuts_change(tmp_path: Path) -> None:
    file = written(tmp_path)
    path, out = filtered(file)
    gone, come = changed(file.read_bytes(), out.text)
    # XP1 serves as a frame and XP2 as a rapid: both are split; 2 literals, 2 relative poses
    assert len(gone) == 7 and len(come) == 8
    data = dict(out.beside)[".dat"]
    gone, come = changed(file.with_suffix(".dat").read_bytes(), data)
    assert gone == [] and [line.split("=")[0] for line in come] == ["DECL E6POS XP1_C1", "DECL E6POS XP2_C1"]
    told = " ".join(f"{c.place}: {c.what}" for c in out.changes)
    assert "XP1_C1 was declared beside it" in told and "line 21: {Z 20} became numbers" in told
    file.write_bytes(out.text)
    file.with_suffix(".dat").write_bytes(data)
    again = read_toolpath(file)
    a, b, cut = whole(path), whole(again), path.kind[whole(path)] == 1
    np.testing.assert_array_equal(again.position[b][~cut], path.position[a][~cut])
    np.testing.assert_allclose(again.position[b][cut], path.position[a][cut] + SHIFT, atol=6e-8)
    turned = Rotation.from_quat(path.quaternion[a][cut], scalar_first=True)
    back = Rotation.from_quat(again.quaternion[b][cut], scalar_first=True)
    assert ((TURN * turned).inv() * back).magnitude().max() < 3e-8
    np.testing.assert_array_equal(again.setting.configuration[:2], path.setting.configuration[:2])


@pytest.mark.parametrize("angles", [(129.7, -46.5, 162.4), (180, 0, -150), (-60, 90, 0), (10, 95, -170), (0, -90, 45)])
def test_angles_stay_near_the_old_ones(tmp_path: Path, angles: tuple[float, float, float]) -> None:
    file = tmp_path / "P.src"
    a, b, c = angles
    lines = "".join(f"LIN {{X {x},Y 0,Z 0,A {a},B {b},C {c}}} C_DIS\n" for x in range(3))
    file.write_text(f"DEF P()\n{lines}END\n")
    path, out = filtered(file)
    file.write_bytes(out.text)
    again = read_toolpath(file)
    turned = TURN * Rotation.from_quat(path.quaternion, scalar_first=True)
    assert (turned.inv() * Rotation.from_quat(again.quaternion, scalar_first=True)).magnitude().max() < 3e-8
    if abs(abs(b) - 90) > 1:  # in gimbal lock A and C alone say nothing
        first = out.text.decode().split("\n")[2].replace("}", ",").split(",")
        new = [float(word.split()[-1]) for word in first[3:6]]
        assert np.abs(np.array(new) - angles).max() < 5


def test_poses_put_in_and_arcs_that_are_none(tmp_path: Path) -> None:
    file = written(tmp_path, "\n")
    path = read_toolpath(file)
    arc = np.ceil(path.row - 1e-9) == 3
    shift = np.where(arc[:, None], 1e-4 * np.sin(40 * path.row)[:, None], 0.0) * [1.0, 1.0, 1.0]
    out = rewrite(file.read_bytes(), commanded(path, shift, Rotation.identity()), path.row, file)
    assert b"CIRC" not in out.text and any("short lines" in c.what for c in out.changes)
    assert out.text.count(b"\nLIN {") == 1 + arc.sum()
    file.write_bytes(out.text)
    again = read_toolpath(file)
    cut = path.kind == 1
    np.testing.assert_allclose(again.position[cut], (path.position + shift)[cut], atol=6e-8)


REFUSED = {"line3_cleaned.src": "POS_ACT", "Hollow_Box_cleaned.src": "POS_ACT", "KUKA_KRC2_test_post.src": "END"}


def test_real_programs_come_back_word_by_word(shared: Path) -> None:
    files = sorted((shared / "data/cam").rglob("*.src"))
    assert {f.name for f in files} > set(REFUSED) and len(files) >= 7
    for file in files:
        if file.name in REFUSED:
            with pytest.raises(ReadError, match=REFUSED[file.name]):
                read_toolpath(file)
            continue
        _, out = filtered(file, 0 * SHIFT, Rotation.identity())
        assert without_marker(out.text) == file.read_bytes()
        path, moved = filtered(file)
        gone, come = changed(file.read_bytes(), moved.text)
        assert len(gone) == len(come) - 1 == int((path.kind == 1).sum())


def test_calls_of_what_is_not_in_the_file_are_told(shared: Path) -> None:
    _, out = filtered(shared / "data/cam/robodk/Program.src")
    told = [str(c) for c in out.changes]
    assert len(told) == 1 and "line 64: Subprog is not in this file" in told[0]


@pytest.mark.parametrize(
    ("said", "nominal", "command", "written"),
    [
        ("S 2,T 35", [-1, -0.01, 9, 9, 9, -0.01], [-1, 0.01, 9, 9, 9, 0.01], "S 2,T 1"),
        ("S 6,T 18,E1 4", [9, -9, 9, 0.01, -9, 9], [9, -9, 9, -0.01, -9, 9], "S 6,T 26,E1 4"),
        ("S 2,T 0", [9, -9, 9, -0.01, 9, -0.01], [9, 9, 9, 0.01, 9, 0.01], "S 2,T 0"),  # not of this arm
        ("S 2", [9, -0.01, 9, 9, 9, 9], [9, 0.01, 9, 9, 9, 9], "S 2"),
    ],
)
def test_turn_bits_follow_an_axis_through_zero(
    tmp_path: Path, said: str, nominal: list[float], command: list[float], written: str
) -> None:
    file = tmp_path / "P.src"
    pose = f"{{X 1,Y 2,Z 3,A 0,B 0,C 180,{said}}}"
    file.write_text(f"DEF P()\nPTP {pose}\nLIN {pose} C_DIS\nEND\n")
    path = read_toolpath(file)
    out = rewrite(file.read_bytes(), bent(path, nominal, command), path.row, file).text.decode()
    assert f"PTP {pose}" in out
    assert f"LIN {{X 1.1200,Y 1.6600,Z 3.5600,A 0,B 0,C 180,{written}}} C_DIS" in out
