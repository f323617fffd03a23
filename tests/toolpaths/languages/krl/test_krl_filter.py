"""KRL in place: only pose numbers of cutting moves change, in the .src and its .dat."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.oracles.commanded import SHIFT, TURN, bent, changed_lines, commanded
from tests.oracles.robot_programs import KRL, KRL_DAT
from toolpaths.files import read_toolpath
from toolpaths.languages.krl.filter import rewrite
from toolpaths.rewriting.filter import Rewritten
from toolpaths.toolpath import Toolpath


def written(folder: Path, end: str = "\r\n") -> Path:
    file = folder / "PART.src"
    file.write_bytes(KRL.replace("\n", end).encode())
    file.with_suffix(".dat").write_bytes(KRL_DAT.replace("\n", end).encode())
    return file


def filtered(file: Path, shift: np.ndarray = SHIFT, turn: Rotation = TURN) -> tuple[Toolpath, Rewritten]:
    path = read_toolpath(file)
    return path, rewrite(file.read_bytes(), *commanded(path, shift=shift, turn=turn.as_rotvec()), file)


def test_what_is_declared_in_the_dat_is_split_there(tmp_path: Path) -> None:
    """XP1 serves as a frame, XP2 as a rapid, too: what the cuts need is declared beside them."""
    file = written(tmp_path)
    _, out = filtered(file)
    gone, come = changed_lines(file.with_suffix(".dat").read_bytes(), dict(out.beside)[".dat"])
    assert gone == [] and [line.split("=")[0] for line in come] == ["DECL E6POS XP1_C1", "DECL E6POS XP2_C1"]


def test_an_arc_that_becomes_lines_has_a_line_a_pose(tmp_path: Path) -> None:
    file = written(tmp_path, "\n")
    path = read_toolpath(file)
    arc = np.ceil(path.row - 1e-9) == 3
    shift = np.where(arc[:, None], 1e-4 * np.sin(40 * path.row)[:, None], 0.0) * [1.0, 1.0, 1.0]
    out = rewrite(file.read_bytes(), *commanded(path, shift=shift), file)
    assert out.text.count(b"\nLIN {") == 1 + arc.sum()


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
