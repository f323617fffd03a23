"""Random SINUMERIK programs, valid by construction: the writer keeps where the tool is in the frame in force."""

from __future__ import annotations

import cmath
import math
import random

PLANES = {17: (0, 1, 2), 18: (2, 0, 1), 19: (1, 2, 0)}
MODES = {57: "XYZ", 27: "ZYX", 39: "ZXY", 64: "ZY"}


class RandomSiemens:
    """``text`` is the program."""

    def __init__(self, seed: int, blocks: int = 80) -> None:
        self.rng = random.Random(seed)
        self.unit = self.rng.choice((1.0, 1.0, 25.4))
        self.at, self.plane, self.relative = [0.0] * 3, 17, False
        self.per_turn, self.tilted, self.modal, self.depth = False, False, False, 0
        self.moved = False  # the last block was a move in the plane
        self.lines = [f"%_N_RANDOM{seed}_MPF", "; a comment", f"G{710 if self.unit == 1.0 else 700} G90 G17 G40 G64"]
        self.tool()
        self.approach()
        choices = (
            [self.line] * 6 + [self.arc] * 7 + [self.through, self.tangent, self.drill, self.pattern, self.vectors]
        )
        choices += [self.frame, self.swivel, self.loop, self.choice, self.feed, self.noise, self.mode, self.tool]
        for _ in range(blocks):
            self.rng.choice(choices)()
        self.lines += ["CYCLE800()", "M30", "%_N_L7_SPF", "G90", "G1 X=IC(1.5) Y=IC(-.25)", "X=IC(-1)", "M17"]
        self.text = "\n".join(self.lines) + "\n"

    def emit(self, *words: str) -> None:
        head = self.rng.choice(["", "", f"N{len(self.lines)} "])
        self.lines.append(head + " ".join(words) + self.rng.choice(["", "", "", " ; note"]))

    def number(self, value: float) -> tuple[str, float]:
        text = self.rng.choice([f"{value:.6f}", f"{value:.6f}".rstrip("0"), f"{value:+.6f}"])
        return text, float(text)

    def word(self, name: str, value: float) -> str:
        """A letter and its value, sometimes as an expression."""
        text, _ = self.number(value)
        how = self.rng.random()
        if how < 0.1 and not self.depth:
            self.lines += [f"R1={text} R3=1", "R2=R1*2"]
            return f"{name}=R2-R1"
        return f"{name}={text}" if how < 0.2 or len(name) > 1 else f"{name}{text}"

    def coordinate(self, k: int, target: float) -> str:
        """The word that brings an axis near a place; the state takes what is printed."""
        how = self.rng.random()
        relative = self.relative if how < 0.7 else how < 0.85
        text, value = self.number(target - (self.at[k] if relative else 0.0))
        self.at[k] = value + (self.at[k] if relative else 0.0)
        if relative != self.relative:
            return f"{'XYZ'[k]}={'IC' if relative else 'AC'}({text})"
        return f"{'XYZ'[k]}{text}"

    def place(self) -> list[float]:
        return [self.rng.uniform(-40, 40) / self.unit for _ in range(3)]

    def approach(self) -> None:
        """A rapid to a place that is named whole."""
        self.at = self.place()
        words = [f"{'XYZ'[k]}=AC({v:.6f})" for k, v in enumerate(self.at)]
        self.at = [float(f"{v:.6f}") for v in self.at]
        self.emit("G0", *words)
        self.moved = False

    def line(self) -> None:
        target = self.place()
        axes = [k for k in range(3) if self.rng.random() < 0.6] or [0]
        self.emit(self.rng.choice(["G1", "G1", "G01", "G0"]), *(self.coordinate(k, target[k]) for k in axes))
        u, v, _ = PLANES[self.plane]
        self.moved = sorted(axes) == sorted((u, v))

    def feed(self) -> None:
        if self.rng.random() < 0.3:
            self.per_turn = not self.per_turn
        value = self.rng.uniform(100, 900) / self.unit
        self.emit("G95" if self.per_turn else "G94", f"F{value / (1000 if self.per_turn else 1):.4f}", "S1200")

    def arc(self) -> None:
        """By centre, radius or opening angle; in the plane or as a helix, with whole turns."""
        u, v, w = PLANES[self.plane]
        sign, radius = self.rng.choice((1, -1)), self.rng.uniform(0.5, 30) / self.unit
        sweep = self.rng.uniform(0.2, 6.0)
        start = complex(self.at[u], self.at[v])
        center = start + cmath.rect(radius, self.rng.uniform(0, math.tau))
        stop = center + (start - center) * cmath.exp(1j * sign * sweep)
        head = "G3" if sign > 0 else "G2"
        way = self.rng.choice(("centre", "centre", "radius", "angle", "angle and centre", "whole"))
        words: list[str] = []
        if self.rng.random() < 0.3:
            words.append(self.coordinate(w, self.place()[w]))
        if way not in ("whole", "angle and centre"):
            words += [self.coordinate(u, stop.real), self.coordinate(v, stop.imag)]
        if way in ("centre", "whole", "angle and centre"):
            absolute = self.rng.random() < 0.4
            for k, value, base in ((u, center.real, start.real), (v, center.imag, start.imag)):
                text, _ = self.number(value - (0.0 if absolute else base))
                words.append(f"{'IJK'[k]}=AC({text})" if absolute else f"{'IJK'[k]}{text}")
        if way == "radius":
            words.append(f"CR={math.copysign(radius, math.pi - sweep):.7f}")
        elif "angle" in way:
            words.append(f"AR={math.degrees(sweep):.6f}")
            if way != "angle":
                self.at[u], self.at[v] = self.turned(words, start, center, sign)
        if self.rng.random() < 0.2:
            words.append(f"TURN={self.rng.randint(1, 3)}")
        self.emit(head, *words)
        self.moved = w not in [k for k in range(3) if any(x.startswith("XYZ"[k]) for x in words)]

    def turned(self, words: list[str], start: complex, center: complex, sign: int) -> tuple[float, float]:
        """The end of an arc by its angle and the centre as it is printed."""
        angle = math.radians(float(words[-1][3:]))
        near = complex(*(round(c, 6) for c in (center.real, center.imag)))
        if "AC" not in words[-2]:
            near = start + complex(*(round(c, 6) for c in ((center - start).real, (center - start).imag)))
        end = near + (start - near) * cmath.exp(1j * sign * angle)
        return end.real, end.imag

    def through(self) -> None:
        via, end = self.place(), self.place()
        how = [f"{n}={'AC' if self.relative else ''}({v:.6f})" for n, v in zip(("I1", "J1", "K1"), via, strict=True)]
        how = [h.replace("=(", "=(") for h in how]
        self.emit("CIP", *how, *(self.coordinate(k, end[k]) for k in range(3)))
        self.moved = False

    def tangent(self) -> None:
        if not self.moved:
            return
        u, v, _ = PLANES[self.plane]
        target = self.place()
        self.emit("CT", self.coordinate(u, target[u]), self.coordinate(v, target[v]))

    def drill(self) -> None:
        """One hole, upwards from its depth."""
        if self.tilted or self.relative:
            return
        self.emit(self.cycle())
        self.at[PLANES[self.plane][2]] = self.back
        self.moved = False

    def cycle(self) -> str:
        surface = round(self.rng.uniform(-5, 5) / self.unit, 4)
        depth = round(self.rng.uniform(4, 45) / self.unit, 4)
        self.back = round(surface + 5 / self.unit, 4)
        head = f"({self.back},{surface},{1 / self.unit:.4f},{surface - depth:.5f}"
        kind = self.rng.choice(("81", "82", "89", "83", "83"))
        if kind != "83":
            return f"CYCLE{kind}{head}{',,0.5' if kind == '82' else ''})"
        first, less = round(depth / self.rng.uniform(1.5, 3), 4), self.rng.choice((0, round(depth / 12, 4), -0.7))
        by = f",{first}" if self.rng.random() < 0.5 else f"{round(surface - first, 5)},"
        return f"CYCLE83{head},,{by},{less},0,0,1,{self.rng.randint(0, 1)})"

    def pattern(self) -> None:
        if self.tilted or self.relative:
            return
        u, v, w = PLANES[self.plane]
        self.emit(f"MCALL {self.cycle()}")
        for _ in range(self.rng.randint(1, 3)):
            target = self.place()
            self.emit("G0", self.coordinate(u, target[u]), self.coordinate(v, target[v]))
            self.at[w] = self.back
        self.emit("MCALL")
        self.moved = False

    def vectors(self) -> None:
        """A few moves under TRAORI, in the frame of the work object."""
        self.emit("CYCLE800()")
        self.emit("TRAORI")
        self.approach()
        for _ in range(self.rng.randint(1, 4)):
            target = self.place()
            axes = [self.coordinate(k, target[k]) for k in range(3) if self.rng.random() < 0.7]
            i, j = self.rng.uniform(-0.7, 0.7), self.rng.uniform(-0.7, 0.7)
            self.emit("G1", *axes, f"A3={i:.6f}", f"B3={j:.6f}", f"C3={self.rng.uniform(0.3, 2):.6f}")
        self.emit("TRAFOOF")
        self.emit("CYCLE800()")
        self.tilted = False
        self.approach()

    def frame(self) -> None:
        words = [f"{c}{self.rng.uniform(-9, 9):.3f}" for c in "XYZ" if self.rng.random() < 0.6]
        kind = self.rng.choice(("TRANS", "ATRANS", "ROT", "AROT", "RPL"))
        if kind == "RPL":
            kind, words = "AROT", [f"RPL={self.rng.uniform(-90, 90):.3f}"]
        self.emit(kind, *words)
        self.approach()

    def swivel(self) -> None:
        """CYCLE800: a plane by one of its orders, sometimes on the one before."""
        if self.rng.random() < 0.3:
            self.emit("CYCLE800()")
            self.tilted = False
        else:
            mode = self.rng.choice(list(MODES))
            angles = [round(self.rng.uniform(-60, 60), 3) for _ in range(3)]
            shift = ",".join(f"{self.rng.uniform(-5, 5):.2f}" for _ in range(3))
            more = ",".join(f"{self.rng.uniform(-5, 5):.2f}" for _ in range(3))
            self.emit("TRANS")
            self.emit(
                f'CYCLE800(1,"TC1",{self.rng.randint(0, 1)},{mode},{shift},{",".join(map(str, angles))},{more},-1)'
            )
            self.tilted = True
        self.approach()

    def loop(self) -> None:
        self.relative = True
        self.emit("G91")
        count = self.rng.randint(1, 3)
        self.lines.append(f"FOR R9=1 TO {count}")
        self.emit("G1 X=R9*0.5 Y-.25")
        self.lines.append("ENDFOR")
        self.lines.append(self.rng.choice((f"L7 P{self.rng.randint(1, 3)}", "L7")))
        self.relative = False
        self.emit("G90")
        self.approach()

    def choice(self) -> None:
        self.lines += [f"R5={self.rng.randint(0, 9)}", "IF R5>4", "G1 X=R5 Y1", "ELSE", "G1 X=-R5 Y2", "ENDIF"]
        self.approach()

    def mode(self) -> None:
        self.plane = self.rng.choice((17, 17, 18, 19))
        self.relative = self.rng.random() < 0.4
        self.emit(f"G{self.plane}", "G91" if self.relative else "G90")
        self.moved = False

    def tool(self) -> None:
        number = self.rng.randint(1, 9)
        self.emit(f"T{number}")
        self.emit("M6")
        self.emit(f"S{self.rng.randint(800, 5000)}", "M3")
        self.emit("G94", f"F{self.rng.uniform(100, 900) / self.unit:.3f}")
        self.per_turn = False

    def noise(self) -> None:
        self.emit(
            self.rng.choice(
                ('MSG("A (B) ; C")', "SOFT FFWON COMPCAD", "CYCLE832(0.01,1,0.1)", "G4 F0.5", "M8", "STOPRE")
            )
        )
