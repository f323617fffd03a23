"""Random Klartext programs that are valid by construction: the writer keeps where the tool is in the frame in force."""

from __future__ import annotations

import cmath
import math
import random

PLANES = ((0, 1, 2), (1, 2, 0), (2, 0, 1))


class RandomKlartext:
    """``text`` is the program."""

    def __init__(self, seed: int, blocks: int = 80) -> None:
        self.rng = random.Random(seed)
        self.inch = self.rng.random() < 0.3
        self.scale = 1 / 25.4 if self.inch else 1.0
        self.at, self.labels, self.tilted = [0.0] * 3, 10, False
        self.moved = False  # the last block was a cut in the plane of the tool
        self.name = f"R{seed} {'INCH' if self.inch else 'MM'}"
        self.lines = [f"BEGIN PGM {self.name}", "BLK FORM 0.1 Z X-9 Y-9 Z-9", "BLK FORM 0.2 X+9 Y+9 Z+9"]
        self.tool()
        self.approach()
        choices = [self.line] * 6 + [self.circle] * 4 + [self.helix, self.radius, self.polar] * 2
        choices += [
            self.tangent,
            self.corner,
            self.corner,
            self.holes,
            self.vectors,
            self.shift,
            self.plane,
            self.plane,
        ]
        choices += [self.repeat, self.jump, self.formula, self.noise, self.tool]
        for _ in range(blocks):
            self.rng.choice(choices)()
        self.lines += ["L M30", "LBL 5", "L IX+1.5 IY-0.25", "L IX-1 R0 F AUTO", "LBL 0", f"END PGM {self.name}"]
        heads = [" " if k and self.lines[k - 1].endswith("~") else f"{k} " for k in range(len(self.lines))]
        self.text = "\n".join(head + line for head, line in zip(heads, self.lines, strict=True)) + "\n"

    def emit(self, *words: str) -> None:
        self.lines.append(" ".join(words) + self.rng.choice(["", "", "", " ; note"]))

    def coordinate(self, k: int, target: float) -> str:
        """The word that brings an axis near a place; the state takes what is printed."""
        relative = self.rng.random() < 0.3
        text = f"{target - (self.at[k] if relative else 0.0):+.6f}"
        self.at[k] = float(text) + (self.at[k] if relative else 0.0)
        return f"{'I' if relative else ''}{'XYZ'[k]}{text}"

    def place(self) -> list[float]:
        return [self.rng.uniform(-40, 40) * self.scale for _ in range(3)]

    def feed(self) -> list[str]:
        return [f"F{self.rng.uniform(100, 900):.1f}"] if self.rng.random() < 0.3 else []

    def approach(self) -> None:
        """A rapid to a place that is named whole."""
        self.at = [float(f"{v:.6f}") for v in self.place()]
        self.emit("L", *(f"{'XYZ'[k]}{v:+.6f}" for k, v in enumerate(self.at)), "R0 FMAX")
        self.moved = False

    def line(self) -> None:
        target, rapid = self.place(), self.rng.random() < 0.3
        axes = [k for k in range(3) if self.rng.random() < 0.6] or [0]
        words = [self.coordinate(k, target[k]) for k in axes]
        self.emit("L", *words, *(["FMAX"] if rapid else self.feed()))
        self.moved = not rapid and axes == [0, 1]

    def pole(self, center: complex, u: int, v: int) -> complex:
        """CC; the centre as it is printed."""
        a, b = f"{center.real:+.6f}", f"{center.imag:+.6f}"
        self.emit("CC", f"{'XYZ'[u]}{a}", f"{'XYZ'[v]}{b}")
        return complex(float(a), float(b))

    def circle(self) -> None:
        """C, whole circles as well, in any plane; a helix by its third axis."""
        u, v, w = self.rng.choice(PLANES)
        start = complex(self.at[u], self.at[v])
        center = self.pole(start + cmath.rect(self.rng.uniform(1, 30) * self.scale, self.rng.uniform(0, 7)), u, v)
        words = [self.coordinate(w, self.place()[w])] if self.rng.random() < 0.3 else []
        if self.rng.random() < 0.8:
            stop = center + (start - center) * cmath.exp(1j * self.rng.uniform(0.2, 6))
            words += [self.coordinate(u, stop.real), self.coordinate(v, stop.imag)]
        else:
            words += [f"I{'XYZ'[u]}+0", f"I{'XYZ'[v]}+0"]
        self.emit("C", *words, self.rng.choice(("DR+", "DR-")), *self.feed())
        self.moved = w == 2 and len(words) == 2

    def helix(self) -> None:
        u, v, w = self.rng.choice(PLANES)
        start = complex(self.at[u], self.at[v])
        center = self.pole(start + cmath.rect(self.rng.uniform(1, 30) * self.scale, self.rng.uniform(0, 7)), u, v)
        angle = round(self.rng.choice((1, -1)) * self.rng.uniform(20, 1500), 3)
        rise = [self.coordinate(w, self.place()[w])]
        self.emit("CP", f"IPA{angle:+.3f}", *rise, f"DR{'+' if angle > 0 else '-'}", *self.feed())
        end = center + (start - center) * cmath.exp(1j * math.radians(angle))
        self.at[u], self.at[v] = end.real, end.imag
        self.moved = False

    def polar(self) -> None:
        """LP, and CP to an angle."""
        u, v, _ = self.rng.choice(PLANES)
        start = complex(self.at[u], self.at[v])
        center = self.pole(start + cmath.rect(self.rng.uniform(5, 30) * self.scale, self.rng.uniform(0, 7)), u, v)
        angle, radius = round(self.rng.uniform(-170, 170), 4), abs(start - center)
        if self.rng.random() < 0.5:
            self.emit("CP", f"PA{angle:+.4f}", self.rng.choice(("DR+", "DR-")))
        else:
            radius = round(self.rng.uniform(5, 30) * self.scale, 5)
            self.emit("LP", f"PR+{radius}", f"PA{angle:+.4f}", *self.rng.choice((["FMAX"], self.feed())))
        end = center + cmath.rect(radius, math.radians(angle))
        self.at[u], self.at[v] = end.real, end.imag
        self.moved = False

    def radius(self) -> None:
        sweep, radius = self.rng.uniform(0.2, 6), self.rng.uniform(1, 30) * self.scale
        sign = self.rng.choice((1, -1))
        start = complex(*self.at[:2])
        center = start + cmath.rect(radius, self.rng.uniform(0, 7))
        stop = center + (start - center) * cmath.exp(1j * sign * sweep)
        words = [self.coordinate(0, stop.real), self.coordinate(1, stop.imag)]
        self.emit("CR", *words, f"R{math.copysign(radius, math.pi - sweep):+.7f}", f"DR{'+' if sign > 0 else '-'}")
        self.moved = True

    def tangent(self) -> None:
        if self.moved:
            target = self.place()
            self.emit("CT", self.coordinate(0, target[0]), self.coordinate(1, target[1]), *self.feed())

    def corner(self) -> None:
        """Two lines in the plane that are long enough, and what is between them."""
        self.approach()
        heading, word = self.rng.uniform(0, 7), self.rng.choice(("RND R", "CHF "))
        for last in (False, True):
            reach = cmath.rect(self.rng.uniform(20, 40) * self.scale, heading)
            self.emit("L", self.coordinate(0, self.at[0] + reach.real), self.coordinate(1, self.at[1] + reach.imag))
            if not last:
                self.emit(f"{word}{self.rng.uniform(0.5, 4) * self.scale:.4f}", *self.feed())
            heading += self.rng.choice((1, -1)) * self.rng.uniform(0.3, 2.2)
        self.moved = True

    def holes(self) -> None:
        number = self.rng.choice((200, 201, 203, 205))
        s, depth = self.scale, self.rng.uniform(5, 30)
        surface = round(self.rng.uniform(-5, 5) * s, 4)
        q = {
            200: f"{2 * s:.4f}",
            201: f"{-depth * s:.5f}",
            206: f"{self.rng.uniform(50, 400):.1f}",
            203: f"{surface:+}",
        }
        q[204] = f"{self.rng.choice((0, 20)) * s:.4f}"
        if number != 201:
            q |= {202: f"{depth * s / self.rng.uniform(0.9, 6):.5f}"}
        if number in (203, 205):
            q |= {212: f"{self.rng.choice((0, 0.8)) * s:.4f}", 205: f"{1 * s:.4f}"}
        if number == 203:
            q |= {213: str(self.rng.randint(0, 3)), 208: "777", 256: f"{0.3 * s:.4f}"}
        if number == 205:
            q |= {258: f"{0.5 * s:.4f}", 259: f"{1 * s:.4f}", 257: "0", 256: f"{0.3 * s:.4f}"}
        words = [f"Q{p}={v} ;VALUE" for p, v in q.items()]
        self.lines.append(f"CYCL DEF {number} DRILLING ~")
        self.lines += [f"{word} ~" for word in words[:-1]] + [words[-1]]
        back = max(float(q[200]), float(q[204])) + surface
        modal = self.rng.random() < 0.3
        for k in range(self.rng.randint(1, 3)):
            target = self.place()
            call = ["M89"] if modal and not k else [] if modal else [self.rng.choice(("M99", ""))]
            self.emit("L", self.coordinate(0, target[0]), self.coordinate(1, target[1]), "R0 FMAX", *filter(None, call))
            if call == [""]:
                self.emit("CYCL CALL")
            self.at[2] = back
        if modal:
            self.emit("L", f"X{self.at[0]:+.6f}", "FMAX M99")
        self.moved = False

    def vectors(self) -> None:
        self.plane(reset=True)
        self.emit("M128")
        for _ in range(self.rng.randint(1, 4)):
            target = self.place()
            axes = [self.coordinate(k, target[k]) for k in range(3) if self.rng.random() < 0.7]
            i, j, k = self.rng.uniform(-0.7, 0.7), self.rng.uniform(-0.7, 0.7), self.rng.uniform(0.3, 2)
            self.emit("LN", *axes, "NX+0 NY+0 NZ+1", f"TX{i:+.6f}", f"TY{j:+.6f}", f"TZ{k:+.6f}", *self.feed())
        self.emit("M129")
        self.emit("PLANE RESET TURN FMAX")
        self.plane(reset=True)

    def shift(self) -> None:
        """Cycle 7; a rotation (10) that is ended again."""
        for k in range(3):
            word = f"{self.rng.choice(('', 'I'))}{'XYZ'[k]}{self.rng.uniform(-9, 9) * self.scale:+.3f}"
            if not self.tilted:
                self.lines += ["CYCL DEF 7.0 DATUM SHIFT", f"CYCL DEF 7.{k + 1} {word}"]
        if self.rng.random() < 0.5:
            self.lines += ["CYCL DEF 10.0 ROTATION", f"CYCL DEF 10.1 ROT{self.rng.uniform(-90, 90):+.3f}"]
            self.approach()
            self.line()
            self.lines += ["CYCL DEF 10.0 ROTATION", "CYCL DEF 10.1 ROT+0"]
        self.approach()

    def plane(self, *, reset: bool = False) -> None:
        a, b, c = (self.rng.uniform(-60, 60) for _ in range(3))
        way = self.rng.choice(("TURN FMAX SEQ-", "MOVE ABST50 F500", "STAY"))
        kind = (
            "RESET" if reset else self.rng.choice(("SPATIAL", "SPATIAL", "EULER", "VECTOR", "RELATIV", "19", "RESET"))
        )
        self.lines += ["PLANE RESET TURN FMAX"] if kind == "19" else []
        words = {
            "SPATIAL": f"SPA{a:+.3f} SPB{b:+.3f} SPC{c:+.3f} {way}",
            "EULER": f"EULPR{a:+.3f} EULNU{b:+.3f} EULROT{c:+.3f} {way}",
            "VECTOR": f"BX{1 + a / 99:+.3f} BY{b / 99:+.3f} BZ+0 NX{c / 99:+.3f} NY+0.1 NZ+0.9 {way}",
            "RELATIV": f"SP{self.rng.choice('ABC')}{a:+.3f} {way}",
            "RESET": "TURN FMAX",
        }.get(kind)
        if words:
            self.emit("PLANE", kind, words)
            if words.endswith("STAY"):
                self.emit("L A+Q120 C+Q122 R0 FMAX")
        else:
            self.lines += ["CYCL DEF 19.0 WORKING PLANE", f"CYCL DEF 19.1 A{a:+.3f} B{b:+.3f} C{c:+.3f}"]
            self.emit("L B+Q121 C+Q122 R0 FMAX")
        self.tilted = kind != "RESET"
        self.approach()

    def repeat(self) -> None:
        self.labels += 1
        self.lines += [
            f"LBL {self.labels}",
            "L IX+0.5 IY-0.25",
            f"CALL LBL {self.labels} REP{self.rng.randint(1, 3)}",
            "CALL LBL 5",
        ]
        self.approach()

    def jump(self) -> None:
        self.labels += 1
        self.lines += [
            f"FN 0: Q1 = +{self.rng.randint(0, 9)}",
            f"FN {self.rng.choice(('11: IF +Q1 GT', '12: IF +Q1 LT'))} +4 GOTO LBL {self.labels}",
        ]
        self.lines += ["L X+1 Y+Q1", f"LBL {self.labels}"]
        self.approach()

    def formula(self) -> None:
        self.lines += [
            f"Q3 = {self.rng.uniform(-9, 9):.3f} * ( SIN ( 30 ) + 2 )",
            "Q4 = Q3 + ABS ( Q3 ) / 4 - 1",
            "L X+Q3 IY-Q4",
        ]
        self.approach()

    def tool(self) -> None:
        self.emit(f"TOOL CALL {self.rng.randint(1, 9)} Z S{self.rng.randint(800, 5000)} F{self.rng.randint(100, 900)}")
        self.emit("L M3")
        self.emit(f"L F{self.rng.uniform(100, 900):.1f}")

    def noise(self) -> None:
        self.emit(
            self.rng.choice(("* - a step", "STOP", "M8", "CYCL DEF 32.0 TOLERANCE", "CYCL DEF 9.0 DWELL TIME", "M126"))
        )
