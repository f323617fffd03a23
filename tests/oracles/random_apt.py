"""Random APT/CL and CLSF programs."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation


class RandomApt:
    """A random program: NX or the dialect of SolidWorks CAM."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.nx = bool(seed % 2)
        self.inch = bool(self.rng.integers(2))
        self.lines: list[str] = []
        self.at: np.ndarray | None = None  # in the frame in force
        self.axis = np.array([0.0, 0.0, 1.0])
        self.stopped = False

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
        whole = bool(self.rng.integers(2))  # as NX has it: whole turns before the rest, and one
        times = ["TIMES", float(turns) if whole else turns - 1 + angle / 2 / np.pi] if turns else []
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
            self.put("SPINDL", "RPM", float(self.rng.integers(100, 9000)), "CLW" if self.rng.integers(2) else "CCLW")
        elif self.stopped:
            self.put("SPINDL", "ON")
        elif self.rng.integers(4) == 0 and feed[1].endswith("M"):
            self.put("SPINDL", "OFF")
            self.stopped = True
            return
        self.stopped = False
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
