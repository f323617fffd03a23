"""A second reader of HEIDENHAIN Klartext, written from the manual by other means: for the tests.

Labels, repeats and jumps unroll the program into a list of blocks while it runs; frames are 4 x 4 matrices, arcs are
found with complex numbers in their plane, corners by the bisector. It reads what random_heidenhain.py writes.
"""

from __future__ import annotations

import cmath
import math
import re
from collections.abc import Iterator

import numpy as np
from scipy.spatial.transform import Rotation

from tests.oracles.cnc_moves import Array, CncMove, Curve
from tests.oracles.siemens_reader import NAMES, matrix, swept

WORD = re.compile(r"(IPA|IPR|PA|PR|I?[XYZ]|[NT][XYZ]|MB|R(?![L])|F|M|S)(MAX| AUTO|[-+]?(?:[\d.]+|Q\d+))|(DR[-+])")
AXES = {"XY": (0, 1, 2), "YZ": (1, 2, 0), "XZ": (2, 0, 1)}


def second_reading(text: str) -> list[CncMove]:
    """The moves of a program."""
    tool = SecondKlartext(25.4 if " INCH" in text.split("\n")[0] else 1.0)
    lines = [re.sub(r"^\s*\d+\s+|;[^~\n]*", "", raw).strip() for raw in text.split("\n")]
    for number, line in unrolled(lines, 0, tool.q):
        tool.block(number + 1, line)
    return tool.moves


def unrolled(lines: list[str], begin: int, q: dict[int, float], stop: int | None = None) -> Iterator[tuple[int, str]]:
    """Blocks in the order in which they run."""
    at = begin
    while at < (len(lines) if stop is None else stop):
        line, first = lines[at], at
        while line.endswith("~"):
            at += 1
            line = f"{line[:-1]} {lines[at]}"
        at += 1
        if call := re.match(r"CALL LBL (\d+)(?: REP ?(\d+))?", line):
            label = next(k for k, other in enumerate(lines) if other == f"LBL {call[1]}")
            if call[2]:
                for _ in range(int(call[2])):
                    yield from unrolled(lines, label, q, first)
            else:
                yield from unrolled(lines, label, q)
        elif jump := re.match(r"FN 1[12]: IF \+Q(\d+) (GT|LT) \+(\S+) GOTO LBL (\d+)", line):
            a, b = q[int(jump[1])], float(jump[3])
            if a > b if jump[2] == "GT" else a < b:
                at = next(k for k, other in enumerate(lines) if other == f"LBL {jump[4]}")
        elif line == "LBL 0" or line.startswith("END PGM"):
            return
        elif "M30" in line:
            yield first, line
            return
        else:
            yield first, line


class SecondKlartext:
    """The machine; ``at`` is in the work object, mm."""

    def __init__(self, unit: float) -> None:
        self.unit, self.q = unit, {}
        self.moves: list[CncMove] = []
        self.at, self.axis = np.full(3, np.nan), np.array([0.0, 0.0, 1.0])
        self.before, self.tilt, self.behind, self.turn = np.eye(4), np.eye(4), np.eye(4), 0.0
        self.f, self.automatic, self.tool, self.pole, self.plane = math.nan, math.nan, 0, 0j, (0, 1, 2)
        self.heading: Array | None = None
        self.corner: tuple[str, float, float, int] | None = None
        self.cycle: tuple[int, dict[int, float]] | None = None
        self.modal = False

    @property
    def frame(self) -> Array:
        return self.before @ self.tilt @ self.behind @ matrix(Rotation.from_euler("z", self.turn, degrees=True))

    def local(self) -> Array:
        inverse = np.linalg.inv(self.frame)
        return inverse[:3, :3] @ self.at + inverse[:3, 3]

    def block(self, line: int, text: str) -> None:
        """One block."""
        self.line = line
        kind, _, rest = text.partition(" ")
        if found := re.match(r"Q(\d+) = (.*)", text):
            self.q[int(found[1])] = float(eval(re.sub(r"Q(\d+)", r"Q[\1]", found[2]), {"Q": self.q, **NAMES}))
        elif found := re.match(r"FN 0: Q(\d+) = (\S+)", text):
            self.q[int(found[1])] = float(found[2])
        elif kind in ("L", "LN", "LP", "C", "CP", "CR", "CT", "CC", "RND", "CHF") or re.match(r"M\d", text):
            self.path(kind, text if kind[0] == "M" else rest)
        elif found := re.match(r"TOOL CALL (\d+) Z S\d+ F(\d+)", text):
            self.tool, self.f, self.automatic = int(found[1]), float(found[2]), float(found[2])
        elif kind == "CYCL":
            self.cycl(rest)
        elif kind == "PLANE":
            self.incline(rest)

    def number(self, text: str) -> float:
        if "Q" not in text:
            return float(text)
        return self.q[int(text.lstrip("+-Q"))] * (-1 if text[0] == "-" else 1)

    def path(self, kind: str, rest: str) -> None:
        words, feed, ms, sense = {}, None, [], 0
        for name, value, turn in WORD.findall(rest):
            if turn:
                sense = 1 if turn == "DR+" else -1
            elif name == "F":
                feed = value.strip() if value in ("MAX", " AUTO") else self.number(value)
            elif name == "M":
                ms.append(int(value))
            else:
                words[name] = self.number(value)
        if kind in ("RND", "CHF"):
            size = float(re.match(r"R?([\d.]+)", rest)[1]) * self.unit
            self.corner = kind, size, self.rate(self.f if feed is None else feed), self.line
            return
        if feed is not None and feed != "MAX":
            self.f = self.automatic if feed == "AUTO" else feed
        if kind == "CC":
            self.centre(words)
            return
        if words.keys() - {"R", "S"} or kind == "CR":
            self.moved(kind, words, math.nan if feed == "MAX" else self.rate(self.f), sense)
        if 89 in ms:
            self.modal = True
        if 99 in ms or (self.modal and words.keys() & {"X", "Y", "Z", "IX", "IY", "IZ"}):
            self.drill()
            self.modal = self.modal and 99 not in ms

    def rate(self, f: float) -> float:
        return f * (1.0 if self.unit == 1.0 else 2.54)  # programs in inch count F in 0.1 inch/min

    def ends(self, words: dict[str, float]) -> Array:
        end = self.local()
        for k, c in enumerate("XYZ"):
            if c in words:
                end[k] = words[c] * self.unit
            elif f"I{c}" in words:
                end[k] += words[f"I{c}"] * self.unit
        return end

    def centre(self, words: dict[str, float]) -> None:
        end = self.ends(words)
        named = "".join(sorted({name[-1] for name in words}))
        self.plane = AXES.get(named, self.plane)
        self.pole = complex(end[self.plane[0]], end[self.plane[1]])

    def moved(self, kind: str, words: dict[str, float], feed: float, sense: int) -> None:
        start, end = self.local(), self.ends(words)
        u, v, w = self.plane if kind in ("C", "CP", "LP") else (0, 1, 2)
        if words.keys() & {"PA", "IPA", "PR", "IPR"}:
            now = complex(start[u], start[v]) - self.pole
            radius = words["PR"] * self.unit if "PR" in words else abs(now) + words.get("IPR", 0.0) * self.unit
            angle = (
                math.radians(words["PA"]) if "PA" in words else cmath.phase(now) + math.radians(words.get("IPA", 0.0))
            )
            place = self.pole + cmath.rect(radius, angle)
            end[u], end[v] = place.real, place.imag
        if "TX" in words:
            vector = np.array([words["TX"], words["TY"], words["TZ"]])
            self.axis = vector / np.linalg.norm(vector)
        if kind in ("L", "LN", "LP"):
            self.go(end, feed)
            return
        a, b = complex(start[u], start[v]), complex(end[u], end[v])
        center, sign = self.pole, float(sense)
        if kind == "CR":
            radius = abs(words["R"]) * self.unit
            off = 1j * (b - a) / abs(b - a) * math.sqrt(max(radius**2 - abs(b - a) ** 2 / 4, 0.0))
            both = [(a + b) / 2 + off, (a + b) / 2 - off]
            center = min(both, key=lambda c: swept(c, a, b, sign) * np.sign(words["R"]))
        elif kind == "CT":
            along = complex(self.heading[u], self.heading[v])
            side = 1j * along / abs(along)
            center = a + side * abs(b - a) ** 2 / (2 * ((b - a) * side.conjugate()).real)
            sign = 1.0 if ((center - a) / side).real > 0 else -1.0
        sweep = math.radians(words["IPA"]) if "IPA" in words else sign * swept(center, a, b, sign)
        place = start.copy()
        place[u], place[v] = center.real, center.imag
        self.go(end, feed, Curve(place, np.eye(3)[w], sweep))

    def go(self, end: Array, feed: float, curve: Curve | None = None) -> None:
        """To a place of the frame in force."""
        f = self.frame
        place = f[:3, :3] @ end + f[:3, 3]
        if curve is not None:
            curve = Curve(f[:3, :3] @ curve.center + f[:3, 3], f[:3, :3] @ curve.axis, curve.sweep)
        if self.corner is not None:
            self.cut_corner(place)
        if np.isfinite(place).all():
            self.moves.append(CncMove(place, self.axis, feed, self.tool, self.line, curve))
        way = place - self.at if curve is None else np.cross(curve.axis, place - curve.center) * np.sign(curve.sweep)
        self.heading = f[:3, :3].T @ way
        self.at = place

    def cut_corner(self, place: Array) -> None:
        """Between two lines: what is cut off of both, and the arc that touches them."""
        kind, size, feed, line = self.corner
        self.corner = None
        last, tip = self.moves[-1], self.moves[-1].end
        back, on = self.moves[-2].end - tip, place - tip
        back, on = back / np.linalg.norm(back), on / np.linalg.norm(on)
        half = math.acos(np.clip(back @ on, -1, 1)) / 2
        side = size if kind == "CHF" else size / math.tan(half)
        begin, stop = tip + side * back, tip + side * on
        self.moves[-1] = CncMove(begin, last.axis, last.feed, last.tool, last.line)
        curve = None
        if kind == "RND":
            middle = tip + size / math.sin(half) * (back + on) / np.linalg.norm(back + on)
            curve = Curve(middle, np.cross(-back, on) / np.linalg.norm(np.cross(back, on)), math.pi - 2 * half)
        self.moves.append(CncMove(stop, self.axis, feed, self.tool, line, curve))
        self.at = stop

    def cycl(self, rest: str) -> None:
        if rest.startswith("CALL"):
            self.drill()
            return
        number = int(re.match(r"DEF (\d+)", rest)[1])
        if number >= 200:
            self.cycle = number, {int(p): float(v) for p, v in re.findall(r"Q(\d+)=([-+.\d]+)", rest)}
            self.modal = False
        elif found := re.match(r"DEF 7\.\d+ (I?)([XYZ])(\S+)", rest):
            shift = self.before if np.allclose(self.tilt, np.eye(4)) else self.behind
            k = "XYZ".index(found[2])
            shift[k, 3] = float(found[3]) * self.unit + (shift[k, 3] if found[1] else 0.0)
            self.heading = None
        elif found := re.match(r"DEF 10\.1 (I?)ROT(\S+)", rest):
            self.turn = float(found[2]) + (self.turn if found[1] else 0.0)
        elif number == 19 and (given := dict(re.findall(r"([ABC])([-+.\d]+)", rest))):
            self.put_tilt(matrix(Rotation.from_euler("xyz", [float(given[c]) for c in "ABC"], degrees=True)))

    def incline(self, rest: str) -> None:
        v = {name: float(value) for name, value in re.findall(r"(SP[ABC]|EUL[A-Z]+|[BN][XYZ])([-+.\d]+)", rest)}
        if rest.startswith("SPATIAL"):
            self.put_tilt(matrix(Rotation.from_euler("xyz", [v["SPA"], v["SPB"], v["SPC"]], degrees=True)))
        elif rest.startswith("RELATIV"):
            (name, angle), *_ = v.items()
            self.put_tilt(self.tilt @ matrix(Rotation.from_euler("xyz"["ABC".index(name[-1])], angle, degrees=True)))
        elif rest.startswith("EULER"):
            self.put_tilt(matrix(Rotation.from_euler("ZXZ", [v["EULPR"], v["EULNU"], v["EULROT"]], degrees=True)))
        elif rest.startswith("VECTOR"):
            z, b = (np.array([v[p + c] for c in "XYZ"]) for p in "NB")
            y = np.cross(z, b)
            new = np.eye(4)
            new[:3, :3] = np.array([np.cross(y, z), y, z]).T / np.array(
                [np.linalg.norm(c) for c in (np.cross(y, z), y, z)]
            )
            self.put_tilt(new)
        else:
            self.put_tilt(np.eye(4))

    def put_tilt(self, new: Array) -> None:
        """The coordinates of another plane: the tool is not where it was before it."""
        if not np.allclose(new, self.tilt):
            self.at = np.full(3, np.nan)
        self.tilt, self.heading, self.axis = new, None, (self.before @ new)[:3, 2]

    def drill(self) -> None:
        number, q = self.cycle
        get = lambda p: q.get(p, 0.0) * self.unit  # noqa: E731
        clear, feed, inside = get(203) + get(200), self.rate(q[206]), self.rate(q.get(208) or q[206])
        steps: list[tuple[float, float]] = [(clear, math.nan)]
        if number == 201:
            steps += [(get(203) + get(201), feed), (clear, inside)]
        else:
            reached, count, stroke = 0.0, 0, get(202)
            while -get(201) - reached > 1e-9:
                if reached and number == 203 and count < q.get(213, 0):
                    steps.append((get(203) - reached + get(256), feed))
                    count += 1
                elif reached:
                    near = 0.2 if number != 205 else get(258) + reached / -get(201) * (get(259) - get(258))
                    steps += [
                        (clear, inside if number == 203 else math.nan),
                        (min(get(203) - reached + near, clear), math.nan),
                    ]
                    count = 0
                reached = min(reached + stroke, -get(201))
                steps.append((get(203) - reached, feed))
                if number != 200 and get(212):
                    stroke = max(stroke - get(212), get(205) or get(212))
            if number == 203:
                steps.append((clear, inside))
        for height, rate in [*steps, (max(clear, get(203) + get(204)), math.nan)]:
            place = self.local()
            if abs(place[2] - height) > 1e-9:
                place[2] = height
                self.go(place, rate)
