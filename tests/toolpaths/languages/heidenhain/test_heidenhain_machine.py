"""Rotary words of Klartext on a declared machine: as G-code has them, and in tilted planes."""

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


def read(tmp_path: Path, text: str, machine: Machine | None, suffix: str = "h") -> Toolpath:
    file = tmp_path / f"part.{suffix}"
    file.write_text(text if suffix == "nc" else f"BEGIN PGM A MM\n{text}\nEND PGM A MM\n")
    return read_toolpath(file, chord=1e-5, machine=machine)


@pytest.mark.parametrize("tip", [True, False])
@pytest.mark.parametrize("name", MACHINES)
def test_rotary_words_as_in_g_code(tmp_path: Path, name: str, tip: bool) -> None:
    """Under M128 as under G43.4, without it as without: poses, poses in between, feeds."""
    machine, g = MACHINES[name], np.random.default_rng(7)
    letters = machine.letters
    moves = [
        f"X{x:+.3f} Y{y:+.3f} Z{z:+.3f} {letters[0]}{p:+.3f} {letters[1]}{q:+.3f}"
        for x, y, z, p, q in g.uniform(-60, 60, (8, 5))
    ]
    start = f"X0 Y0 Z50 {letters[0]}0 {letters[1]}0"
    gcode = "".join(f"G1 {m}\n" for m in moves)
    theirs = read(
        tmp_path,
        f"G21 G90\n{'G43.4' if tip else ''}\nG0 {start}\nF600\n{gcode}G0 {letters[1]}5\nG1 {letters[1]}9 F300\nM30\n",
        machine,
        "nc",
    )
    klartext = "\n".join(f"L {m}" for m in moves)
    ours = read(
        tmp_path,
        f"{'M128' if tip else ''}\nL {start} FMAX\nL F600\n{klartext}\nL {letters[1]}5 FMAX\nL {letters[1]}9 F300",
        machine,
    )
    assert len(ours) > 100
    for column in ("position", "axis", "kind", "row"):
        np.testing.assert_array_equal(getattr(ours, column), getattr(theirs, column))
    np.testing.assert_allclose(ours.feed, theirs.feed, rtol=1e-12)


def test_the_short_way_round(tmp_path: Path) -> None:
    """M126; without it the axis turns as far as its number says."""
    text = "M128\nL X+0 Y+0 Z+0 A+0 C+350 FMAX\n{}L X+50 A+30 C+10 F600"
    far, near = (len(read(tmp_path, text.format(m), MACHINES["table-table"])) for m in ("", "M126\n"))
    assert far > 165 and near < 60
    relative = read(tmp_path, text.format("").replace("C+10", "IC+20"), MACHINES["table-table"])
    assert len(relative) == near


SWIVEL = "L F600\nL X+0 Y+0 Z+90 A+0 C+0 FMAX\nPLANE SPATIAL SPA+30 SPB+0 SPC+0 {}\n{}\nL X+5 Y+6 Z+7 FMAX\nL X+9\n"


@pytest.mark.parametrize(
    ("way", "words"), [("STAY", "L A+Q120 C+Q122 FMAX"), ("STAY", "L A+30 C+0 FMAX"), ("TURN FMAX", "")]
)
def test_words_that_turn_the_axes_into_a_plane(tmp_path: Path, way: str, words: str) -> None:
    end = "L Z+90 FMAX\nPLANE RESET TURN FMAX\nL X+1 Y+2 Z+80 FMAX\nL X+2"
    path = read(tmp_path, SWIVEL.format(way, words) + end, MACHINES["table-table"])
    at = np.flatnonzero(path.line == 7)[-1]
    expected = Rotation.from_euler("X", 30, degrees=True).apply([9, 6, 7])
    np.testing.assert_allclose(path.position[at] * 1e3, expected, rtol=0, atol=1e-9)
    np.testing.assert_allclose(path.axis[at], [0, -0.5, np.sqrt(0.75)], atol=1e-12)
    np.testing.assert_allclose(path.position[-1] * 1e3, [2, 2, 80], atol=1e-12)
    np.testing.assert_array_equal(path.axis[-1], [0, 0, 1])


def test_angles_that_do_not_stand_in_the_plane(tmp_path: Path) -> None:
    with pytest.raises(ReadError, match="on the machine of the cell the tool points along"):
        read(tmp_path, SWIVEL.format("STAY", "L A+31 C+0 FMAX"), MACHINES["table-table"])
    with pytest.raises(ReadError, match="rotary words beside a move in a tilted plane"):
        read(tmp_path, SWIVEL.format("STAY", "L X+0 Y+0 Z+0 A+31 C+0 FMAX"), MACHINES["table-table"])


def test_without_a_machine(tmp_path: Path) -> None:
    """Zeros, and rapids of the axes alone before a plane; all else needs the machine."""
    text = "L A{} C+0 FMAX\n{}L X+1 Y+2 Z+3 FMAX\nL X+5 F9"
    assert len(read(tmp_path, text.format("+0", ""), None)) == 2
    path = read(tmp_path, text.format("+30", "PLANE SPATIAL SPA+30 SPB+0 SPC+0 STAY\n"), None)
    np.testing.assert_allclose(path.axis[-1], [0, -0.5, np.sqrt(0.75)], atol=1e-12)
    with pytest.raises(ReadError, match="the rotary axes stand at A30 C0: where its tip is depends on the machine"):
        read(tmp_path, text.format("+30", ""), None)
    with pytest.raises(ReadError, match=r"A30: a rotary axis: the machine's kinematics is not known"):
        read(tmp_path, "M128\nL X+0 Y+0 Z+0 A+30 FMAX", None)
    with pytest.raises(ReadError, match="the tool stands as in the tilted plane before"):
        tilted = "PLANE SPATIAL SPA+30 SPB+0 SPC+0 STAY\nL A+30 FMAX\nPLANE RESET STAY\n{}L X+1 Y+2 Z+3 FMAX"
        read(tmp_path, tilted.format(""), None)
    assert len(read(tmp_path, tilted.format("L A+0 FMAX\n"), None)) == 1


def test_a_program_beside_that_turns_axes(tmp_path: Path) -> None:
    (tmp_path / "OP1.H").write_text(
        "BEGIN PGM OP1 MM\nL A+0 C+0 FMAX\nM128\nL X+0 Y+0 Z+0 FMAX\nL X+5 A+30 F600\nM129\nEND PGM OP1 MM\n"
    )
    path = read(tmp_path, "L X+0 Y+0 Z+50 FMAX\nCALL PGM OP1", MACHINES["table-table"])
    np.testing.assert_allclose(path.axis[-1], [0, -0.5, np.sqrt(0.75)], atol=1e-12)
    np.testing.assert_allclose(path.position[0] * 1e3, [0, 0, 50])
