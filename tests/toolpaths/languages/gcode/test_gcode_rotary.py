"""Rotary words under a declared machine: against frames that are turned one after the other."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from toolpaths.errors import ReadError
from toolpaths.languages.gcode import reader as gcode
from toolpaths.machine import Machine, RotaryAxis
from toolpaths.toolpath import Toolpath

TILTED = (0.0, -np.sqrt(0.5), np.sqrt(0.5))  # a 45 deg axis, as of nutating heads and tables
A = RotaryAxis("A", (1.0, 0.0, 0.0), (0.05, -0.02, -0.11))
B = RotaryAxis("B", (0.0, 1.0, 0.0))
C = RotaryAxis("C", (0.0, 0.0, -1.0), (0.03, 0.04, 0.0))
MACHINES = {
    "table": Machine("table", (A,)),
    "head": Machine("head", (B,), 0.23),
    "table-table": Machine("table-table", (A, C)),
    "nutating table": Machine("table-table", (RotaryAxis("B", TILTED, (0.1, 0.2, -0.05)), C)),
    "head-head": Machine("head-head", (RotaryAxis("C", (0.0, 0.0, 1.0)), B), 0.31),
    "nutating head": Machine("head-head", (RotaryAxis("C", (0.0, 0.0, 1.0)), RotaryAxis("A", TILTED)), 0.31),
    "head-table": Machine("head-table", (B, C), 0.23),
}


def read(tmp_path: Path, text: str, machine: Machine | None, chord: float = 1e-5) -> Toolpath:
    file = tmp_path / "part.nc"
    file.write_text(text)
    return gcode.read(file, "part.nc", chord, machine)


def about(axis: RotaryAxis, angle: float, sign: float) -> np.ndarray:
    """(4, 4) turn about the line of an axis."""
    out = np.eye(4)
    out[:3, :3] = Rotation.from_rotvec(sign * angle * np.array(axis.direction)).as_matrix()
    centre = np.array(axis.centre or (0.0, 0.0, 0.0))
    out[:3, 3] = centre - out[:3, :3] @ centre
    return out


def expected(machine: Machine, xyz: np.ndarray, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Tip and tool axis in the work: bodies of the machine one on top of the other, each moved as a whole.

    A table turns against the direction in which the tool turns relative to the work.
    """
    work, spindle = np.eye(4), np.eye(4)
    spindle[:3, 3] = xyz + np.array([0.0, 0.0, machine.pivot or 0.0])
    for axis, place, angle in zip(machine.axes, machine.kinematics.split("-"), angles, strict=True):
        if place == "table":
            work = work @ about(axis, angle, -1.0)
        else:
            spindle[:3, :3] = spindle[:3, :3] @ about(axis, angle, 1.0)[:3, :3]
    tip = spindle @ [0.0, 0.0, -(machine.pivot or 0.0), 1.0]
    seen = np.linalg.inv(work)
    return (seen @ tip)[:3], seen[:3, :3] @ spindle[:3, 2]


def random_moves(machine: Machine, seed: int, n: int = 12) -> tuple[list[str], np.ndarray, np.ndarray]:
    g = np.random.default_rng(seed)
    xyz, angles = np.round(g.uniform(-80, 80, (n, 3)), 3), np.round(g.uniform(-170, 170, (n, len(machine.axes))), 3)
    lines = [
        " ".join(f"{c}{v:g}" for c, v in zip("XYZ" + machine.letters, [*p, *a], strict=True))
        for p, a in zip(xyz, angles, strict=True)
    ]
    return lines, xyz * 1e-3, np.radians(angles)


@pytest.mark.parametrize("name", MACHINES)
def test_poses_without_tip_control(tmp_path: Path, name: str) -> None:
    machine = MACHINES[name]
    lines, xyz, angles = random_moves(machine, 1)
    path = read(tmp_path, "G21 G90\nG0 " + lines[0] + "\nG1 F500 " + "\n".join(lines[1:]) + "\nM30\n", machine)
    whole = path.row == np.round(path.row)
    assert whole.sum() == len(xyz)
    for k, (p, a) in enumerate(zip(xyz, angles, strict=True)):
        tip, axis = expected(machine, p, a)
        np.testing.assert_allclose(path.position[whole][k], tip, atol=1e-12)
        np.testing.assert_allclose(path.axis[whole][k], axis, atol=1e-12)
    # the poses between: the way that the axes make when they move together
    k = np.flatnonzero(~whole)[::7]
    before = np.floor(path.row[k]).astype(int)
    share = (path.row[k] - before)[:, None]
    places = xyz[before] + share * (xyz[before + 1] - xyz[before])
    turns = angles[before] + share * (angles[before + 1] - angles[before])
    for i, p, a in zip(k, places, turns, strict=True):
        tip, axis = expected(machine, p, a)
        np.testing.assert_allclose(path.position[i], tip, atol=1e-9)
        np.testing.assert_allclose(path.axis[i], axis, atol=1e-9)


@pytest.mark.parametrize("name", MACHINES)
@pytest.mark.parametrize("chord", [1e-5, 1e-4])
def test_chords_stay_near_the_way_of_the_tip(tmp_path: Path, name: str, chord: float) -> None:
    machine = MACHINES[name]
    lines, xyz, angles = random_moves(machine, 2, 4)
    path = read(tmp_path, "G21 G90\nG0 " + lines[0] + "\nG1 F500 " + "\n".join(lines[1:]) + "\nM30\n", machine, chord)
    step = np.linalg.norm(np.diff(path.position, axis=0), axis=1)
    for i in range(0, len(path) - 1, 5):
        row = (path.row[i] + path.row[i + 1]) / 2
        k, s = int(row), row - int(row)
        tip, _ = expected(machine, xyz[k] + s * (xyz[k + 1] - xyz[k]), angles[k] + s * (angles[k + 1] - angles[k]))
        along = (path.position[i + 1] - path.position[i]) / max(step[i], 1e-12)
        off = tip - path.position[i]
        assert np.linalg.norm(off - (off @ along) * along) <= chord


def test_angles_to_the_right_side(tmp_path: Path) -> None:
    """C90 of a turning table: the table goes counterclockwise, so the tool sees the work go round clockwise."""
    machine = Machine("table", (RotaryAxis("C", (0.0, 0.0, -1.0), (0.0, 0.0, 0.0)),))
    path = read(tmp_path, "G21 G90\nG0 X10 Y0 Z0 C0\nG1 F100 C90\nM30\n", machine)
    np.testing.assert_allclose(path.position[-1], [0, -0.01, 0], atol=1e-15)
    machine = Machine("head", (RotaryAxis("B", (0.0, 1.0, 0.0)),), 0.1)
    path = read(tmp_path, "G21 G90\nG0 X0 Y0 Z0 B0\nG1 F100 B90\nM30\n", machine)
    np.testing.assert_allclose(path.axis[-1], [1, 0, 0], atol=1e-15)
    np.testing.assert_allclose(path.position[-1], [-0.1, 0, 0.1], atol=1e-15)


def test_tip_control_keeps_the_place_in_the_work(tmp_path: Path) -> None:
    machine = Machine("table-table", (RotaryAxis("A", (1.0, 0.0, 0.0)), RotaryAxis("C", (0.0, 0.0, -1.0))))
    path = read(
        tmp_path, "G21 G90\nG43.4 H1\nG0 X1 Y2 Z3 A0 C0\nG1 F100 X11 A-30\nG91 C90\nG90 G49\nG53 G0 Z0\nM30\n", machine
    )
    whole = path.row == np.round(path.row)
    np.testing.assert_allclose(path.position[whole] * 1e3, [[1, 2, 3], [11, 2, 3], [11, 2, 3]], atol=1e-12)
    half = np.sqrt(0.75)
    np.testing.assert_allclose(path.axis[whole], [[0, 0, 1], [0, 0.5, half], [0.5, 0, half]], atol=1e-12)
    turn = np.arccos(np.clip(np.sum(path.axis[1:] * path.axis[:-1], axis=1), -1, 1))
    assert np.degrees(turn.max()) < 2.0001 and len(path) == 1 + 15 + 45


def test_feeds(tmp_path: Path) -> None:
    machine = Machine("table", (RotaryAxis("C", (0.0, 0.0, -1.0), (0.0, 0.0, 0.0)),))
    text = "G21 G90\nG0 X10 Y0 Z0 C0\nG1 F100 X20\nC90 F360\nG93 C180 F4\nX30 C180 F2\nG94 F50 Z2\nX0 Y0 Z2\nC90\nM30\n"
    path = read(tmp_path, text, machine, 1e-8)
    feed = path.feed[path.row == np.round(path.row)] * 6e4
    # 90 deg at 360 deg/min take a quarter of a minute, a quarter circle of 20 mm radius
    quarter = 10 * np.pi
    np.testing.assert_allclose(feed[1:], [100, 4 * quarter, 4 * quarter, 20, 50, 50, 50], rtol=1e-5)


def test_turns_do_not_fill_the_memory(tmp_path: Path) -> None:
    """Twenty short lines that would make a hundred thousand poses each."""
    text = "G21 G90\nG0 X1 Y2 Z3 A0\n" + "G1 A9000000 F1\nA0\n" * 10 + "M30\n"
    with pytest.raises(ReadError, match="its turns make 2000001 poses; at most") as caught:
        read(tmp_path, text, MACHINES["table"])
    assert caught.value.line == 3


REFUSED = {
    "G0 X1 Y1 Z1 B5": ("B5: a rotary axis: the machine has no such axis", MACHINES["table"]),
    "G0 X1 Y1 Z1 A5": ("the machine's kinematics is not known", None),
    "G0 X1 Y1 Z1 A0\nG2 X5 I2 A3 F9": ("rotary words in an arc", MACHINES["table"]),
    "G0 X1 Y1 Z9 A10\nG81 Z-1 R1 F100": ("canned cycle with rotary axes", MACHINES["table"]),
    "G0 X1 Y1 Z1 B9 C3": ("the centre of axis C and pivot of the machine is not known",
                          Machine("head-table", (B, RotaryAxis("C", (0.0, 0.0, 1.0))))),
    "G43.4 H1\nG0 X1 Y1 Z1 A0\nG1 X1 F9 I1 J0 K1": ("I, J, K or R with G1", MACHINES["table"]),
    "G0 X1 Y1 Z1 A0\nG28 G91 Z0 A0\nG90\nG0 Z5\nG1 X1 F5": ("where a rotary axis is, is not known", MACHINES["table"]),
}  # fmt: skip


@pytest.mark.parametrize("text", REFUSED)
def test_refused(tmp_path: Path, text: str) -> None:
    message, machine = REFUSED[text]
    with pytest.raises(ReadError) as caught:
        read(tmp_path, f"G21 G90\n{text}\nM30\n", machine)
    assert message in str(caught.value) and caught.value.line == 1 + len(text.split("\n"))


def test_files_without_rotary_words_need_nothing(tmp_path: Path) -> None:
    path = read(tmp_path, "G21 G90 (A90)\nG0 X1 Y2 Z3\nG1 X2 F9\nM30\n", MACHINES["head-table"])
    np.testing.assert_allclose(path.position * 1e3, [[1, 2, 3], [2, 2, 3]], atol=1e-14)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"kinematics": "table-head", "axes": (A, C)}, "one of table, head"),
        ({"kinematics": "table", "axes": (A, C)}, "needs 1 axes, 2 are given"),
        ({"kinematics": "head-head", "axes": (A, A)}, "different ones of A, B, C"),
        ({"kinematics": "head", "axes": (RotaryAxis("U", (1.0, 0.0, 0.0)),)}, "different ones of A, B, C"),
        ({"kinematics": "table", "axes": (RotaryAxis("A", (1.0, 0.0, 0.5)),)}, "a unit vector"),
        ({"kinematics": "table", "axes": (RotaryAxis("A", (np.nan, 0.0, 0.0)),)}, "a unit vector"),
    ],
)
def test_machines_that_cannot_be(values: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Machine(**values)  # type: ignore[arg-type]
