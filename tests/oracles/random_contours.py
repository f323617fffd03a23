"""Random contours under cutter compensation: G41.1 or G42.1, lines and arcs whose corners turn to either side."""

from __future__ import annotations

import math
import random


def contour(seed: int, moves: int = 12) -> str:
    """A program, mm: the cutter fits into most of its corners; LinuxCNC says which."""
    rng = random.Random(seed)
    side = rng.choice(["G41.1", "G42.1"])
    x, y, way = 0.0, 0.0, rng.uniform(0, math.tau)
    lines = [f"G21 G90 G17 G40 (seed {seed})", "G0 X0 Y0 Z5", "F500"]

    def line(length: float) -> str:
        nonlocal x, y
        x, y = x + length * math.cos(way), y + length * math.sin(way)
        return f"X{x:.7f} Y{y:.7f}"

    lines.append(f"{side} D{rng.uniform(1, 6):.3f}")
    lines.append(f"{rng.choice(['G0', 'G1'])} {line(rng.uniform(5, 20))}")
    for _ in range(moves):
        kind = rng.random()
        if kind < 0.1:
            lines.append(f"Z{rng.uniform(-3, 3):.3f}")
            continue
        # a corner of less than 0.05 rad is none for LinuxCNC
        way += rng.choice([0, 1, 1, -1]) * rng.uniform(0.06, 2.6)
        if kind < 0.6:
            height = f" Z{rng.uniform(-3, 3):.3f}" if rng.random() < 0.2 else ""
            lines.append(f"G1 {line(rng.uniform(6, 25))}{height}")
        else:
            radius, sweep = rng.uniform(6, 20), rng.uniform(0.3, 5.5) * rng.choice([-1, 1])
            side_radius = math.copysign(radius, sweep)
            i, j = -side_radius * math.sin(way), side_radius * math.cos(way)
            cx, cy = x + i, y + j
            c, s = math.cos(sweep), math.sin(sweep)
            x, y = cx + c * (x - cx) - s * (y - cy), cy + s * (x - cx) + c * (y - cy)
            way += sweep
            lines.append(f"{'G2' if sweep < 0 else 'G3'} X{x:.7f} Y{y:.7f} I{i:.7f} J{j:.7f}")
    return "\n".join([*lines, "G40", f"G1 X{x + 30:.7f} Y{y + 30:.7f}", "G0 Z20", "M2"]) + "\n"
