"""Programs as G-code: what is printed, read back, and what rs274 makes of it."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.oracles.linuxcnc import reference
from tests.oracles.sample_programs import SPINDLE, changed, random_program, small
from toolpaths.files import read_back, write_program
from toolpaths.rotation import aligned, rotation_of_axis
from toolpaths.toolpath import CUT, MachineCommand
from toolpaths.writing.program import Order


def text(program, path: Path) -> str:
    write_program(program, path)
    return path.read_text()


def test_words_in_force_are_left_out(tmp_path):
    lines = text(small(), tmp_path / "part1.nc").split("\n")
    moves = [line for line in lines if re.search(r"^(G6[14] )?(G[01] )?[XYZ]", line)]
    assert moves == [
        "G0 X0.0000 Y0.0000 Z50.0000 I0.0000000 J0.0000000 K1.0000000", "Z5.0000", "G1 Z0.0000 F300", "X40.0000 F1200",
        "G61 Y20.0000", "G64 X40.0123 Y20.0006", "X0.0000 Y20.0000 F1800", "G0 Z50.0000",
    ]  # fmt: skip


def test_the_turn_about_the_tool_is_said_to_be_open(tmp_path):
    (finding,) = write_program(small(), tmp_path / "a.nc").findings
    assert "the turn about it" in finding.what and finding.level == "warning"


def test_several_tools(tmp_path):
    program = changed(
        small(), tool=np.array([2, 2, 2, 2, 5, 5, 5, 0], dtype=np.int32), tools={0: SPINDLE, 2: SPINDLE, 5: SPINDLE}
    )
    lines = text(program, tmp_path / "a.nc").split("\n")
    at = lines.index("T5 M6")
    assert lines[at - 2 : at + 3] == [
        "G49", "(tool 5: spindle-a)", "T5 M6", "G43.4 H5",
        "G61 G1 X40.0000 Y20.0000 Z0.0000 I0.0000000 J0.0000000 K1.0000000 F1200",
    ]  # fmt: skip
    assert "T0 M6" not in lines and lines.count("G49") == 3 and "G43.4 H2" in lines
    np.testing.assert_allclose(read_back(tmp_path / "a.nc").position, program.position, atol=0.51e-7)


def test_one_tool_of_the_cell_is_called_by_the_number_of_the_source(tmp_path):
    """A tool that the source only names gets its M6 and its own length, at the begin or where the source has it."""
    asked = [(0, "T", 'T="MILL" (tool 5) D1'), (0, "M6", "M6"), (2, "M6", "T5 M6"), (4, "M6", "T7 M6")]
    orders = tuple(
        Order(pose, MachineCommand(word, {"T": 7.0 if pose == 4 else 5.0}), 3, says) for pose, word, says in asked
    )
    comments = tuple((pose, says) for pose, _, says in asked)
    program = changed(small(), tool=np.zeros(8, dtype=np.int32), tools={0: SPINDLE}, orders=orders, comments=comments)
    lines = text(program, tmp_path / "a.nc").split("\n")
    called = [line for line in lines if re.match(r"T\d+ M6|G43|G49|.*M6\)", line)]
    assert called == ["T5 M6", "G43.4 H5", "(T5 M6)", "G49", "T7 M6", "G43.4 H7", "G49"]
    assert re.match(r"(G6[14] )?G1 X40.0000 Y20.0000 Z0.0000 I0", lines[lines.index("G43.4 H7") + 1])
    np.testing.assert_allclose(read_back(tmp_path / "a.nc").position, program.position, atol=0.51e-7)


def test_spindle_and_coolant_come_back_as_words(tmp_path):
    comments = ((0, "S12000 M3"), (0, "M8"), (3, "M5"), (3, "M30"), (4, "G0 X0"), (5, "a (b) #1=2"), (6, "S1.5"))
    lines = text(changed(small(), comments=comments), tmp_path / "a.nc").split("\n")
    for word in ("S12000 M3", "M8", "M5", "(M30)", "(G0 X0)", "(a [b] #1=2)", "S1.5"):
        assert word in lines, word


@pytest.mark.parametrize("seed", range(3))
def test_read_back_to_the_printed_digits(tmp_path, seed):
    program = random_program(9000, seed)
    write_program(program, tmp_path / "a.nc")
    back = read_back(tmp_path / "a.nc")
    np.testing.assert_allclose(back.position, program.position, rtol=0, atol=0.51e-7)
    np.testing.assert_allclose(back.rotation[:, :, 2], program.rotation[:, :, 2], rtol=0, atol=1e-7)
    np.testing.assert_allclose(back.feed, program.feed, rtol=1e-6)


def test_rotation_of_any_tool_vector():
    axis = np.vstack([Rotation.random(500, rng=1).as_matrix()[:, :, 0], np.eye(3), -np.eye(3)])
    r = rotation_of_axis(axis)
    np.testing.assert_allclose(r[:, :, 2], -axis, atol=1e-15)
    np.testing.assert_allclose(r @ np.swapaxes(r, 1, 2), np.tile(np.eye(3), (len(axis), 1, 1)), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(r), 1)


def test_printed_vectors_onto_commanded_orientations():
    g = np.random.default_rng(3)
    rotation = Rotation.random(200, rng=2)
    turn = g.normal(scale=0.3, size=(200, 3))
    axis = -(Rotation.from_rotvec(turn) * rotation).as_matrix()[:, :, 2]
    out = aligned(rotation.as_matrix(), axis)
    np.testing.assert_allclose(out[:, :, 2], -axis, atol=1e-12)
    least = np.arccos(np.clip(np.sum(-axis * rotation.as_matrix()[:, :, 2], axis=1), -1, 1))
    np.testing.assert_allclose((Rotation.from_matrix(out) * rotation.inv()).magnitude(), least, atol=1e-7)


@pytest.mark.skipif(
    shutil.which("rs274") is None, reason="rs274 of LinuxCNC is missing (apt-get install linuxcnc-uspace)"
)
def test_rs274_goes_to_the_same_places(tmp_path):
    """LinuxCNC knows no G43.4: the tool vectors are taken out, everything else is read as written."""
    program = changed(random_program(3000, 5), tool=np.repeat([1, 3, 2], 1000).astype(np.int32),
                      tools={1: SPINDLE, 2: SPINDLE, 3: SPINDLE})  # fmt: skip
    printed = text(program, tmp_path / "a.nc")
    file = tmp_path / "a.ngc"
    file.write_text(re.sub(r"G43\.4 H\d+\n| [IJK]-?[\d.]+", "", printed))
    ref = reference(file)
    np.testing.assert_allclose(ref.ends, program.position * 1e3, rtol=0, atol=1e-4)
    np.testing.assert_array_equal(ref.cut, program.kind == CUT)
    np.testing.assert_allclose(ref.feed[ref.cut], program.feed[ref.cut] * 6e4, rtol=1e-4)
