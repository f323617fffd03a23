"""A second reader of SINUMERIK programs, written from the manual by other means: for the tests.

The program becomes Python that is run (loops, conditions and subprograms are Python's); frames are 4 x 4 matrices, and
arcs are found with complex numbers in their plane. It reads what tests/oracles/random_siemens.py writes.
"""

from __future__ import annotations

import cmath
import math
import re
from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from tests.oracles.cnc_moves import Array, CncMove, Curve

WORD = re.compile(
    r'([A-Z][A-Z0-9]*)=("[^"]*"|(?:[^\s()]|\([^()]*\))+)|([A-Z])([-+]?(?:\d+\.?\d*|\.\d+))|([A-Z_][A-Z0-9_]*)(\([^)]*\))?'
)
NAMES = {
    "SIN": lambda a: math.sin(math.radians(a)), "COS": lambda a: math.cos(math.radians(a)), "SQRT": math.sqrt,
    "ABS": abs,
}  # fmt: skip
PLANE = {17: (0, 1, 2), 18: (2, 0, 1), 19: (1, 2, 0)}


def second_reading(text: str) -> list[CncMove]:
    """The moves of a program."""
    code, tool = python_of(text), SecondSiemens()
    exec(code, {"b": tool.block, "R": tool.r, **NAMES})
    return tool.moves


def python_of(text: str) -> str:
    """The program as Python source: a function for each, and a call of the main program."""
    out, depth = ["def MAIN():", "    pass"], 1
    loops: list[str] = []
    for number, raw in enumerate(text.split("\n"), 1):
        line = re.sub(r"^\s*(?:N\d+\s*)?", "", raw.split(";")[0]).strip()
        pad = "    " * depth
        if unit := re.match(r"%_N_(\w+)_(MPF|SPF)", line):
            out += [f"def {'MAIN' if unit[2] == 'MPF' else unit[1]}():", "    pass"]
            depth = 1
        elif found := re.match(r"FOR (R\d+)=(.*) TO (.*)", line):
            name = expression(found[1])
            out += [f"{pad}{name} = {expression(found[2])}", f"{pad}while {name} <= {expression(found[3])}:"]
            depth += 1
            loops.append(name)
        elif line == "ENDFOR":
            out.append(f"{pad}{loops.pop()} += 1")
            depth -= 1
        elif found := re.match(r"(IF|WHILE) (.*)", line):
            out.append(f"{pad}{found[1].lower()} {expression(found[2]).replace('<>', '!=')}:")
            depth += 1
        elif line == "ELSE":
            out.append(f"{'    ' * (depth - 1)}else:")
        elif line in ("ENDIF", "ENDWHILE"):
            depth -= 1
        elif call := re.match(r"(L\d+)(?: P(\d+))?$", line):
            out += [f"{pad}for _ in range({call[2] or 1}): {call[1]}()"]
        elif line in ("M17", "RET"):
            out.append(f"{pad}return")
        elif line:
            out.append(f"{pad}b({number}, {line!r})")
    return "\n".join([*out, "MAIN()"])


def expression(text: str) -> str:
    """With R parameters as a dictionary's."""
    return re.sub(r"\bR(\d+)", r"R[\1]", text)


def matrix(rotation: Rotation | None = None, origin: object = (0, 0, 0)) -> Array:
    out = np.eye(4)
    out[:3, :3] = np.eye(3) if rotation is None else rotation.as_matrix()
    out[:3, 3] = origin
    return out


class SecondSiemens:
    """The machine; ``at`` is in the work object, mm."""

    def __init__(self) -> None:
        self.r: dict[int, float] = {}
        self.moves: list[CncMove] = []
        self.at, self.axis = np.full(3, np.nan), np.array([0.0, 0.0, 1.0])
        self.swivel, self.program = np.eye(4), np.eye(4)
        self.motion, self.plane, self.relative, self.unit = 0, 17, False, 1.0
        self.f, self.feed_mode, self.s, self.tool, self.selected = math.nan, 94, 0.0, 0, 0
        self.heading: Array | None = None
        self.cycle: Callable[[], None] | None = None

    @property
    def frame(self) -> Array:
        return self.swivel @ self.program

    def block(self, line: int, text: str) -> None:
        """One block, in order of effect: modal words, frames, moves."""
        self.line = line
        words: dict[str, float] = {}
        modes: dict[str, str] = {}
        gs, bare, calls = [], [], []
        for name, value, letter, number, word, arguments in WORD.findall(text):
            if letter == "G":
                gs.append(int(number))
            elif letter:
                words[letter] = float(number)
            elif name and re.fullmatch(r"R\d+", name):
                self.r[int(name[1:])] = self.value(value)
            elif name:
                mode = re.fullmatch(r"(AC|IC)\((.*)\)", value)
                words[name] = self.value(mode[2] if mode else value)
                modes[name] = mode[1] if mode else ""
            elif arguments:
                calls.append((word, [self.value(a) if a else 0.0 for a in arguments[1:-1].split(",")]))
            else:
                bare.append(word)
        self.modal(gs, words, bare)
        for word in ("TRANS", "ATRANS", "ROT", "AROT"):
            if word in bare:
                self.turn(word, words)
                return
        if "MCALL" in bare:
            self.cycle = (lambda name=calls[0][0], given=calls[0][1]: self.drill(name, given)) if calls else None
            return
        for name, given in calls:
            self.call(name, given)
        if words.keys() & set("XYZIJK") or "A3" in words or "AR" in words:
            self.move(words, modes)

    def value(self, text: str) -> float:
        return float(eval(expression(text), {"R": self.r, **NAMES})) if not text.startswith('"') else 0.0

    def modal(self, gs: list[int], words: dict[str, float], bare: list[str]) -> None:
        for g in gs:
            if g in (0, 1, 2, 3):
                self.motion = g
            elif g in PLANE:
                self.plane = g
            elif g in (90, 91):
                self.relative = g == 91
            elif g in (94, 95):
                self.feed_mode, self.f = g, math.nan
            elif g in (700, 710):
                self.unit = 25.4 if g == 700 else 1.0
        for word in bare:
            if word in ("CIP", "CT"):
                self.motion = word
        if 4 not in gs:
            self.f, self.s = words.get("F", self.f), words.get("S", self.s)
        self.selected = int(words.get("T", self.selected))
        if words.get("M") == 6:
            self.tool = self.selected

    def turn(self, word: str, words: dict[str, float]) -> None:
        if "TRANS" in word:
            new = matrix(origin=[words.get(c, 0.0) * self.unit for c in "XYZ"])
        elif "RPL" in words:
            new = matrix(Rotation.from_rotvec(np.eye(3)[PLANE[self.plane][2]] * math.radians(words["RPL"])))
        else:
            new = matrix(Rotation.from_euler("ZYX", [words.get(c, 0.0) for c in "ZYX"], degrees=True))
        self.program = self.program @ new if word[0] == "A" else new
        self.heading = None

    def call(self, name: str, given: list[float]) -> None:
        if name == "CYCLE800":
            v = [*given, *[0.0] * 16]
            order = {57: "XYZ", 27: "ZYX", 39: "ZXY", 64: "ZYZ"}[int(v[3])] if any(given) else "XYZ"
            angles = [*v[7:9], 0.0] if v[3] == 64 else v[7:10]
            shifted = matrix(origin=np.array(v[4:7]) * self.unit)
            new = (
                shifted
                @ matrix(Rotation.from_euler(order, angles, degrees=True))
                @ matrix(origin=np.array(v[10:13]) * self.unit)
            )
            turned = not np.allclose(new[:3, :3], self.frame[:3, :3])
            self.swivel, self.program = (self.swivel @ new if v[2] == 1 else new), np.eye(4)
            self.axis, self.heading = self.swivel[:3, 2], None
            if turned:
                self.at = np.full(3, np.nan)
        elif name.startswith("CYCLE8") and name != "CYCLE832":
            self.drill(name, given)

    def move(self, words: dict[str, float], modes: dict[str, str]) -> None:
        to_local = np.linalg.inv(self.frame)
        local = to_local[:3, :3] @ self.at + to_local[:3, 3]
        end = local.copy()
        for k, c in enumerate("XYZ"):
            if c in words:
                relative = modes.get(c) == "IC" or (self.relative and modes.get(c) != "AC")
                end[k] = words[c] * self.unit + (local[k] if relative else 0.0)
        if "A3" in words:
            vector = self.frame[:3, :3] @ [words["A3"], words.get("B3", 0.0), words.get("C3", 0.0)]
            self.axis = vector / np.linalg.norm(vector)
        curve = None
        if self.motion not in (0, 1):
            curve, end = self.arc(local, end, words, modes)
        self.go(end, math.nan if self.motion == 0 else self.rate(), curve)
        if self.cycle:
            self.cycle()

    def rate(self) -> float:
        per = self.f * self.unit
        return per * self.s if self.feed_mode == 95 else per

    def go(self, end: Array, feed: float, curve: Curve | None = None) -> None:
        """To a place of the frame in force."""
        f = self.frame
        if curve is not None:
            curve = Curve(f[:3, :3] @ curve.center + f[:3, 3], f[:3, :3] @ curve.axis, curve.sweep)
        place = f[:3, :3] @ end + f[:3, 3]
        if np.isfinite(place).all():
            self.moves.append(CncMove(place, self.axis, feed, self.tool, self.line, curve))
        if curve is None:
            self.heading = f[:3, :3].T @ (place - self.at)
        else:
            self.heading = f[:3, :3].T @ (np.cross(curve.axis, place - curve.center) * np.sign(curve.sweep))
        self.at = place

    def arc(self, local: Array, end: Array, words: dict[str, float], modes: dict[str, str]) -> tuple[Curve, Array]:
        u, v, w = PLANE[self.plane]
        if self.motion == "CIP":
            via = local.copy()
            for k, name in enumerate(("I1", "J1", "K1")):
                if name in words:
                    relative = modes.get(name) == "IC" or (self.relative and modes.get(name) != "AC")
                    via[k] = words[name] * self.unit + (local[k] if relative else 0.0)
            return through(local, via, end), end
        start, stop = complex(local[u], local[v]), complex(end[u], end[v])
        sign = -1.0 if self.motion == 2 else 1.0
        if self.motion == "CT":
            along = complex(self.heading[u], self.heading[v])
            side = 1j * along / abs(along)
            center = start + side * abs(stop - start) ** 2 / (2 * ((stop - start) * side.conjugate()).real)
            sign = 1.0 if ((center - start) / side).real > 0 else -1.0
        elif "CR" in words:
            radius = abs(words["CR"]) * self.unit
            half = abs(stop - start) / 2
            off = 1j * (stop - start) / abs(stop - start) * math.sqrt(max(radius**2 - half**2, 0.0))
            both = [(start + stop) / 2 + off, (start + stop) / 2 - off]
            center = min(both, key=lambda c: swept(c, start, stop, sign) * np.sign(words["CR"]))
        elif "I" in words or "J" in words or "K" in words:
            place = [
                words.get("IJK"[k], 0.0) * self.unit + (0.0 if modes.get("IJK"[k]) == "AC" else local[k])
                for k in (u, v)
            ]
            center = complex(*place)
            if "AR" in words:
                stop = center + (start - center) * cmath.exp(1j * sign * math.radians(words["AR"]))
                end = end.copy()
                end[u], end[v] = stop.real, stop.imag
        else:
            center = start + (stop - start) / (1 - cmath.exp(1j * sign * math.radians(words["AR"])))
        sweep = sign * (swept(center, start, stop, sign) + math.tau * words.get("TURN", 0.0))
        place3 = local.copy()
        place3[u], place3[v] = center.real, center.imag
        return Curve(place3, np.eye(3)[w], sweep), end

    def drill(self, name: str, given: list[float]) -> None:
        """A hole at the place where the tool is."""
        rtp, rfp, sdis, dp, dpr = [v * self.unit for v in [*given, 0.0, 0.0][:5]]
        bottom = rfp - dpr if dpr else dp
        top, w = rfp + sdis, PLANE[self.plane][2]
        steps: list[tuple[float, bool]] = [(top, False)]
        if name == "CYCLE83":
            v = [*given, *[0.0] * 12]
            first = (v[6] * self.unit) or (rfp - v[5] * self.unit)
            depths = pecks(rfp - bottom, first, v[7] * (self.unit if v[7] > 0 else 1.0))
            for k, depth in enumerate(depths):
                if k and v[11]:
                    near = 0.6 if rfp - bottom <= 30 else min((rfp - bottom) / 50, 7.0)
                    steps += [(top, False), (min(rfp - depths[k - 1] + near, top), False)]
                elif k:
                    steps.append((rfp - depths[k - 1] + 1.0, True))
                steps.append((rfp - depth, True))
        else:
            steps.append((bottom, True))
        if name == "CYCLE89":
            steps.append((top, True))
        for height, cut in [*steps, (rtp, False)]:
            to_local = np.linalg.inv(self.frame)
            place = to_local[:3, :3] @ self.at + to_local[:3, 3]
            if abs(place[w] - height) > 1e-9:
                place[w] = height
                self.go(place, self.rate() if cut else math.nan)


def swept(center: complex, start: complex, stop: complex, sign: float) -> float:
    """rad, above 0, the whole circle where it ends at its start."""
    angle = (sign * cmath.phase((stop - center) / (start - center))) % math.tau
    return math.tau if angle < 1e-6 or math.tau - angle < 1e-9 else angle


def through(start: Array, via: Array, end: Array) -> Curve:
    """The circle of three points, by their distances."""
    axis = np.cross(via - start, end - via)
    axis /= np.linalg.norm(axis)
    rows = np.array([via - start, end - start, axis])
    values = [(via @ via - start @ start) / 2, (end @ end - start @ start) / 2, axis @ start]
    center = np.linalg.solve(rows, values)
    a, b = start - center, end - center
    return Curve(center, axis, math.atan2(axis @ np.cross(a, b), a @ b) % math.tau)


def pecks(depth: float, first: float, less: float) -> list[float]:
    """Depths that CYCLE83 drills to: amount of degression above 0, factor below, 0: all strokes alike."""
    out, step = [min(first, depth)], first
    while depth - out[-1] > 1e-9:
        left = depth - out[-1]
        if less > 0:
            step = step - less if step - less > less else less
            last = step == less and step < left < 2 * less
            out.append(out[-1] + (left / 2 if last else min(step, left)))
        else:
            step = step * -less if less else step
            out.append(out[-1] + min(step, left))
    return out
