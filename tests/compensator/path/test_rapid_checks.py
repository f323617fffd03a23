"""Rapids into what is cut: from the side a warning with pose and line, from above and along the tool none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from compensator.path.rapid_checks import rapid_findings
from compensator.tasks.compensate import preview_file
from tests.compensator.handmade_toolpaths import toolpath
from tests.compensator.small_job import files
from toolpaths.files import read_toolpath

SQUARE = [[0, 0, 50], [0, 0, 2], [0, 0, -5], [100, 0, -5], [100, 50, -5], [0, 50, -5], [0, 50, 50]]
KINDS = "rrccccr"
INSIDE = "a rapid goes sideways inside the box of what is cut, where nothing was cut before"
SIDE = "a rapid enters the box of what is cut from the side"


@pytest.mark.parametrize(
    ("more", "kinds", "poses"),
    [
        ([[-50, 25, 50], [-50, 25, -2], [50, 25, -2], [50, 25, -5]], "rrrc", [9]),  # into it
        ([[200, 25, 50], [200, 25, 1.8], [-100, 25, 1.8]], "rrr", [9]),  # through it
        ([[50, 25, -20], [50, 25, -5]], "rc", []),  # down a hole
        ([[200, 25, -20], [50, 25, -4]], "rr", [8]),  # from below one side
        ([[200, 25, 2], [-100, 25, 2]], "rr", []),  # over it, at the height where cuts begin
        ([[60, 25, 2], [50, 25, -5]], "rc", []),  # down from above, aslant
        ([[-50, 25, 50], [-50, 25, -4], [0, 25, -4]], "rrr", []),  # beside it, up to its side
        ([[50, 25, 2], [50, 25, -4], [60, 30, -4]], "rrr", [9]),  # inside it
        ([[50, 0, 2], [50, 0, -4], [50, 5, -4]], "rrr", []),  # where a cut went by
        ([[50, 0, 2], [50, 0, -5], [60, 0, -5], [60, 0, -4], [60, 40, -4]], "rrrrr", [11]),  # along a cut, then off it
        ([[200, 25, 2], [200, 25, -5], [50, 25, -5]], "rrr", [9]),  # on the floor
    ],
)
def test_from_the_side(more: list[list[float]], kinds: str, poses: list[int]) -> None:
    found = list(rapid_findings(toolpath(SQUARE + more, KINDS + kinds)))
    assert [f.place for f in found] == [f"test.csv:{k + 2} (pose {k})" for k in poses]
    assert all(f.what in (SIDE, INSIDE) and f.level == "warning" for f in found)


def test_a_forgotten_retract() -> None:
    """From one pocket to the next at the depth of the cut; along the side of the box too."""
    first = [[0, 0, 20], [0, 0, -5], [20, 0, -5], [20, 20, -5], [0, 20, -5], [0, 0, -5]]
    second = [[80, 0, -5], [100, 0, -5], [100, 20, -5], [80, 20, -5], [80, 0, -5], [80, 0, 20]]
    found = list(rapid_findings(toolpath(first + second, "rcccccrccccr")))
    assert [(f.place, f.what) for f in found] == [("test.csv:8 (pose 6)", INSIDE)]


def test_above_is_where_the_tool_looks_from() -> None:
    """A part that lies turned in the work object."""
    turn = Rotation.from_euler("xyz", [35, -50, 20], degrees=True)
    for more, poses in (([[-50, 25, 50], [-50, 25, -2], [50, 25, -2]], [9]), ([[50, 25, 50], [50, 25, -4]], [])):
        xyz = turn.apply(SQUARE + more)
        axis = np.tile(turn.apply([0, 0, 1]), (len(xyz), 1))
        found = list(rapid_findings(toolpath(xyz, KINDS + "r" * len(more), axis)))
        assert [f.place for f in found] == [f"test.csv:{k + 2} (pose {k})" for k in poses]


def test_along_a_tilted_tool() -> None:
    """Into the side of a part along the tool: an approach, not a collision that can be seen from here."""
    axis = np.tile([0.0, 0.0, 1.0], (10, 1))
    axis[7:] = [1.0, 0.0, 0.0]
    path = toolpath([*SQUARE, [150, 25, 50], [150, 25, -3], [90, 25, -3]], KINDS + "rrr", axis)
    assert list(rapid_findings(path)) == []


def test_real_files(shared: Path) -> None:
    """A part that is turned over between two set-ups, and one 5-axis link, of 15 files with 2,000 rapids."""
    cam = shared / "data/cam"
    hits = {"apt_solidworkscam/Sacrifice-Board.apt": [523], "clsf_nx/ust_a.cls": [615], "clsf_nx/cutcom.clsf": [],
            "apt_solidworkscam/SupPetriLED.apt": [], "gcode_fusion/1110_wall_265bit.nc": []}  # fmt: skip
    for name, lines in hits.items():
        found = list(rapid_findings(read_toolpath(cam / name)))
        assert [f.lines[0] for f in found] == lines and all(f.what == SIDE for f in found), name


def test_it_reaches_the_summary(tmp_path: Path) -> None:
    """Begun with a cut, and a rapid through the part: in the notes of every output."""
    job = files(tmp_path)
    (tmp_path / "a.nc").write_text(
        "G21 G90\nG1 X0 Y0 Z-2 F600\nX50\nY30\nG0 Z9\nX20\nZ5\nG1 Z-2\nG0 Z9\nX90\nZ1\nX10 Y15\nZ9\nM30\n"
    )
    notes = preview_file(tmp_path / "a.nc", job.cell).report["notes"]
    text = "\n".join(notes)
    assert "a.nc:2 (pose 0): the file begins with a cut" in text
    assert f"a.nc:12 (pose 10): {SIDE}" in text
