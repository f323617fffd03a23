"""Random APT/CL and CLSF programs, read also by a second reader that is plain, slow and written from the conventions.

Conventions: ISO 4343 (GOTO, GODLTA, RAPID, FEDRAT, CYCLE), NX CLSF (MSYS, clockwise CIRCLE, FEDTO as a height).
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from toolpaths.files import read_toolpath

INCH = {"IPM": 25.4, "IPR": 25.4, "MMPM": 1.0, "MMPR": 1.0}
PROGRAMS = 150


@dataclass
class Corner:
    """A place where the program names the tool: file units, feed in file units a minute."""

    xyz: np.ndarray
    axis: np.ndarray
    rapid: bool
    feed: float
    tool: int
    arc: tuple[np.ndarray, np.ndarray, float] | None = None  # centre, normal, sweep rad


@dataclass
class Second:
    """The second reader: a list of corners, all in the first MSYS."""

    unit: float = 1.0
    corners: list[Corner] = field(default_factory=list)
    axis: np.ndarray = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    tool: int = 0
    rpm: float = float("nan")
    feed: tuple[float, str] = (float("nan"), "MMPM")
    first: np.ndarray | None = None
    here: np.ndarray = field(default_factory=lambda: np.eye(4))
    rapid: bool = False
    circle: list[float] | None = None
    turns: float | None = None
    cycle: dict[str, float | str] | None = None
    nx: bool = False

    def per_minute(self, value: float, word: str) -> float:
        made = value * INCH[word] / self.unit
        return made * self.rpm if word in ("IPR", "MMPR") else made

    def add(self, xyz: np.ndarray, rapid: bool, feed: float | None = None) -> None:
        value = self.per_minute(*self.feed) if feed is None else feed
        axis = self.here[:3, :3] @ self.axis
        last = self.corners[-1] if self.corners and self.cycle else None
        if last and np.allclose([*last.xyz, *last.axis], [*xyz, *axis], rtol=0, atol=1e-9):
            return  # no move of a cycle goes nowhere
        self.corners.append(Corner(xyz, axis, rapid, float("nan") if rapid else value, self.tool))

    def goto(self, local: np.ndarray) -> None:
        target = (self.here @ np.append(local, 1.0))[:3]
        if self.cycle:
            self.hole(target)
            return
        start = self.corners[-1].xyz if self.corners else None
        self.add(target, self.rapid)
        if self.circle and start is not None:
            self.corners[-1].arc = self.arc(start, target)
        self.rapid, self.circle, self.turns = False, None, None

    def arc(self, start: np.ndarray, end: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
        v = np.array(self.circle)
        center, normal = (self.here @ np.append(v[:3], 1.0))[:3], self.here[:3, :3] @ v[3:6]
        # the angle of both ends in a plane basis, the x direction through the start
        ex = start - center - normal * np.dot(start - center, normal)
        ex /= np.linalg.norm(ex)
        ey = np.cross(normal, ex)
        angle = np.arctan2(np.dot(end - center, ey), np.dot(end - center, ex))
        way = -1.0 if len(v) == 11 else 1.0
        sweep = way * angle % (2 * np.pi)
        sweep = 2 * np.pi if sweep < 1e-6 or sweep > 2 * np.pi - 1e-9 else sweep
        if self.turns:
            sweep += 2 * np.pi * round(self.turns - sweep / 2 / np.pi)
        return center, normal, way * sweep

    def hole(self, p: np.ndarray) -> None:
        c = self.cycle or {}
        a = self.here[:3, :3] @ self.axis
        depth = -float(c["FEDTO"]) if self.nx else float(c["FEDTO"])
        clear = float(c["RAPTO"])
        up = max(clear, float(c.get("RTRCTO", clear)))
        word = next(w for w in INCH if w in c)
        feed = self.per_minute(float(c[word]), word)
        last = self.corners[-1] if self.corners else None
        if last is not None and np.allclose(last.axis, a, atol=1e-9):
            over = float(np.dot(last.xyz - p, a))
            if over < up:  # out of the way, along the tool
                self.add(last.xyz + (up - over) * a, True)
            self.add(p + max(over, up) * a, True)
        else:
            self.add(p + up * a, True)
        self.add(p + clear * a, True)
        reached, step = 0.0, float(c.get("1STPECK", c.get("INCR", c.get("STEP", 1e99))))
        total = clear + depth
        while total - reached > 1e-9 or reached == 0.0:
            if reached:
                back = 0.1 * float(c.get("SUBPECK", c.get("INCR", c.get("STEP", 0.0))))
                if c["kind"] == "DEEP":
                    self.add(p + clear * a, True)
                self.add(p + min(clear - reached + back, clear) * a, True)
            reached = min(reached + step, total) if c["kind"] in ("DEEP", "BRKCHP") else total
            step = float(c.get("SUBPECK", step))
            self.add(p + (clear - reached) * a, False, feed)
            if total == 0.0:
                break
        if c["kind"] == "BORE":
            self.add(p + clear * a, False, feed)
        self.add(p + up * a, True)

    def read(self, text: str) -> list[Corner]:
        text = re.sub(r"\$\$[^\n]*", "", text)
        text = re.sub(r"\$\s*\n", "", text).upper()
        for line in text.split("\n"):
            head, _, rest = line.partition("/")
            words = [w.strip() for w in rest.split(",")] if rest.strip() else []
            self.statement(re.sub(r"\s+", " ", head.strip()), words)
        return self.corners

    def statement(self, head: str, words: list[str]) -> None:
        plain = [w for w in words if re.fullmatch(r"[-+]?[\d.]+(?:[ED][-+]?\d+)?", w)]
        v = np.array([float(w.replace("D", "E")) for w in plain])
        if head in ("GOTO", "FROM", "GOHOME"):
            self.rapid = self.rapid or head != "GOTO"
            self.axis = v[3:] if len(v) == 6 else self.axis
            self.goto(v[:3])
        elif head == "GODLTA":
            back = np.linalg.inv(self.here) @ np.append(self.corners[-1].xyz, 1.0)
            self.goto(back[:3] + (v if len(v) == 3 else v[0] * self.axis))
        elif head == "RAPID":
            self.rapid = True
        elif head == "CIRCLE":
            self.turns = float(v[-1]) if "TIMES" in words else None
            self.circle = list(v[:-1]) if "TIMES" in words else list(v)
        elif head == "FEDRAT":
            self.feed = (float(v[0]), next(w for w in words if w in INCH))
        elif head == "SPINDL":
            self.rpm = float(v[0])
        elif head in ("LOADTL", "LOAD"):
            self.tool = int(v[0])
        elif head == "UNITS":
            self.unit = 25.4 if words == ["INCHES"] else 1.0
        elif head == "TOOL PATH":
            self.nx = True
        elif head == "MSYS":
            m = np.eye(4)
            m[:3, 3], m[:3, 0], m[:3, 1], m[:3, 2] = v[:3], v[3:6], v[6:9], np.cross(v[3:6], v[6:9])
            self.first = m if self.first is None else self.first
            self.here = np.linalg.inv(self.first) @ m
        elif head == "CYCLE":
            self.cycle = None if words[0] in ("OFF", "INIT") else self.cycle_words(words)

    @staticmethod
    def cycle_words(words: list[str]) -> dict[str, float | str]:
        kind = words[1] if words[0] == "DRILL" and words[1] in ("DEEP", "BRKCHP") else words[0]
        rest = words[2:] if kind != words[0] else words[1:]
        kind = {"DEEP2": "DEEP", "REAM": "BORE"}.get(kind, kind)
        return {"kind": kind} | {k: float(n.replace("D", "E")) for k, n in zip(rest[::2], rest[1::2], strict=True)}


class Writer:
    """A random program: NX or the dialect of SolidWorks CAM."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.nx = bool(seed % 2)
        self.inch = bool(self.rng.integers(2))
        self.lines: list[str] = []
        self.at: np.ndarray | None = None  # in the frame in force
        self.axis = np.array([0.0, 0.0, 1.0])

    def put(self, head: str, *values: object) -> None:
        """A statement with random dress: spaces, lower case, exponents, a continued line."""
        parts = [self.figure(v) if isinstance(v, float) else str(v) for v in values]
        dress = self.rng.integers(6)
        text = (
            (" / " if dress == 1 else "/").join([head, (" , " if dress == 1 else ",").join(parts)]) if parts else head
        )
        text = text.lower() if dress == 2 else text
        if dress == 3 and len(parts) > 2:
            at = text.rindex(",") + 1
            text = text[:at] + "$\n   " + text[at:]
        self.lines.append(text + ("  $$ why not" if dress == 4 else ""))

    def figure(self, v: float) -> str:
        text = f"{v:.14f}"
        return text.rstrip("0") if self.rng.integers(2) else f"{v:.14E}".replace("E", "D") if v > 1 else text

    def vector(self, size: float) -> np.ndarray:
        return np.round(self.rng.uniform(-size, size, 3), 4)

    def unit(self) -> np.ndarray:
        v = self.rng.normal(size=3)
        return v / np.linalg.norm(v)

    def goto(self, end: np.ndarray, head: str = "GOTO") -> None:
        if self.rng.integers(4) == 0 and (head == "GOTO"):
            self.axis = self.unit()
            self.put(head, *map(float, end), *map(float, self.axis))
        else:
            self.put(head, *map(float, end))
        self.at = end

    def move(self) -> None:
        kind = self.rng.integers(7)
        if self.at is None:
            self.goto(self.vector(50), "FROM" if kind == 0 else "GOTO")
        elif kind == 0:
            self.put("RAPID" if self.nx else "RAPID/")
            self.goto(self.vector(50))
        elif kind == 1:
            delta = self.vector(5)
            self.put("GODLTA", *map(float, delta))
            self.at = None if self.at is None else self.at + delta
        elif kind == 2:
            self.put("GODLTA", float(d := np.round(self.rng.uniform(-3, 3), 4)))
            self.at = self.at + d * self.axis
        elif kind in (3, 4):
            self.arc(self.at)
        else:
            self.goto(self.vector(50))

    def arc(self, start: np.ndarray) -> None:
        normal, radius = self.unit(), float(self.rng.uniform(0.5, 40))
        side = np.cross(normal, self.unit())
        center = start + radius * side / np.linalg.norm(side)
        full = self.rng.integers(4) == 0
        angle = 2 * np.pi if full else float(self.rng.uniform(0.01, 6.2))
        way = -1.0 if self.nx else 1.0
        rise = float(self.rng.choice([0.0, 3.0]))
        end = center + Rotation.from_rotvec(way * angle * normal).apply(start - center) + rise * normal
        turns = int(self.rng.integers(1, 4)) if self.rng.integers(3) == 0 else 0
        more = [radius, 0.06, 0.5, 12.0, 1.0] if self.nx else [radius] * int(self.rng.integers(2))
        times = ["TIMES", turns - 1 + angle / 2 / np.pi] if turns else []
        self.put("CIRCLE", *map(float, center), *map(float, normal), *more, *times)
        self.put("GOTO", *map(float, end))
        self.at = end

    def drill(self) -> None:
        depth, clear = float(np.round(self.rng.uniform(0.5, 20), 3)), float(np.round(self.rng.uniform(0.1, 5), 3))
        kind = str(self.rng.choice(["DRILL", "DEEP", "BRKCHP", "BORE", "CSINK", "REAM"]))
        words: list[object] = ["DRILL", kind] if self.nx and kind in ("DEEP", "BRKCHP") else [kind]
        words += ["FEDTO", -depth if self.nx else depth, "IPM" if self.inch else "MMPM", 33.5, "RAPTO", clear]
        if kind in ("DEEP", "BRKCHP") and self.rng.integers(3):
            words += ["STEP" if self.nx else "INCR", float(np.round(self.rng.uniform(0.7, 4), 3))]
        elif kind == "DEEP" and not self.nx:
            words = ["DEEP2", *words[1:], "1STPECK", 2.5, "SUBPECK", 1.25]
        if self.rng.integers(2):
            words += ["RTRCTO", float(np.round(self.rng.uniform(3, 30), 3))]
        self.put("CYCLE", *words)
        for _ in range(int(self.rng.integers(1, 4))):
            self.goto(self.vector(50))
        self.put("CYCLE", "OFF")
        self.at = None

    def frame(self) -> None:
        m = Rotation.random(random_state=int(self.rng.integers(1 << 30))).as_matrix()
        self.put("MSYS", *map(float, self.vector(100)), *map(float, m[:, 0]), *map(float, m[:, 1]))
        self.at = None
        self.axis = self.unit()
        self.put("GOTO", *map(float, self.vector(50)), *map(float, self.axis))

    def other(self) -> None:
        unit = "IP" if self.inch else "MMP"
        feed = [float(np.round(self.rng.uniform(0.1, 900), 3)), unit + str(self.rng.choice(["M", "R"]))]
        self.put("FEDRAT", *(feed[::-1] if self.nx else feed))
        if self.rng.integers(3) == 0:
            self.put(*(("LOAD", "TOOL") if self.nx else ("LOADTL",)), int(self.rng.integers(1, 90)))
        if self.rng.integers(3) == 0:
            self.put("SPINDL", "RPM", float(self.rng.integers(100, 9000)), "CLW")
        self.put("PAINT", "COLOR", 31)

    def text(self) -> str:
        self.put("SPINDL", 1200.0, "RPM", "CLW")
        self.put("UNITS", "INCHES" if self.inch else "MM")
        if self.nx:
            self.put("TOOL PATH", "OP", "TOOL", "MILL")
            self.frame()
        self.other()
        for _ in range(int(self.rng.integers(5, 40))):
            kind = self.rng.integers(12)
            if kind == 0:
                self.drill()
            elif kind == 1:
                self.other()
            elif kind == 2 and self.nx:
                self.frame()
            elif self.at is None:
                self.goto(self.vector(50))
            else:
                self.move()
        self.goto(self.vector(50))
        return "\n".join([*self.lines, "END-OF-PATH" if self.nx else "FINI", ""])


@pytest.mark.parametrize("part", range(3))
def test_random_programs_agree_with_the_second_reader(tmp_path: Path, part: int) -> None:
    arcs = drilled = 0
    for seed in range(part * PROGRAMS // 3, (part + 1) * PROGRAMS // 3):
        text = Writer(seed).text()
        second = Second()
        corners = second.read(text)
        (tmp_path / "p.cls").write_text(text)
        path = read_toolpath(tmp_path / "p.cls", chord=1e-4)
        unit = second.unit * 1e-3
        at = np.flatnonzero(path.row % 1 == 0)
        assert len(at) == len(corners), (seed, text)
        np.testing.assert_allclose(path.position[at], np.array([c.xyz for c in corners]) * unit, rtol=0, atol=1e-9)
        np.testing.assert_allclose(path.axis[at], [c.axis for c in corners], rtol=0, atol=1e-8)
        np.testing.assert_array_equal(path.kind[at] == 0, [c.rapid for c in corners])
        np.testing.assert_allclose(path.feed[at] * 60, np.array([c.feed for c in corners]) * unit, rtol=1e-9)
        np.testing.assert_array_equal(path.tool[at], [c.tool for c in corners])
        arcs += check_arcs(path.position, path.row, corners, unit)
        drilled += "CYCLE" in text.upper()
    assert arcs > 100 and drilled > 30


def check_arcs(position: np.ndarray, row: np.ndarray, corners: list[Corner], unit: float) -> int:
    """Every pose between two corners lies on the helix of the arc there, or there is none; how many arcs."""
    for number, corner in enumerate(corners):
        inside = np.flatnonzero((row > number - 1) & (row < number))
        if corner.arc is None:
            assert len(inside) == 0
            continue
        center, normal, sweep = corner.arc
        start = corners[number - 1].xyz
        rise = np.dot(corner.xyz - start, normal)
        share = row[inside] - (number - 1)
        turned = Rotation.from_rotvec(np.outer(share * sweep, normal)).apply(start - center)
        expected = (center + turned + np.outer(share * rise, normal)) * unit
        np.testing.assert_allclose(position[inside], expected, rtol=0, atol=2e-8)
        assert len(inside) >= abs(sweep) / (np.pi / 4) - 1
    return sum(c.arc is not None for c in corners)
