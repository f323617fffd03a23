"""G-code against LinuxCNC's interpreter (``rs274 -g``): end points of every move, and the arcs between."""

from __future__ import annotations

import os
import random
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import pytest

from toolpaths.errors import ReadError
from toolpaths.readers import read_toolpath
from toolpaths.toolpath import Toolpath

pytestmark = pytest.mark.skipif(
    shutil.which("rs274") is None, reason="rs274 of LinuxCNC is missing (apt-get install linuxcnc-uspace)"
)
CALL = re.compile(r"N\S+\s+([A-Z_]+)\((.*)\)\s*$")
FIRST_AXIS = {"XY": 0, "YZ": 1, "XZ": 2}
Arc = tuple[int, int, np.ndarray, float]  # move, normal axis, center mm, turns (sign: about the axis)


def reference(file: Path) -> tuple[np.ndarray, list[Arc]]:
    """End points (N, 3) mm of all moves, and the arcs, as LinuxCNC's canonical calls say."""
    # rs274 maps its tool table into a file in HOME: runs side by side would share it
    with tempfile.TemporaryDirectory() as home:
        run = subprocess.run(
            ["rs274", "-g", str(file.resolve())],
            capture_output=True,
            text=True,
            timeout=120,
            cwd=home,
            env={**os.environ, "HOME": home},
        )
    if run.returncode:
        raise ReadError(str(file), None, run.stderr.strip() or run.stdout[-300:])
    scale, plane, at = 1.0, "XY", np.zeros(3)
    points: list[np.ndarray] = []
    arcs: list[Arc] = []
    for text in run.stdout.splitlines():
        match = CALL.search(text)
        if match is None:
            continue
        name, arguments = match.groups()
        if name == "USE_LENGTH_UNITS":
            scale = 25.4 if "INCH" in arguments else 1.0
        elif name == "SELECT_PLANE":
            plane = arguments[-2:]
        elif name in ("STRAIGHT_FEED", "STRAIGHT_TRAVERSE"):
            at = np.array([float(v) for v in arguments.split(",")[:3]]) * scale
            points.append(at)
        elif name == "ARC_FEED":
            u, v, cu, cv, turns, w = (float(v) for v in arguments.split(",")[:6])
            first = FIRST_AXIS[plane]
            order = [first, (first + 1) % 3, (first + 2) % 3]
            center = at.copy()
            at = np.zeros(3)
            at[order] = np.array([u, v, w]) * scale
            center[order[:2]] = np.array([cu, cv]) * scale
            arcs.append((len(points), order[2], center, turns))
            points.append(at)
    return np.array(points), arcs


def check(path: Toolpath, points: np.ndarray, arcs: list[Arc], digits: float) -> None:
    """The poses of the file are the end points; the points between lie on the arcs, in the right order."""
    poses = np.flatnonzero(path.row == np.round(path.row))
    skipped = len(points) - len(poses)  # LinuxCNC starts at 0, 0, 0; the reader when it knows the position
    ours = path.position * 1e3
    np.testing.assert_allclose(ours[poses], points[skipped:], rtol=0, atol=digits)
    for move, normal, center, turns in arcs:
        a, b = poses[move - skipped - 1], poses[move - skipped]
        plane = [(normal + 1) % 3, (normal + 2) % 3]
        out = ours[a : b + 1][:, plane] - center[plane]
        radius = np.linalg.norm(out, axis=1)
        assert np.ptp(radius) < 0.02 and radius.max() < radius[0] + 0.02
        angle = np.unwrap(np.arctan2(out[:, 1], out[:, 0])) * np.sign(turns)
        assert (np.diff(angle) > -1e-9).all() and angle[-1] - angle[0] < 2 * np.pi + 1e-6
        rise = ours[a : b + 1, normal]
        share = (angle - angle[0]) / max(angle[-1] - angle[0], 1e-9)
        expected = rise[0] + share * (rise[-1] - rise[0])
        np.testing.assert_allclose(rise, expected, rtol=0, atol=2e-3 + 1e-4 * np.ptp(rise))


@pytest.mark.parametrize(
    "name",
    [
        "gcode_fusion/1110_wall_265bit.nc",
        "gcode_fusion/1121_btn8copies_20bit.nc",
        "gcode_cncjs/tball-pocket.gcode",
        "gcode_cncjs/tball.gcode",
    ],
)
def test_real_files_agree(shared: Path, name: str) -> None:
    file = shared / "data/cam" / name
    points, arcs = reference(file)
    path = read_toolpath(file)
    assert int(path.row[-1]) + 1 >= len(points) - 3
    check(path, points, arcs, 1e-4)


def test_unfinished_real_files_agree_once_they_end(shared: Path, tmp_path: Path) -> None:
    for name in (
        "jsdc.gcode",
        "g2-arc.gcode",
        "circle-inch.gcode",
        "arc-xz-plane.gcode",
        "arc-yz-plane.gcode",
    ):
        text = (shared / "data/cam/gcode_cncjs" / name).read_text()
        head = "" if "G21" in text or "G20" in text else "G21\nG0 X0 Y0 Z0\n"
        file = tmp_path / f"{name}.nc"
        file.write_text(f"{head}{text}\nM2\n")
        check(read_toolpath(file), *reference(file), 1e-4 if "inch" not in name else 2e-3)


def random_program(seed: int) -> str:
    """Some hundred blocks of modal words, planes, units, relative moves, arcs of both forms."""
    rng = random.Random(seed)

    def number(low: float, high: float) -> str:
        value = f"{rng.uniform(low, high):.4f}"
        return rng.choice([value, value.rstrip("0"), f"{float(value):+.4f}"])

    def some(letters: str, low: float, high: float) -> str:
        kept = [c for c in letters if rng.random() < 0.6] or [letters[0]]
        return " ".join(f"{c}{number(low, high)}" for c in kept)

    lines = [f"G21 G90 G17 G40 (seed {seed})", "G0 X1 Y-2 Z3", "F500"]
    for _ in range(150):
        size = 20.0 if lines[-1] else 1.0
        pick = rng.random()
        if pick < 0.08:
            lines.append(rng.choice(["G17", "G18", "G19"]))
        elif pick < 0.14:
            lines.append(rng.choice(["G90", "G91"]))
        elif pick < 0.18:
            lines.append(rng.choice(["G20 F20", "G21 F500"]))
        elif pick < 0.4:
            lines.append(f"{rng.choice(['G0', 'g1', 'G01', 'G1 F99'])} {some('XYZ', -size, size)}")
        elif pick < 0.5:
            lines.append(f"N{len(lines)} G{rng.choice([0, 1])}{some('XYZ', -size, size)} ; tail")
        else:
            lines.append(arc(rng, lines))
    return "\n".join(lines) + "\nM2\n"


def arc(rng: random.Random, lines: list[str]) -> str:
    """An arc block for the plane in force; in G90 a full turn, whose end is right wherever it starts."""
    plane = next((w for line in reversed(lines) for w in ("G17", "G18", "G19") if w in line.upper()), "G17")
    relative = (
        next((w for line in reversed(lines) for w in ("G90", "G91") if w in line.upper()), "G90") == "G91"
    )
    word = rng.choice(["G2", "G3", "G02", "G03"])
    (u, i), (v, j), w = {
        "G17": (("X", "I"), ("Y", "J"), "Z"),
        "G18": (("Z", "K"), ("X", "I"), "Y"),
        "G19": (("Y", "J"), ("Z", "K"), "X"),
    }[plane]
    if rng.random() < 0.4 or not relative:  # a full circle or a helix turn, right in G90 too
        rise = f" {w}{rng.uniform(-1, 1):.4f}" if rng.random() < 0.5 else ""
        return f"{word} {i}{rng.uniform(0.5, 9):.4f} {j}{rng.uniform(-9, 9):.4f}{rise}"
    radius, a = rng.uniform(1, 20), rng.uniform(0, 2 * np.pi)
    b = a + rng.uniform(0.2, 6.0) * rng.choice([-1, 1])
    du, dv = radius * (np.cos(b) - np.cos(a)), radius * (np.sin(b) - np.sin(a))
    if rng.random() < 0.5:
        sign = rng.choice(["", "-"])
        return f"{word} {u}{du:.4f} {v}{dv:.4f} R{sign}{max(radius, np.hypot(du, dv) / 2 + 0.01):.4f}"
    return f"{word} {u}{du:.5f} {v}{dv:.5f} {i}{-radius * np.cos(a):.5f} {j}{-radius * np.sin(a):.5f}"


@pytest.mark.parametrize("block", range(4))
def test_random_modal_programs_agree(tmp_path: Path, block: int) -> None:
    agreed = 0
    for seed in range(block * 10, block * 10 + 10):
        file = tmp_path / f"random{seed}.ngc"
        file.write_text(random_program(seed))
        try:
            points, arcs = reference(file)
        except ReadError as problem:
            with pytest.raises(ReadError):
                read_toolpath(file)
            print(problem)
            continue
        # printed with 4 decimals, inch blocks in inches; relative moves add up what is cut off
        check(read_toolpath(file), points, arcs, 1.5e-3 if "G20" in file.read_text() else 1e-4)
        agreed += len(points)
    assert agreed > 500
