"""Random modal G-code programs that are valid by construction: the writer keeps the state of the machine in mm."""

from __future__ import annotations

import math
import random
from collections.abc import Iterable

AXES, CENTRES = "XYZ", "IJK"
RESET = "G80\nG92.1\nG94 G91.1\n"  # from whatever state to that in which a program begins
PLANES = {"G17": 2, "G18": 1, "G19": 0}


class RandomProgram:
    """Lines of one program; ``text`` is all of it."""

    def __init__(self, seed: int, blocks: int = 120, *, shifts: bool = True) -> None:
        self.rng = random.Random(seed)
        self.at, self.shift, self.kept = [1.0, -2.0, 30.0], [0.0] * 3, [0.0] * 3
        self.shifted_by, self.suspended = "", False
        self.unit, self.relative, self.normal, self.absolute_centre = 1.0, False, 2, False
        self.mode, self.motion, self.cycle = "G94", "", ""
        self.needs_feed = False
        self.lines = [f"G21 G90 G17 G40 (seed {seed})", "M3 S1200", "G0 X1 Y-2 Z30", "F500"]
        choices = [self.line] * 6 + [self.arc] * 6 + [self.drill] * 2 + [self.modal] * 5 + [self.noise]
        choices += [self.origin] if shifts else []
        for _ in range(blocks):
            self.rng.choice(choices)()
        self.text = "\n".join(self.lines) + "\nM2\n"

    def number(self, value: float) -> tuple[str, float]:
        """As printed, and the value of that."""
        digits = 4 if self.unit == 1.0 else 5
        text = f"{value:.{digits}f}"
        style = self.rng.random()
        if style < 0.5:
            text = text.rstrip("0")
        elif style < 0.6 and value > 0:
            text = "+" + text
        return text, float(text)

    def length(self, value: float) -> str:
        return self.number(value / self.unit)[0]

    def emit(self, words: list[str]) -> None:
        head = f"N{len(self.lines)} " if self.rng.random() < 0.2 else ""
        text = head + self.rng.choice(["", " ", " ", "  "]).join(words)
        if self.rng.random() < 0.1:
            text = text.lower()
        self.lines.append(text + self.rng.choice(["", "", "", " (note)", " ; note", "(a) (b)"]))

    def feed(self) -> list[str]:
        if self.mode == "G93":
            return [f"F{self.rng.uniform(0.5, 9):.3f}"]
        if self.needs_feed or self.rng.random() < 0.1:
            self.needs_feed = False
            value = self.rng.uniform(100, 900) / self.unit
            return [f"F{value:.2f}" if self.mode == "G94" else f"F{value / 1000:.4f}"]
        return []

    def coordinate(self, axis: int, target: float) -> str:
        """The word that brings an axis near a place, mm; the state takes what is printed."""
        from_ = self.at[axis] if self.relative else self.shift[axis]
        text, value = self.number((target - from_) / self.unit)
        self.at[axis] = from_ + value * self.unit
        return AXES[axis] + text

    def word(self, motion: str) -> list[str]:
        """The motion word, left out where it is in force."""
        if self.motion == motion and self.rng.random() < 0.5:
            return []
        self.motion, self.cycle = motion, ""
        return [motion if self.rng.random() < 0.5 else motion.replace("G", "G0")]

    def line(self) -> None:
        cut = self.rng.random() < 0.7
        words = self.word("G1" if cut else "G0") + (self.feed() if cut else [])
        axes = [k for k in range(3) if self.rng.random() < 0.6] or [self.rng.randrange(3)]
        self.emit(words + [self.coordinate(k, self.rng.uniform(-50, 50)) for k in axes])

    def arc(self) -> None:
        rng, normal = self.rng, self.normal
        first, second = (normal + 1) % 3, (normal + 2) % 3
        words = self.word(rng.choice(["G2", "G3"])) + self.feed()
        clockwise = self.motion == "G2"
        radius, a = rng.uniform(0.5, 20), rng.uniform(0, math.tau)
        sweep = math.tau if (full := rng.random() < 0.3) else rng.uniform(0.1, 6.1)
        b = a - sweep if clockwise else a + sweep
        start = list(self.at)
        centre = [start[first] - radius * math.cos(a), start[second] - radius * math.sin(a)]
        if not full:
            words.append(self.coordinate(first, centre[0] + radius * math.cos(b)))
            words.append(self.coordinate(second, centre[1] + radius * math.sin(b)))
        if rng.random() < 0.3:
            words.append(self.coordinate(normal, start[normal] + rng.uniform(-5, 5)))
        if not full and rng.random() < 0.4:
            chord = math.dist([start[first], start[second]], [self.at[first], self.at[second]])
            size = max(radius, chord / 2 + 0.002 if sweep < 3.2 else 0)
            words.append(f"R{'-' if sweep > math.pi else ''}{self.length(size).lstrip('+')}")
        else:
            for axis, c in zip((first, second), centre, strict=True):
                from_ = self.shift[axis] if self.absolute_centre else start[axis]
                words.append(CENTRES[axis] + self.length(c - from_))
        if rng.random() < 0.15:
            words.append(f"P{rng.randint(1, 4)}")
        self.emit(words)

    def drill(self) -> None:
        if self.mode == "G93":
            return
        rng, normal = self.rng, self.normal
        plane = [k for k in range(3) if k != normal]
        if not self.cycle:
            self.level = self.at[normal]
        key = rng.choice(["G73", "G81", "G82", "G83", "G85"])
        back = rng.random() < 0.5
        r = (self.level if back else self.at[normal]) + rng.uniform(-9, 2)
        depth = rng.uniform(1, 9)
        words = [key, "G98" if back else "G99", *self.feed()]
        self.motion, self.cycle = "", key
        for k in plane:
            if rng.random() < 0.7:
                words.append(self.coordinate(k, rng.uniform(-50, 50)))
        base = self.level if self.relative else self.shift[normal]
        r_text, r_value = self.number((r - base) / self.unit)
        r = base + r_value * self.unit
        z_text, _ = self.number((-depth if self.relative else r - depth - base) / self.unit)
        words += [f"R{r_text}", f"{AXES[normal]}{z_text}"]
        if key in ("G73", "G83"):
            words.append(f"Q{self.length(rng.uniform(0.5, 4))}")
        if key == "G82":
            words.append("P0.25")
        self.emit(words)
        self.at[normal] = max(self.level, r) if back else r
        if rng.random() < 0.5:
            self.emit(["G80"])
            self.motion = self.cycle = ""

    def modal(self) -> None:
        pick = self.rng.random()
        if self.cycle:
            self.emit(["G80"])
            self.motion = self.cycle = ""
        if pick < 0.35:
            word = self.rng.choice(list(PLANES))
            self.normal = PLANES[word]
        elif pick < 0.6:
            word = self.rng.choice(["G90", "G91"])
            self.relative = word == "G91"
        elif pick < 0.7:
            word = self.rng.choice(["G20", "G21"])
            unit = 25.4 if word == "G20" else 1.0
            self.needs_feed |= unit != self.unit
            self.unit = unit
        elif pick < 0.85:
            word = self.rng.choice(["G90.1", "G91.1"])
            self.absolute_centre = word == "G90.1"
        else:
            word = self.rng.choice(["G93", "G94", "G95"])
            self.needs_feed = True  # LinuxCNC drops F even when the mode stays
            self.mode = word
        self.emit([word])

    def origin(self) -> None:
        rng = self.rng
        if self.cycle:
            self.emit(["G80"])
            self.motion = self.cycle = ""
        word = rng.choice(["G52", "G92", "G92", "G92.1", "G92.2", "G92.3"])
        axes = [k for k in range(3) if rng.random() < 0.5] or [0]
        if word in ("G52", "G92"):
            if self.shifted_by not in ("", word) or self.suspended:
                word = "G92.1"
            else:
                words = [word]
                for k in axes:
                    text, value = self.number(rng.uniform(-30, 30) / self.unit)
                    words.append(AXES[k] + text)
                    self.shift[k] = value * self.unit if word == "G52" else self.at[k] - value * self.unit
                self.shifted_by = word
                self.emit(words)
                return
        if word == "G92.1":
            self.shift, self.shifted_by, self.suspended = [0.0] * 3, "", False
        elif word == "G92.2" and not self.suspended:
            self.kept, self.shift, self.suspended = self.shift, [0.0] * 3, True
        elif word == "G92.3" and self.suspended:
            self.shift, self.suspended = self.kept, False
        else:
            return
        self.emit([word])

    def noise(self) -> None:
        words = ["G4 P0.1", "M8", "M9", "T3", "G64 P0.01", "G61", "G49", "G54", "S900", "G17.0"]
        self.emit([self.rng.choice([*words, "M3", "M4 S1500", "M5", "T2 M6", "S700 M3 T1 M6"])])
        if self.lines[-1].upper().find("G17") >= 0:
            self.normal = 2
            if self.cycle:
                self.emit(["G80"])
                self.motion = self.cycle = ""


def joined(seeds: Iterable[int]) -> str:
    """Several programs in one file: each begins in the state that the one before it leaves."""
    return RESET.join(RandomProgram(seed).text.removesuffix("M2\n") for seed in seeds) + "M2\n"
