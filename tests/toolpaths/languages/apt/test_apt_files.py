"""The APT/CL and CLSF files of ../shared/data/cam against their own text and against the meshes of their parts."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath
from toolpaths.toolpath import CUT, RAPID, Toolpath

CHORD = 1e-6
PARTS = ("Dem-target2", "Sacrifice-Board", "SupPetriLED", "basemach")
FILES = (
    *(f"apt_solidworkscam/{name}.apt" for name in PARTS),
    *(f"clsf_nx/{name}" for name in ("_1_KONTUR_NAR_40_N2.cls", "_3_PAZ_125_N2.cls", "cutcom.clsf", "deep_drill.clsf")),
    "clsf_nx/ust_a.cls",
)
MESH = 0.2  # mm by which the chords of a mesh may miss the round walls of the part

OFF_EDGES = np.array([1e-4, 1.7e-4, 0.0])  # mm, so that no ray meets an edge of the mesh


def figures(line: str) -> np.ndarray:
    return np.array([float(v) for v in line.split("/")[1].split(",")])


def open_file(shared: Path, name: str, chord: float = CHORD) -> tuple[list[str], Toolpath]:
    """Its lines (index = line number) and its path."""
    file = shared / "data/cam" / name
    return ["", *file.read_text().splitlines()], read_toolpath(file, chord=chord)


def in_cycle(lines: list[str]) -> dict[int, str]:
    """Line of each GOTO that names a hole, and its CYCLE."""
    found, cycle = {}, ""
    for number, line in enumerate(lines):
        if line.startswith("CYCLE/"):
            cycle = "" if re.match(r"CYCLE/(OFF|INIT|CLEAR)", line) else line
        if line.startswith("GOTO") and cycle:
            found[number] = cycle
    return found


@pytest.mark.parametrize("name", FILES)
def test_moves_end_where_the_file_says(shared: Path, name: str) -> None:
    """Every GOTO outside a cycle ends at its numbers, with its axis; rapid as the line before says."""
    lines, path = open_file(shared, name)
    holes = in_cycle(lines)
    axis, rapid, seen, feed = np.array([0.0, 0.0, 1.0]), False, 0, np.nan
    for number, line in enumerate(lines):
        rapid = rapid or line.startswith("RAPID")
        feed = float(re.findall(r"[\d.]+", line)[0]) if line.startswith("FEDRAT") else feed
        if not line.startswith("GOTO") or number in holes:
            continue
        v = figures(line)
        axis = v[3:] if len(v) == 6 else axis
        last = int(np.flatnonzero(path.line == number)[-1])
        np.testing.assert_allclose(path.position[last] * 1e3, v[:3], rtol=0, atol=1e-11)
        np.testing.assert_allclose(path.axis[last], axis, rtol=0, atol=1e-7)
        assert path.kind[last] == (RAPID if rapid else CUT)
        assert rapid or path.feed[last] * 6e4 == pytest.approx(feed, nan_ok=True)
        rapid, seen = False, seen + 1
    assert seen == sum(line.startswith("GOTO") for line in lines) - len(holes)
    assert set(path.line) == {n for n, line in enumerate(lines) if line.startswith("GOTO")}


@pytest.mark.parametrize("name", FILES)
def test_arcs_keep_their_radius(shared: Path, name: str) -> None:
    lines, path = open_file(shared, name)
    arcs = [n for n, line in enumerate(lines) if line.startswith("CIRCLE")]
    for number in arcs:
        v = figures(lines[number])
        end = next(n for n in range(number, len(lines)) if lines[n].startswith("GOTO"))
        inside = np.flatnonzero(path.line == end)
        points = path.position[[inside[0] - 1, *inside]] * 1e3
        radius = np.linalg.norm(points - v[:3], axis=1)
        given = v[6] if len(v) > 6 else radius[0]
        assert np.abs(radius - given).max() < 2e-3  # the last digits of the file
        middle = (points[1:] + points[:-1]) / 2
        assert (given - np.linalg.norm(middle - v[:3], axis=1)).max() < CHORD * 1e3 + 2e-3
    assert bool(arcs) == (name not in ("clsf_nx/deep_drill.clsf", "clsf_nx/ust_a.cls"))


@pytest.mark.parametrize("name", FILES)
def test_arcs_go_the_way_that_has_no_corner(shared: Path, name: str) -> None:
    """At most joints of an arc the path goes straight on, and nowhere in the middle of a pocket does it turn back."""
    lines, path = open_file(shared, name)
    ends = {next(m for m in range(n, len(lines)) if lines[m].startswith("GOTO")) for n, line in enumerate(lines)
            if line.startswith("CIRCLE")}  # fmt: skip
    step = np.diff(path.position, axis=0)
    length = np.linalg.norm(step, axis=1)
    bend = np.einsum("ij,ij->i", step[1:], step[:-1]) / np.maximum(length[1:] * length[:-1], 1e-300)
    line, both = path.line[1:], (path.kind[1:-1] == CUT) & (path.kind[2:] == CUT) & (length[1:] > 1e-5)
    joint = both & (length[:-1] > 1e-5) & (line[1:] != line[:-1])
    joint &= np.isin(line[1:], list(ends)) | np.isin(line[:-1], list(ends))
    if ends:
        assert (bend[joint] < -0.9).mean() < 0.01  # drawn the other way round: 27 % to 100 %
        assert (bend[joint] > 0.9).mean() > 0.4


def expected_hole(v: np.ndarray, cycle: str, nx: bool) -> tuple[float, float, float, float]:
    """Heights over the point, mm: bottom, begin of feed, retract; and the feed in mm/min."""
    words = cycle.strip().split("/")[1].split(",")
    value = {k: float(n) for k, n in pairwise(words) if re.fullmatch(r"-?[\d.]+", n)}
    depth = value["FEDTO"] if nx else -value["FEDTO"]
    return depth, value["RAPTO"], value.get("RTRCTO", value["RAPTO"]), value["MMPM"]


@pytest.mark.parametrize("name", [f for f in FILES if f not in ("clsf_nx/cutcom.clsf", "clsf_nx/ust_a.cls")])
def test_holes_are_as_deep_as_the_cycle_says(shared: Path, name: str) -> None:
    lines, path = open_file(shared, name)
    for number, cycle in in_cycle(lines).items():
        v = figures(lines[number])
        axis = v[3:] if len(v) == 6 else np.array([0.0, 0.0, 1.0])
        bottom, clear, retract, feed = expected_hole(v, cycle, name.startswith("clsf"))
        at = np.flatnonzero(path.line == number)
        height = (path.position[at] * 1e3 - v[:3]) @ axis
        aside = path.position[at] * 1e3 - v[:3] - np.outer(height, axis)
        cut = path.kind[at] == CUT
        assert height.min() == pytest.approx(bottom, abs=1e-9) and height[-1] == pytest.approx(retract, abs=1e-9)
        assert np.linalg.norm(aside[np.flatnonzero(height < retract - 1e-9)], axis=1).max() < 1e-9
        assert cut.any() and path.feed[at][cut] * 6e4 == pytest.approx(feed)
        assert not cut[np.diff(height, prepend=height[0]) > 1e-9].any()  # out of the hole in rapid
        before = np.concatenate([[height[0]], height[:-1]])
        assert (before[cut] <= clear + 1e-9).all()  # feeding begins at RAPTO or below
        down = ~cut & (height < clear - 1e-9)  # a rapid into the hole stays over what is drilled
        reached = np.minimum.accumulate(np.where(cut, height, np.inf))
        assert (height[down] > reached[down]).all()
        if "DEEP" in cycle and "PECK" in cycle:
            levels = height[cut]
            assert clear - levels[0] == pytest.approx(5.0) and np.diff(levels)[:-1] == pytest.approx(-2.0)


def mesh(file: Path) -> np.ndarray:
    """Triangles of a binary STL, (N, 3, 3) mm."""
    data = file.read_bytes()
    kind = np.dtype([("normal", "<f4", 3), ("corner", "<f4", (3, 3)), ("more", "<u2")])
    return np.frombuffer(data, kind, int.from_bytes(data[80:84], "little"), 84)["corner"].astype(float)


def inside(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Whether points (N, 3) lie in a closed mesh: an odd number of triangles above them."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    u, v = (b - a)[:, :2], (c - a)[:, :2]
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    flat = np.abs(area) > 1e-9
    a, b, c, u, v, area = (w[flat] for w in (a, b, c, u, v, area))
    found = []
    for p in points:
        d = p[:2] - a[:, :2]
        s = (d[:, 0] * v[:, 1] - d[:, 1] * v[:, 0]) / area
        t = (u[:, 0] * d[:, 1] - u[:, 1] * d[:, 0]) / area
        hit = (s >= 0) & (t >= 0) & (s + t < 1)
        z = a[hit, 2] + s[hit] * (b - a)[hit, 2] + t[hit] * (c - a)[hit, 2]
        found.append(int((z > p[2]).sum()) % 2 == 1)
    return np.array(found)


def section(triangles: np.ndarray, z: float) -> np.ndarray:
    """The outline of a mesh at a height, (N, 2, 2) mm."""
    cut = triangles[(triangles[:, :, 2].min(1) < z) & (triangles[:, :, 2].max(1) > z)]
    lines = []
    for t in cut:
        h = t[:, 2] - z
        ends = [
            t[i, :2] + (t[j, :2] - t[i, :2]) * h[i] / (h[i] - h[j])
            for i, j in ((0, 1), (1, 2), (2, 0))
            if h[i] * h[j] < 0
        ]
        if len(ends) == 2:
            lines.append(ends)
    return np.array(lines).reshape(-1, 2, 2)


def distance(points: np.ndarray, lines: np.ndarray) -> np.ndarray:
    """From points (N, 2) to the nearest of the lines, mm."""
    a, d = lines[:, 0], lines[:, 1] - lines[:, 0]
    size = np.maximum((d * d).sum(1), 1e-30)
    best = np.full(len(points), np.inf)
    for begin in range(0, len(points), 256):
        p = points[begin : begin + 256, None]
        t = np.clip(((p - a) * d).sum(2) / size, 0, 1)
        best[begin : begin + 256] = np.linalg.norm(p - a - t[..., None] * d, axis=2).min(1)
    return best


def cutters(lines: list[str], path: Toolpath) -> tuple[np.ndarray, np.ndarray]:
    """Radius of the cutter in use at each pose, and height of the cone at its tip (0 for mills), mm."""
    at = [(n, figures(line)) for n, line in enumerate(lines) if line.startswith("CUTTER/")]
    used = np.searchsorted([n for n, _ in at], path.line) - 1
    return np.array([v[0] / 2 for _, v in at])[used], np.array([v[3] for _, v in at])[used]


@pytest.mark.parametrize("name", PARTS)
def test_cuts_stay_out_of_the_part(shared: Path, name: str) -> None:
    """The tip of a mill, the shoulder of a drill: 0.02 mm above it along the axis there is no part."""
    lines, path = open_file(shared, f"apt_solidworkscam/{name}.apt", chord=3e-5)
    triangles = mesh(shared / f"data/cam/apt_solidworkscam/{name}.STL")
    cut = np.flatnonzero(path.kind == CUT)
    cut = cut[:: max(len(cut) // 1500, 1)]
    cone = cutters(lines, path)[1]
    tip = (path.position * 1e3 + (0.02 + cone[:, None]) * path.axis)[cut]
    assert not inside(tip + OFF_EDGES, triangles).any()
    # and the test sees a part: sunk by half its height, some of the same cuts are in it
    sunk = tip - (np.ptp(triangles[:, :, 2]) / 2) * path.axis[cut]
    assert inside(sunk + OFF_EDGES, triangles).any()


@pytest.mark.parametrize("name", PARTS)
def test_cuts_keep_a_tool_radius_from_the_walls(shared: Path, name: str) -> None:
    """Also under CUTCOM: the numbers are places of the cutter's centre, so CUTCOM may be read over."""
    lines, path = open_file(shared, f"apt_solidworkscam/{name}.apt", chord=3e-5)
    triangles = mesh(shared / f"data/cam/apt_solidworkscam/{name}.STL")
    low, high = triangles[:, :, 2].min(), triangles[:, :, 2].max()
    sides = [(n, "OFF" not in line) for n, line in enumerate(lines) if line.startswith("CUTCOM")]
    sides = [(0, False), *sides]
    under = np.array([on for _, on in sides])[np.searchsorted([n for n, _ in sides], path.line) - 1]
    (radius, cone), nearest = cutters(lines, path), []
    mill = (path.kind == CUT) & (cone == 0)
    level = np.round(path.position[:, 2] * 1e3 + 0.015 * path.axis[:, 2], 4)  # just above the tip
    for z in np.unique(level[mill]):
        here = np.flatnonzero(mill & (level == z))
        up = path.axis[here[0], 2] > 0
        outline = section(triangles, max(z, low + 0.01) if up else min(z, high - 0.01))
        if len(outline) == 0:  # above the part
            continue
        gap = distance(path.position[here, :2] * 1e3, outline) - radius[here]
        assert gap.min() > -MESH, (z, path.line[here[np.argmin(gap)]])
        nearest += list(gap[under[here]])
    assert np.abs(nearest).min() < 0.05 and np.median(np.abs(nearest)) < MESH  # they do follow the walls


def test_a_cycle_without_off_ends_with_the_operation(shared: Path, tmp_path: Path) -> None:
    """RotateThin.apt lost the CYCLE of three operations with their OFF: how deep they drill is not in the file.

    In RotateThick.apt of the same author each operation has its own. With CYCLE, and still without OFF, it is read.
    """
    file = shared / "data/cam/apt_solidworkscam/RotateThin.apt"
    with pytest.raises(ReadError, match=r"GOTO/146.85,50.,0: no CYCLE/OFF before line 465") as caught:
        read_toolpath(file)
    assert caught.value.line == 467
    lines = file.read_text().splitlines()
    deep = "CYCLE/DEEP2,FEDTO,13.8,1STPECK,5.,SUBPECK,2.,MMPM,102.7,RAPTO,3.,RTRCTO,100."
    for line, cycle in ((486, deep), (479, deep), (466, "CYCLE/DRILL,FEDTO,9.,MMPM,125.680813,RAPTO,3.,RTRCTO,100.")):
        lines.insert(line, cycle)
    mended = tmp_path / "mended.apt"
    mended.write_text("\n".join([*lines, ""]))
    path = read_toolpath(mended)
    assert path.position[path.line == 463][:, 2].min() * 1e3 == pytest.approx(-7.65)
    assert path.position[path.line == 468][:, 2].min() * 1e3 == pytest.approx(-9.0)
    low, high = path.position.min(0) * 1e3, path.position.max(0) * 1e3
    assert low[2] == pytest.approx(-13.8) and high[2] == pytest.approx(103.0)


def test_a_part_turned_over_stays_in_its_coordinates(shared: Path) -> None:
    """Second CSYS of Sacrifice-Board.apt: holes drilled from below meet the mesh of the first setup."""
    _, path = open_file(shared, "apt_solidworkscam/Sacrifice-Board.apt")
    below = path.axis[:, 2] < 0
    assert 0 < below.sum() < len(path) and (np.diff(below.astype(int)) != 0).sum() == 1
    hole = path.position[path.line == 526] * 1e3  # GOTO/390,145,-27.5 with FEDTO 5.4, RAPTO 3, RTRCTO 27.5
    np.testing.assert_allclose(hole[:, 2], [-30.5, -22.1, -55.0], rtol=0, atol=1e-9)
    np.testing.assert_allclose(hole[:, :2], [[390, 145]] * 3, rtol=0, atol=1e-9)


def test_nx_files(shared: Path) -> None:
    _, path = open_file(shared, "clsf_nx/ust_a.cls")
    assert len(path) == 546 and path.kind.sum() == 508 and (path.tool == 2).all()
    assert len(np.unique(path.axis.round(7), axis=0)) == 63  # as data/INDEX.md says
    np.testing.assert_allclose(path.feed[path.kind == CUT], 0.25 / 60, rtol=1e-14)
    _, path = open_file(shared, "clsf_nx/deep_drill.clsf")
    heights = [243, 240, 243, 243, 240, 243]
    np.testing.assert_allclose(
        path.position * 1e3, [[x, 0, z] for x, z in zip([66] * 3 + [-255] * 3, heights, strict=True)]
    )
    np.testing.assert_array_equal(path.kind, [0, 1, 0, 0, 1, 0])
    _, path = open_file(shared, "clsf_nx/cutcom.clsf")
    assert sum(e.word.startswith("CUTCOM/LEFT") for e in path.events) == 35


def test_arcs_under_cutcom_of_nx_cannot_be_outlines(shared: Path) -> None:
    """Their radius is the tool's: an outline so tight has no path of the cutter's centre."""
    lines, _ = open_file(shared, "clsf_nx/cutcom.clsf")
    diameter = float(next(line for line in lines if line.startswith("TLDATA")).split(",")[1])
    arcs = np.array([figures(line) for line in lines if line.startswith("CIRCLE")])
    assert (arcs[:, 6] <= diameter / 2).all() and (arcs[:, 9] == diameter).all()
