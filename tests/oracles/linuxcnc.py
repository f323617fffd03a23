"""LinuxCNC's interpreter (``rs274 -g``) as a second reader of G-code: every move, its kind and feed, and the arcs."""

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

from toolpaths.errors import ReadError
from toolpaths.toolpath import CUT, Toolpath

#: For tests that need it.
installed = pytest.mark.skipif(
    shutil.which("rs274") is None, reason="rs274 of LinuxCNC is missing (apt-get install linuxcnc-uspace)"
)
CALL = re.compile(r"N\S+\s+([A-Z_0-9]+)\((.*)\)\s*$")
SENSES = {"START_SPINDLE_CLOCKWISE": 1, "START_SPINDLE_COUNTERCLOCKWISE": -1}
FIRST_AXIS = {"XY": 0, "YZ": 1, "XZ": 2}
PRINTED_INCH = 4e-3  # mm: rs274 prints 4 decimals, inch blocks in inches, and shifts apart


@dataclass
class Reference:
    """What LinuxCNC would do, mm: ends (N, 3), cut (N,), feed (N,) mm/min, arcs by move, spindle (N, 2) rpm, sense."""

    ends: np.ndarray
    cut: np.ndarray
    feed: np.ndarray
    arcs: dict[int, tuple[int, np.ndarray, float]]  # normal axis, centre, turns (sign: about the axis)
    spindle: np.ndarray


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
    """The canonical calls of LinuxCNC as moves."""
    scale, plane, at, shift = 1.0, "XY", np.zeros(3), np.zeros(3)
    feed, per_turn, speed = 0.0, False, np.nan
    sense, stands, spindle = 0, False, []
    ends: list[np.ndarray] = []
    cut: list[bool] = []
    feeds: list[float] = []
    arcs: dict[int, tuple[int, np.ndarray, float]] = {}
    for text in run(file).splitlines():
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
        elif name in SENSES:
            sense, stands = SENSES[name], False
        elif name in ("STOP_SPINDLE_TURNING", "ORIENT_SPINDLE"):
            stands = True
        elif name in ("STRAIGHT_FEED", "STRAIGHT_TRAVERSE"):
            at = np.array([float(v) for v in arguments.split(",")[:3]]) * scale + shift
            ends.append(at)
            cut.append(name == "STRAIGHT_FEED")
            feeds.append(feed * (speed if per_turn else 1.0))
            spindle.append((0.0 if stands else speed, sense))
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
            spindle.append((0.0 if stands else speed, sense))
    return Reference(np.array(ends), np.array(cut), np.array(feeds), arcs, np.array(spindle))


def pairs(ours: np.ndarray, arcs: np.ndarray, cut: np.ndarray, ref: Reference, digits: float) -> np.ndarray:
    """(P, 2) which end of the file is which of the reference.

    A straight move to where the tool is already is none; what LinuxCNC prints of a move of few micrometres in inches
    may be none or more. Such moves may be left over on either side; before the position is known, up to three there.
    """
    same = np.abs(ref.ends[:4] - ours[0]).max(axis=1) <= digits
    assert same.any(), f"{ours[0]} is not where LinuxCNC begins: {ref.ends[:4]}"
    i, j, found = 0, int(np.argmax(same)), []

    def small(ends: np.ndarray, k: int, arc: bool) -> bool:
        return not arc and k > 0 and np.abs(ends[k] - ends[k - 1]).max() <= 2 * digits

    while i < len(ours) and j < len(ref.ends):
        arc, its_arc = bool(arcs[i]), j in ref.arcs
        alike = arc == its_arc or (its_arc and not small(ours, i, arc))  # an arc of one chord has no points
        if alike and np.abs(ours[i] - ref.ends[j]).max() <= digits and (cut[i] == ref.cut[j] or not i):
            found.append((i, j))
            i, j = i + 1, j + 1
        elif small(ours, i, arc):
            i += 1
        else:
            assert small(ref.ends, j, its_arc), f"move {i} to {ours[i]} is move {j} to {ref.ends[j]} of LinuxCNC"
            j += 1
    assert all(small(ours, k, bool(arcs[k])) for k in range(i, len(ours))), "LinuxCNC has fewer moves"
    assert all(small(ref.ends, k, k in ref.arcs) for k in range(j, len(ref.ends))), "LinuxCNC has more moves"
    return np.array(found)


def check(path: Toolpath, ref: Reference, digits: float) -> None:
    """The poses of the file are the end points; the points between lie on the arcs, in the right order."""
    poses = np.flatnonzero(path.row == np.round(path.row))
    ours = path.position * 1e3
    arcs = np.diff(poses, prepend=-1) > 1
    i, j = pairs(ours[poses], arcs, path.kind[poses] == CUT, ref, digits).T
    assert len(i) > 0.9 * len(poses) - 3
    np.testing.assert_allclose(ours[poses[i]], ref.ends[j], rtol=0, atol=digits)
    np.testing.assert_array_equal(path.kind[poses[i[1:]]] == CUT, ref.cut[j[1:]])
    cut = ref.cut[j] & (path.kind[poses[i]] == CUT)
    feed, expected = path.feed[poses[i]][cut] * 6e4, ref.feed[j][cut]
    slow = (feed < 2.55) & (expected < 2.55)  # LinuxCNC takes 0.1 a minute as the least of inverse-time feeds
    np.testing.assert_allclose(feed[~slow], expected[~slow], rtol=2e-3, atol=0.5)
    rpm = path.spindle[poses[i]] * 60 / (2 * np.pi)
    np.testing.assert_allclose(rpm, ref.spindle[j, 0], rtol=1e-6, atol=1e-4)
    np.testing.assert_array_equal(path.sense[poses[i]], ref.spindle[j, 1])
    at = dict(zip(j.tolist(), i.tolist(), strict=True))
    for move, (normal, center, turns) in ref.arcs.items():
        a, b = poses[at[move] - 1], poses[at[move]]
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
