"""A second reader of APT/CL and CLSF that is plain, slow and written from the conventions.

Conventions: ISO 4343 (GOTO, GODLTA, RAPID, FEDRAT, CYCLE), NX CLSF (MSYS, clockwise CIRCLE, FEDTO as a height).
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np

INCH = {"IPM": 25.4, "IPR": 25.4, "MMPM": 1.0, "MMPR": 1.0}


@dataclass
class Corner:
    """A place where the program names the tool: file units, feed in file units a minute."""

    xyz: np.ndarray
    axis: np.ndarray
    rapid: bool
    feed: float
    tool: int
    rpm: float
    sense: int
    arc: tuple[np.ndarray, np.ndarray, float] | None = None  # centre, normal, sweep rad


@dataclass
class Second:
    """The second reader: a list of corners, all in the first MSYS."""

    unit: float = 1.0
    corners: list[Corner] = field(default_factory=list)
    axis: np.ndarray = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    tool: int = 0
    rpm: float = float("nan")
    sense: int = 0
    stands: bool = False
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
        rpm = 0.0 if self.stands else self.rpm
        self.corners.append(Corner(xyz, axis, rapid, float("nan") if rapid else value, self.tool, rpm, self.sense))

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
            before = self.turns - 1 if self.turns % 1 == 0 else round(self.turns - sweep / 2 / np.pi)
            sweep += 2 * np.pi * before
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
            self.rpm = float(v[0]) if len(v) else self.rpm
            self.sense = {"CLW": 1, "CCLW": -1}.get(words[-1], self.sense)
            self.stands = "OFF" in words
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
