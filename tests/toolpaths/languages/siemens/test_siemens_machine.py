"""Rotary words of SINUMERIK programs on a declared machine: as G-code has them, and in tilted planes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath
from toolpaths.machine import Machine, RotaryAxis
from toolpaths.toolpath import Toolpath

A = RotaryAxis("A", (1.0, 0.0, 0.0), (0.05, -0.02, -0.11))
B = RotaryAxis("B", (0.0, 1.0, 0.0))
C = RotaryAxis("C", (0.0, 0.0, -1.0), (0.03, 0.04, 0.0))
MACHINES = {
    "table-table": Machine("table-table", (A, C)),
    "head-table": Machine("head-table", (B, C), 0.23),
    "head-head": Machine("head-head", (RotaryAxis("C", (0.0, 0.0, 1.0)), B), 0.31),
}


def read(tmp_path: Path, text: str, machine: Machine | None, suffix: str = "mpf") -> Toolpath:
    file = tmp_path / f"part.{suffix}"
    file.write_text(text)
    return read_toolpath(file, chord=1e-5, machine=machine)


@pytest.mark.parametrize("tip", [True, False])
@pytest.mark.parametrize("name", MACHINES)
def test_rotary_words_as_in_g_code(tmp_path: Path, name: str, tip: bool) -> None:
    """Under TRAORI as under G43.4, without it as without: poses, poses in between, feeds."""
    machine, g = MACHINES[name], np.random.default_rng(7)
    letters = machine.letters
    moves = "".join(
        f"G1 X{x:.3f} Y{y:.3f} Z{z:.3f} {letters[0]}{p:.3f} {letters[1]}{q:.3f}\n"
        for x, y, z, p, q in g.uniform(-60, 60, (8, 5))
    )
    start = f"G0 X0 Y0 Z50 {letters[0]}0 {letters[1]}0\n"
    theirs = read(
        tmp_path, f"G21 G90\n{'G43.4' if tip else ''}\n{start}F600\n{moves}G1 {letters[1]}9\nM30\n", machine, "nc"
    )
    ours = read(
        tmp_path, f"G710 G90\n{'TRAORI' if tip else ''}\n{start}F600\n{moves}G1 {letters[1]}=DC(9)\nM30\n", machine
    )
    assert len(ours) > 100
    for column in ("position", "axis", "feed", "kind", "row"):
        np.testing.assert_array_equal(getattr(ours, column), getattr(theirs, column))


def test_ways_round_and_relative_angles(tmp_path: Path) -> None:
    """DC: the short way; ACP, ACN: in one direction; IC, G91: from where the axis is."""
    text = "G710 G90\nTRAORI\nG0 X0 Y0 Z0 A0 C350\nF600\n{}\nM30\n"
    for word, turn in (("C10", -340), ("C=DC(10)", 20), ("C=ACP(10)", 20), ("C=ACN(10)", -340), ("C=IC(10)", 10)):
        path = read(tmp_path, text.format(f"G1 X50 A30 {word}"), MACHINES["table-table"])
        assert len(path) > abs(turn) / 2
        expected = Rotation.from_rotvec([0, 0, -np.radians(350 + turn)]) * Rotation.from_rotvec([np.radians(30), 0, 0])
        np.testing.assert_allclose(path.axis[-1], expected.apply([0, 0, 1]), rtol=0, atol=1e-9)
    a, b = (read(tmp_path, text.format(w), MACHINES["table-table"]) for w in ("G91 G1 X50 A30 C10", "G1 X50 A30 C360"))
    np.testing.assert_allclose(a.position, b.position, atol=1e-12)


SWIVEL = (
    'G710 G90\nF600\nG0 X0 Y0 Z90 {zero}\nCYCLE800(1,"",0,57,0,0,0,{a},{b},0,0,0,0,0)\n{turn}\n'
    "G0 X5 Y6 Z7\nG1 X9\nM30\n"
)


def test_words_that_turn_the_axes_into_a_plane(tmp_path: Path) -> None:
    text = SWIVEL.format(zero="A0 C0", a=30, b=0, turn="G0 A30 C0")
    path = read(tmp_path, text, MACHINES["table-table"])
    expected = Rotation.from_euler("X", 30, degrees=True).apply([[5, 6, 7], [9, 6, 7]])
    np.testing.assert_allclose(path.position[-2:] * 1e3, expected, rtol=0, atol=1e-9)
    np.testing.assert_allclose(path.axis[-1], [0, -0.5, np.sqrt(0.75)], atol=1e-12)


def test_angles_that_do_not_stand_in_the_plane(tmp_path: Path) -> None:
    with pytest.raises(ReadError, match="on the machine of the cell the tool points along"):
        read(tmp_path, SWIVEL.format(zero="A0 C0", a=30, b=0, turn="G0 A31 C0"), MACHINES["table-table"])
    with pytest.raises(ReadError, match="rotary words beside a move in a tilted plane"):
        read(tmp_path, SWIVEL.format(zero="A0 C0", a=30, b=0, turn="G0 X0 Y0 Z0 A30"), MACHINES["table-table"])


def test_poses_of_a_plane_between_poses_of_the_axes(tmp_path: Path) -> None:
    """Where CYCLE800 turned the axes to is not known: nothing that needs it is read until words name them."""
    text = SWIVEL.format(zero="A0 C0", a=30, b=0, turn="").replace("0,0,0,0,0)", "0,0,0,0,-1)")
    path = read(tmp_path, text.replace("M30", "CYCLE800()\nG0 X1 Y2 Z80\nG1 X2\nM30"), MACHINES["table-table"])
    assert np.isfinite(path.position).all()
    np.testing.assert_array_equal(path.axis[-1], [0, 0, 1])
    np.testing.assert_allclose(path.position[-1] * 1e3, [2, 2, 80], atol=1e-12)


def test_without_a_machine(tmp_path: Path) -> None:
    """Zeros, and rapids of the axes alone before a plane; all else needs the machine."""
    path = read(tmp_path, "G710 G90\nG0 A0 C0\nG0 X1 Y2 Z3\nF9\nG1 X2 C0\nM30\n", None)
    assert len(path) == 2
    text = 'G710 G90\nG0 A{} C0\n{}G0 X1 Y2 Z3\nM30\n'
    path = read(tmp_path, text.format(30, 'CYCLE800(1,"",0,57,0,0,0,30,0,0,0,0,0,0)\n'), None)
    np.testing.assert_allclose(path.axis[-1], [0, -0.5, np.sqrt(0.75)], atol=1e-12)
    with pytest.raises(ReadError, match="the rotary axes stand at A30 C0: where its tip is depends on the machine"):
        read(tmp_path, text.format(30, ""), None)
    with pytest.raises(ReadError, match=r"A30: a rotary axis: the machine's kinematics is not known"):
        read(tmp_path, "G710\nTRAORI\nG0 X0 Y0 Z0 A30\nM30\n", None)
    with pytest.raises(ReadError, match="rotary axes turn at a feed"):
        read(tmp_path, "G710\nG0 X0 Y0 Z0\nF9\nG1 A30\nM30\n", None)


def test_a_program_beside_that_turns_axes(tmp_path: Path) -> None:
    (tmp_path / "OP1.SPF").write_text("G0 A0 C0\nTRAORI\nG0 X0 Y0 Z0\nG1 X5 A30 F600\nTRAFOOF\nM17\n")
    path = read(tmp_path, "G710 G90\nG0 X0 Y0 Z50\nOP1\nM30\n", MACHINES["table-table"])
    np.testing.assert_allclose(path.axis[-1], [0, -0.5, np.sqrt(0.75)], atol=1e-12)
    np.testing.assert_allclose(path.position[0] * 1e3, [0, 0, 50])
