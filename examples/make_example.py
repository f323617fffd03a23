"""Make examples/wave.nc: the finishing of a wave-shaped block, as a CAM system would post it.

    python examples/make_example.py [-o FILE]        needs the extra `example` (opencamlib)

The part is a block of 200 x 150 mm whose top is a wave; the zero point is its lower left corner, z = 0
the top of the raw block. opencamlib drops a ball cutter on a mesh of the surface along parallel lines;
lines turn into each other by helical half circles, cuts start and end on tangent arcs off the part. Then
two passes run around the block with rounded corners. The same call writes the same bytes.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import numpy as np
import opencamlib as ocl
import trimesh

SIZE_X, SIZE_Y = 200.0, 150.0  # mm, the block
RUN_OUT = 14.0  # mm that a line goes on past the block, so that it turns off the part
MARGIN = RUN_OUT + 10.0  # mm of surface beyond the block, for the cutter to rest on
GRID = 2.0  # mm between mesh points
CUTTER = 12.0  # mm, diameter of the ball cutter
STEPOVER = 3.0  # mm between lines
SAMPLING = 1.0  # mm between drops along a line
TOLERANCE = 0.008  # mm between the drops and the lines through the points kept
CLEARANCE = 20.0  # mm
LEAD = 5.0  # mm, radius of the arcs that lead in and out
CORNER = 10.0  # mm, radius of the block's corners
SIDE_DEPTHS = (-22.0, -30.0)  # mm, tip of the cutter on the passes around the block
SPEED, CUT, PLUNGE = 12000, 2400, 800  # 1/min, mm/min, mm/min

Point = tuple[float, float, float]


def height(x: float, y: float) -> float:
    """Height of the surface in mm at (x, y) in mm."""
    wave = 5.0 * math.cos(2 * math.pi * x / 110.0) * math.cos(2 * math.pi * y / 170.0)
    return wave - 9.0 - 3.0 * ((y - SIZE_Y / 2) / SIZE_Y) ** 2


def surface() -> trimesh.Trimesh:
    """Mesh of the surface, block and margin; heights on a grid of 1 nm, so that no libm shows."""
    xs = np.linspace(-MARGIN, SIZE_X + MARGIN, round((SIZE_X + 2 * MARGIN) / GRID) + 1)
    ys = np.linspace(-MARGIN, SIZE_Y + MARGIN, round((SIZE_Y + 2 * MARGIN) / GRID) + 1)
    vertices = [(x, y, round(height(x, y), 6)) for x in xs for y in ys]
    rows, n = range(len(xs) - 1), len(ys)
    corners = [(i * n + j, (i + 1) * n + j) for i in rows for j in range(n - 1)]
    faces = [f for a, b in corners for f in ((a, b, b + 1), (a, b + 1, a + 1))]
    return trimesh.Trimesh(vertices, faces, process=False)


def to_opencamlib(mesh: trimesh.Trimesh) -> ocl.STLSurf:
    """The same triangles as opencamlib holds them."""
    solid = ocl.STLSurf()
    for triangle in mesh.triangles:
        solid.addTriangle(ocl.Triangle(*(ocl.Point(*map(float, p)) for p in triangle)))
    return solid


def dropped_lines(solid: ocl.STLSurf) -> list[list[Point]]:
    """Tips of the ball cutter, line by line in the direction of machining, thinned to TOLERANCE."""
    count = round(SIZE_Y / STEPOVER) + 1
    path = ocl.Path()
    for y in (k * STEPOVER for k in range(count)):
        path.append(ocl.Line(ocl.Point(-RUN_OUT, y, 0.0), ocl.Point(SIZE_X + RUN_OUT, y, 0.0)))
    drop = ocl.PathDropCutter()
    drop.setSTL(solid)
    drop.setCutter(ocl.BallCutter(CUTTER, 50.0))
    drop.setZ(-50.0)
    drop.setSampling(SAMPLING)
    drop.setPath(path)
    drop.run()
    points = drop.getCLPoints()
    lines = [thinned([p for p in points if round(p.y / STEPOVER) == k]) for k in range(count)]
    return [line[:: 1 if k % 2 == 0 else -1] for k, line in enumerate(lines)]


def thinned(points: list[ocl.CLPoint]) -> list[Point]:
    """The points that are needed for a polyline within TOLERANCE of all of them."""
    thin = ocl.LineCLFilter()
    thin.setTolerance(TOLERANCE)
    for p in points:
        thin.addCLPoint(p)
    thin.run()
    return [(p.x, p.y, p.z) for p in thin.getCLPoints()]


class Post:
    """Writes moves as modal G-code: only the words that change."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self._motion = self._feed = ""
        self._plane = "G17"  # as the head of the program says
        self._at: dict[str, str] = {}

    def text(self, *lines: str) -> None:
        self.lines += lines

    def move(self, motion: str, to: dict[str, float], feed: float | None = None, extra: str = "") -> None:
        """A move; ``to`` in mm by axis letter, ``extra`` the words of an arc's centre."""
        printed = {axis: number(value) for axis, value in to.items()}
        words = [axis + text for axis, text in printed.items() if extra or self._at.get(axis) != text]
        if not words:
            return
        self._at.update(printed)
        if motion != self._motion:
            self._motion = motion
            words.insert(0, motion)
        if extra:
            words.append(extra)
        if feed is not None and number(feed) != self._feed:
            self._feed = number(feed)
            words.append("F" + self._feed)
        self.lines.append(" ".join(words))

    def arc(self, plane: str, motion: str, end: dict[str, float], centre: str, feed: float = CUT) -> None:
        """An arc with its centre as offsets from where it starts."""
        if plane != self._plane:
            self._plane = plane
            self.lines.append(plane)
        self.move(motion, end, feed, centre)


def number(value: float) -> str:
    """mm to three decimals without trailing zeros, never -0."""
    return f"{round(value, 3) + 0.0:.3f}".rstrip("0").rstrip(".")


def finish_top(post: Post, solid: ocl.STLSurf) -> None:
    """Parallel lines over the surface, there and back."""
    post.text("", "(PARALLEL FINISHING)")
    lines = dropped_lines(solid)
    x, y, z = lines[0][0]
    post.move("G0", {"X": x - LEAD, "Y": y})
    post.move("G0", {"Z": CLEARANCE})
    post.move("G1", {"Z": z + LEAD}, PLUNGE)
    post.arc("G18", "G2", {"X": x, "Z": z}, f"I{number(LEAD)} K0", PLUNGE)
    for k, line in enumerate(lines):
        for x, y, z in line[1:]:
            post.move("G1", {"X": x, "Y": y, "Z": z}, CUT)
        if k + 1 < len(lines):
            x, y, z = lines[k + 1][0]
            turn = "G3" if k % 2 == 0 else "G2"
            post.arc("G17", turn, {"X": x, "Y": y, "Z": z}, f"I0 J{number(STEPOVER / 2)}")
    x, y, z = lines[-1][-1]
    way, turn = (1, "G2") if len(lines) % 2 else (-1, "G3")
    post.arc("G18", turn, {"X": x + way * LEAD, "Z": z + LEAD}, f"I0 K{number(LEAD)}")
    post.move("G0", {"Z": CLEARANCE})


def finish_sides(post: Post) -> None:
    """Around the block clockwise (climb milling), a pass at each depth."""
    post.text("", "(CONTOUR)")
    r = CUTTER / 2
    left, right, low, high = -r, SIZE_X + r, -r, SIZE_Y + r
    turn, middle = CORNER + r, SIZE_Y / 2
    for depth in SIDE_DEPTHS:
        post.move("G0", {"X": left - LEAD - r, "Y": middle - LEAD})
        post.move("G0", {"Z": 5.0})
        post.move("G1", {"Z": depth}, PLUNGE)
        post.move("G1", {"X": left - LEAD}, CUT)
        post.arc("G17", "G3", {"X": left, "Y": middle}, f"I0 J{number(LEAD)}")
        # G3 about a centre straight above ends at its right, heading along +y: tangent to the left side
        corners = (
            ({"X": left, "Y": high - turn}, {"X": left + turn, "Y": high}, f"I{number(turn)} J0"),
            ({"X": right - turn, "Y": high}, {"X": right, "Y": high - turn}, f"I0 J{number(-turn)}"),
            ({"X": right, "Y": low + turn}, {"X": right - turn, "Y": low}, f"I{number(-turn)} J0"),
            ({"X": left + turn, "Y": low}, {"X": left, "Y": low + turn}, f"I0 J{number(turn)}"),
        )
        for start, end, centre in corners:
            post.move("G1", start, CUT)
            post.arc("G17", "G2", end, centre)
        post.move("G1", {"X": left, "Y": middle}, CUT)
        post.arc("G17", "G3", {"X": left - LEAD, "Y": middle + LEAD}, f"I{number(-LEAD)} J0")
        post.move("G0", {"Z": CLEARANCE})


def program() -> str:
    """The whole file."""
    post = Post()
    post.text(
        "(WAVE)",
        "(made by examples/make_example.py, BSD-3-Clause)",
        f"(T1 D={number(CUTTER)} CR={number(CUTTER / 2)} - ball end mill)",
        "G90 G94 G17",
        "G21",
        "T1 M6",
        f"S{SPEED} M3",
        "G54",
    )
    finish_top(post, to_opencamlib(surface()))
    finish_sides(post)
    post.text("", "M5", "M30")
    return "\n".join(post.lines) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description="make examples/wave.nc")
    parser.add_argument("-o", "--output", type=Path, default=Path(__file__).with_name("wave.nc"))
    parser.parse_args().output.write_text(program(), encoding="ascii", newline="\n")


if __name__ == "__main__":
    main()
