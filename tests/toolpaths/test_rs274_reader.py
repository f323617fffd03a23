"""G-code against LinuxCNC's interpreter (``rs274 -g``): every move, its kind and feed, and the arcs between."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from tests.oracles.random_gcode import RandomProgram
from toolpaths.errors import ReadError
from toolpaths.readers import read_toolpath
from toolpaths.toolpath import CUT, Toolpath

pytestmark = pytest.mark.skipif(
    shutil.which("rs274") is None, reason="rs274 of LinuxCNC is missing (apt-get install linuxcnc-uspace)"
)
CALL = re.compile(r"N\S+\s+([A-Z_0-9]+)\((.*)\)\s*$")
FIRST_AXIS = {"XY": 0, "YZ": 1, "XZ": 2}
PRINTED_INCH = 4e-3  # mm: rs274 prints 4 decimals, inch blocks in inches, and shifts apart


@dataclass
class Reference:
    """What LinuxCNC would do, mm: ends (N, 3), cut (N,), feed (N,) mm/min, arcs by move."""

    ends: np.ndarray
    cut: np.ndarray
    feed: np.ndarray
    arcs: dict[int, tuple[int, np.ndarray, float]]  # normal axis, centre, turns (sign: about the axis)


def run(file: Path) -> str:
    # rs274 maps its tool table into a file in HOME: runs side by side would share it
    with tempfile.TemporaryDirectory() as home:
        done = subprocess.run(
            ["rs274", "-g", str(file.resolve())],
            capture_output=True, text=True, timeout=120, cwd=home, env={**os.environ, "HOME": home},
        )  # fmt: skip
    if done.returncode:
        raise ReadError(str(file), None, done.stderr.strip() or done.stdout[-300:])
    return done.stdout


def reference(file: Path) -> Reference:
    """The canonical calls of LinuxCNC as moves; a move to where the tool is already is none."""
    scale, plane, at, shift = 1.0, "XY", np.zeros(3), np.zeros(3)
    feed, per_turn, speed = 0.0, False, 0.0
    ends: list[np.ndarray] = []
    cut: list[bool] = []
    feeds: list[float] = []
    arcs: dict[int, tuple[int, np.ndarray, float]] = {}
    printed = run(file)
    near = 5e-3 if "UNITS_INCH" in printed else 5e-5
    for text in printed.splitlines():
        match = CALL.search(text)
        if match is None:
            continue
        name, arguments = match.groups()
        if name == "USE_LENGTH_UNITS":
            scale = 25.4 if "INCH" in arguments else 1.0
        elif name == "SELECT_PLANE":
            plane = arguments[-2:]
        elif name == "SET_G92_OFFSET":
            shift = np.array([float(v) for v in arguments.split(",")[:3]]) * scale
        elif name == "SET_FEED_RATE":
            feed = float(arguments) * scale
        elif name == "SET_FEED_MODE":
            per_turn = arguments.split(",")[1].strip() == "1"
        elif name == "SET_SPINDLE_SPEED":
            speed = float(arguments.split(",")[1])
        elif name in ("STRAIGHT_FEED", "STRAIGHT_TRAVERSE"):
            to = np.array([float(v) for v in arguments.split(",")[:3]]) * scale + shift
            if ends and np.abs(to - at).max() < near:
                at = to
                continue
            at = to
            ends.append(at)
            cut.append(name == "STRAIGHT_FEED")
            feeds.append(feed * (speed if per_turn else 1.0))
        elif name == "ARC_FEED":
            u, v, cu, cv, turns, w = (float(v) for v in arguments.split(",")[:6])
            first = FIRST_AXIS[plane]
            order = [first, (first + 1) % 3, (first + 2) % 3]
            center, to = np.zeros(3), np.zeros(3)
            to[order] = np.array([u, v, w]) * scale
            center[order[:2]] = np.array([cu, cv]) * scale
            at = to + shift
            arcs[len(ends)] = order[2], center + shift, turns
            ends.append(at)
            cut.append(True)
            feeds.append(feed * (speed if per_turn else 1.0))
    return Reference(np.array(ends), np.array(cut), np.array(feeds), arcs)


def check(path: Toolpath, ref: Reference, digits: float) -> None:
    """The poses of the file are the end points; the points between lie on the arcs, in the right order."""
    poses = np.flatnonzero(path.row == np.round(path.row))
    ours = path.position * 1e3
    still = np.abs(np.diff(ours[poses], axis=0)).max(axis=1, initial=0) < (5e-3 if digits > 1e-3 else 5e-5)
    poses = poses[np.concatenate([[True], ~(still & (np.diff(poses) == 1))])]
    skipped = len(ref.ends) - len(poses)  # LinuxCNC starts at 0, 0, 0; the reader when it knows the position
    assert 0 <= skipped < 4
    np.testing.assert_allclose(ours[poses], ref.ends[skipped:], rtol=0, atol=digits)
    np.testing.assert_array_equal(path.kind[poses] == CUT, ref.cut[skipped:])
    cut = ref.cut[skipped:]
    feed, expected = path.feed[poses][cut] * 6e4, ref.feed[skipped:][cut]
    slow = (feed < 2.55) & (expected < 2.55)  # LinuxCNC takes 0.1 a minute as the least of inverse-time feeds
    np.testing.assert_allclose(feed[~slow], expected[~slow], rtol=2e-3, atol=0.5)
    for move, (normal, center, turns) in ref.arcs.items():
        a, b = poses[move - skipped - 1], poses[move - skipped]
        plane = [(normal + 1) % 3, (normal + 2) % 3]
        out = ours[a : b + 1][:, plane] - center[plane]
        radius = np.linalg.norm(out, axis=1)
        assert np.ptp(radius) < 0.02
        angle = np.unwrap(np.arctan2(out[:, 1], out[:, 0])) * np.sign(turns)
        assert (np.diff(angle) > -1e-9).all()
        sweep, whole = angle[-1] - angle[0], 2 * np.pi * (abs(turns) - 1)
        assert whole - 1e-6 < sweep < whole + 2 * np.pi + 1e-6
        sagitta = radius[:-1] * (1 - np.cos(np.diff(angle) / 2))
        assert sagitta.max() < 0.0105  # mm: the chord tolerance, and what rs274 does not print
        rise = ours[a : b + 1, normal]
        share = (angle - angle[0]) / max(sweep, 1e-9)
        expected = rise[0] + share * (rise[-1] - rise[0])
        turned = digits / radius.min() / sweep  # what printing takes from the angle
        np.testing.assert_allclose(rise, expected, rtol=0, atol=2e-3 + (1e-4 + turned) * np.ptp(rise))


REAL = [
    "gcode_fusion/1110_wall_265bit.nc", "gcode_fusion/1121_btn8copies_20bit.nc", "gcode_cncjs/tball-pocket.gcode",

    "gcode_cncjs/tball.gcode",
]  # fmt: skip
ENDED = ["jsdc", "g2-arc", "circle-inch", "arc-xy-plane", "arc-xz-plane", "arc-yz-plane", "arc-ijk"]  # no M2 in these
#: What rs274 takes and this reader does not, and why: it needs to know units, or compensates the cutter itself.
REFUSED = {
    "gcode_cncjs/Circle_Diamond_Square_Calibration.gcode": "",
    "gcode_cncjs/helical-thread-milling.gcode": "G4[12]",
    "gcode_cncjs/sample.gcode": "3D printer",
}


@pytest.mark.parametrize("name", REAL)
def test_real_files_agree(shared: Path, name: str) -> None:
    file = shared / "data/cam" / name
    check(read_toolpath(file), reference(file), 1e-4)


@pytest.mark.parametrize("name", ENDED)
def test_unfinished_real_files_agree_once_they_end(shared: Path, tmp_path: Path, name: str) -> None:
    text = (shared / "data/cam/gcode_cncjs" / f"{name}.gcode").read_text()
    head = "" if "G21" in text or "G20" in text else "G21\nG0 X0 Y0 Z0\n"
    file = tmp_path / f"{name}.nc"
    file.write_text(f"{head}{text}\nM2\n")
    check(read_toolpath(file), reference(file), PRINTED_INCH if "inch" in name else 1e-4)


@pytest.mark.parametrize("block", range(6))
def test_random_modal_programs_agree(tmp_path: Path, block: int) -> None:
    agreed = 0
    for seed in range(block * 10, block * 10 + 10):
        program = RandomProgram(seed)
        file = tmp_path / f"random{seed}.ngc"
        file.write_text(program.text)
        ref = reference(file)
        check(read_toolpath(file), ref, PRINTED_INCH if "G20" in program.text.upper() else 1e-4)
        agreed += len(ref.ends)
    assert agreed > 1000
