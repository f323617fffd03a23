"""What Fusion 360's stock post (apt.cps, 'Common ISO 4343 APT') writes, from moves that this file makes up.

``FusionPost`` spells moves as the JavaScript of the post does: onCircular, onCycle, onCyclePoint, onSection.
"""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from tests.oracles.read_text import ends, read_text
from toolpaths.errors import ReadError
from toolpaths.toolpath import CUT

read = partial(read_text, "part.apt")


class FusionPost:
    """The post; ``flips`` as since 2021: the axis of a clockwise arc is turned over, numbers have a decimal point."""

    def __init__(self, *, flips: bool = True, multax: bool = False) -> None:
        self.flips, self.multax, self.forward = flips, multax, np.array([0.0, 0.0, 1.0])
        self.lines = ["MODE/MILL", "PARTNO/'1001'", "PPRINT/'1001'", "PPRINT/''", "UNITS/MM"]
        self.section(multax=multax, first=True)
        self.lines += ["CUTTER/10., 0., 5., 0., 0., 0., 25.", "LOADTL/3, 0, 40., 3", "SPINDL/12000., RPM, CLW"]

    def f(self, v: float, digits: int = 6) -> str:
        """createFormat({decimals:6, forceDecimal:true}), or the number as JavaScript prints it."""
        if not self.flips:
            return f"{v:.15g}"
        text = f"{v:.{digits}f}".rstrip("0")
        return "0." if text in ("-0.", "0.") else text

    def section(self, *, multax: bool, first: bool = False) -> None:
        if multax != self.multax or first:
            self.lines.append("MULTAX/ON" if multax else "MULTAX/OFF")
        self.multax = multax

    def goto(self, p: np.ndarray) -> None:
        values = [*map(self.f, p), *(self.f(v, 9) for v in self.forward if self.multax)]
        self.lines.append("GOTO/" + ", ".join(values))

    def rapid(self, p: np.ndarray) -> None:
        self.lines.append("RAPID")
        self.goto(p)

    def feed(self, f: float) -> None:
        self.lines.append(f"FEDRAT/{self.f(f)}, MMPM")

    def arc(self, center: np.ndarray, normal: np.ndarray, sweep: float, end: np.ndarray, *, clockwise: bool) -> None:
        """``normal`` is that of the plane; the sweep is above 0."""
        n = -normal if clockwise and self.flips else normal
        radius = self.f(float(np.linalg.norm(np.cross(end - center, normal))))
        numbers = [*map(self.f, center), *map(self.f, n), radius, "ANGLE", self.f(math.degrees(sweep))]
        self.lines.append("MOVARC/" + ", ".join(numbers))
        self.goto(end)

    def cycle(self, kind: str, bottoms: list[np.ndarray], *, depth: float, clearance: float, retract: float,
              feed: float, peck: float = 0.0, dwell: float = 0.0) -> None:  # fmt: skip
        """Clearance and retract are places in the work plane, the points are the bottoms of the holes."""
        step = f"INCR, {self.f(peck)}, " if kind in ("DEEP", "BRKCHP") else ""
        text = f"CYCLE/{kind}, {self.f(depth)}, {step}MMPM, {self.f(feed)}, {self.f(clearance)}"
        text += f", RAPTO, {self.f(clearance - retract)}" if clearance > retract else ""
        text += ", ORIENT, 0" if kind == "BORE" else ""
        self.lines.append(text + (f", DWELL, {self.f(dwell)}" if dwell > 0 else ""))
        for p in bottoms:
            self.feed(feed)
            self.goto(p)
        self.lines.append("CYCLE/OFF")

    def text(self) -> str:
        return "\n".join([*self.lines, "COOLNT/OFF", "END", "FINI", ""])


def turned(p: np.ndarray, center: np.ndarray, n: np.ndarray, angle: float, rise: float = 0.0) -> np.ndarray:
    """Rodrigues."""
    r = p - center
    out = r * math.cos(angle) + np.cross(n, r) * math.sin(angle) + n * np.dot(n, r) * (1 - math.cos(angle))
    return center + out + rise * n


@pytest.mark.parametrize("flips", [True, False])
@pytest.mark.parametrize("degrees", [30.0, 179.0, 181.0, 270.0, 450.0])
@pytest.mark.parametrize("clockwise", [True, False])
def test_arcs_and_helices(tmp_path: Path, flips: bool, degrees: float, clockwise: bool) -> None:
    """Of either sense and either post: every pose on the arc, at its share of the angle."""
    post, n = FusionPost(flips=flips), np.array([0.0, 0.0, 1.0])
    start, center, sweep = np.array([10.0, 3.0, 5.0]), np.array([2.5, -1.25, 5.0]), math.radians(degrees)
    way = -1.0 if clockwise else 1.0
    post.rapid(start)
    post.feed(900.0)
    post.arc(center, n, sweep, turned(start, center, n, way * sweep, -3.0), clockwise=clockwise)
    path = read(tmp_path, post.text())
    share = path.row[1:]
    expected = [turned(start, center, n, way * sweep * s, -3.0 * s) for s in share]
    np.testing.assert_allclose(path.position[1:] * 1e3, expected, rtol=0, atol=2e-6)
    assert len(share) > degrees / 10 and (path.tool == 3).all()
    np.testing.assert_allclose(path.feed[1:] * 6e4, 900.0)


def test_half_circles(tmp_path: Path) -> None:
    """They go as the axis has it in files of the post of today; where the file's axes tell no sense it is refused."""
    center, n, start = np.zeros(3), np.array([0.0, 0.0, 1.0]), np.array([4.0, 0.0, 0.0])
    for clockwise in (True, False):
        post = FusionPost()
        post.rapid(start)
        post.feed(100.0)
        post.arc(center, n, math.pi, -start, clockwise=clockwise)
        middle = read(tmp_path, post.text()).position[1:-1, 1].mean() * 1e3
        assert (middle < -1.0) if clockwise else (middle > 1.0)
    old = FusionPost(flips=False)
    old.rapid(start)
    old.feed(100.0)
    old.arc(center, n, math.pi, -start, clockwise=True)
    with pytest.raises(ReadError, match="which way round is not known: in this file its post told no sense") as caught:
        read(tmp_path, old.text())
    assert old.lines[caught.value.line - 1].startswith("MOVARC")
    half = "MOVARC/0.,0.,0.,0.,0.,1.,4.,ANGLE,180.\nGOTO/-4.,0.,0.\n"
    quarter = "MOVARC/0.,0.,0.,0.,0.,1.,4.,ANGLE,90.\nGOTO/0.,4.,0.\n"
    with pytest.raises(ReadError, match="line 5 turns against its axis") as caught:
        read(tmp_path, f"UNITS/MM\nGOTO/4.,0.,0.\n{half}{quarter}FINI\n")
    assert caught.value.line == 3


@pytest.mark.parametrize("kind", ["DRILL", "REAM", "BORE", "DEEP", "BRKCHP"])
def test_the_point_of_a_cycle_is_the_bottom(tmp_path: Path, kind: str) -> None:
    post = FusionPost()
    post.rapid(np.array([0.0, 0.0, 15.0]))
    holes = [np.array([x, 5.0, -12.0]) for x in (0.0, 20.0)]
    post.cycle(kind, holes, depth=12.0, clearance=15.0, retract=4.0, feed=250.0, peck=5.0, dwell=0.5)
    path = read(tmp_path, post.text())
    z = path.position[:, 2] * 1e3
    assert z.min() == pytest.approx(-12.0) and z.max() == pytest.approx(15.0)
    cuts = np.flatnonzero(path.kind == CUT)
    above = z[cuts - 1]
    assert above.max() == pytest.approx(4.0)  # feeding begins at the retract plane
    assert (path.position[path.kind != CUT, 2] * 1e3 > 3.99).all() or kind in ("DEEP", "BRKCHP")
    np.testing.assert_allclose(path.feed[cuts] * 6e4, 250.0)
    pecks = [-1, -6, -11, -12] if kind in ("DEEP", "BRKCHP") else [-12]
    np.testing.assert_allclose(np.unique(z[cuts][z[cuts] < 3.9]), sorted(pecks), atol=1e-9)


def test_a_cycle_along_a_tilted_axis(tmp_path: Path) -> None:
    """Points in the work coordinates, heights along the axis of the work plane from their origin."""
    post = FusionPost(multax=True)
    post.forward = np.array([0.0, -0.6, 0.8])
    bottom = np.array([7.0, 1.0, 2.0])
    height = float(bottom @ post.forward)
    post.rapid(bottom + 40.0 * post.forward)
    post.cycle("DRILL", [bottom], depth=6.0, clearance=height + 30.0, retract=height + 8.0, feed=90.0)
    post.section(multax=False)
    post.forward = np.array([0.0, 0.0, 1.0])
    post.rapid(np.array([0.0, 0.0, 50.0]))
    path = read(tmp_path, post.text())
    np.testing.assert_allclose(path.axis[:-1], np.tile([0.0, -0.6, 0.8], (len(path) - 1, 1)), atol=1e-9)
    np.testing.assert_array_equal(path.axis[-1], [0, 0, 1])  # MULTAX/OFF: the section is upright
    along = (path.position * 1e3 - bottom) @ np.array([0.0, -0.6, 0.8])
    np.testing.assert_allclose(along[:-1], [40, 8, 0, 30], atol=1e-5)


def test_values_by_place_of_other_posts(tmp_path: Path) -> None:
    """ISO 4343: d and c count from the surface, RAPTO on from c."""
    head = "UNITS/MM\nFROM/0,0,50\n"
    path = read(tmp_path, f"{head}CYCLE/DRILL,10.,MMPM,100.,5.,RAPTO,3.\nGOTO/1,2,-20\nCYCLE/OFF\nFINI\n")
    assert ends(path)[1:].round(9).tolist() == [[1, 2, 50], [1, 2, -18], [1, 2, -30], [1, 2, -15]]
    creo = "CYCLE / DRILL, DEPTH, 10., MMPM, 100., CLEAR, 5., RAPTO, 3., RETURN, 8."
    path = read(tmp_path, f"{head}{creo}\nGOTO/1,2,-20\nCYCLE/OFF\nFINI\n")
    assert ends(path)[1:].round(9).tolist() == [[1, 2, 50], [1, 2, -18], [1, 2, -30], [1, 2, -12]]


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("CYCLE/DRILL, 126., 85., 1., MMPR", "values without words: d, unit, f, c"),
        ("CYCLE/DRILL, 6., MMPM, 85.", "values without words"),
        ("CYCLE/DEEP, 6., INCR, MMPM, 85., 2.", "values without words"),
        ("CYCLE/DRILL, 6., MMPM, 85., 2., TIMES, 3", "TIMES,3: each of DWELL, ORIANT"),
        ("CYCLE/BORE, 6., MMPM, 85., 2., 0.5, ORIENT, 0", "a shift sideways"),
        ("CYCLE/DRILL, 6., MMPM, 85., -2.\nGOTO/0,0,-3.", "feeding begins 1 above the bottom of the hole"),
        ("CUTCOM/ON", "the path may be the part's outline"),
        ("CUTCOM/LEFT, 3", "'in computer'"),
        ("MOVARC/0., 0., 0., 0., 0., 1., 4., ANGLE, 90.\nGOTO/-4., 0., 0.", "ANGLE,90, but the end lies 180 or 180"),
        ("MOVARC/0., 0., 0., 0., 0., 1., 4., TIMES, 90.", "x,y,z,i,j,k,r,ANGLE,a is expected"),
        ("MOVARC/0., 0., 0., 0., 0., 1., 4., ANGLE, 0.", "an angle above 0"),
        ("MODE/TURN", "a lathe's word"),
        ("MODE/INCR", "only MODE/MILL is read"),
    ],
)  # fmt: skip
def test_refused(tmp_path: Path, line: str, words: str) -> None:
    head = "MODE/MILL\nPARTNO/'A'\nUNITS/MM\nCUTTER/10.\nGOTO/4., 0., 0.\n"
    with pytest.raises(ReadError) as caught:
        read(tmp_path, f"{head}{line}\nFINI\n")
    assert words in str(caught.value) and caught.value.line in (6, 7)
