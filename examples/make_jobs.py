"""Make pocket.nc (a pocket roughed in 7075), contour.nc (a boss finished around its side), wave-stock.obj.

    python examples/make_jobs.py [-o FOLDER]

The stock of both jobs is a box, given in their cells (pocket.toml, contour.toml); z = 0 is its top. wave-stock.obj is
what roughing has left for wave.nc: 1 mm more than the part all over. The same call writes the same bytes.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import numpy.typing as npt

SAFE = 10.0  # mm above the stock
LEFT, PITCH, BOTTOM = 1.0, 8.0, -40.0  # mm: on the wave, between points of its mesh, of the block


def pocket() -> list[str]:
    """A pocket of 120 x 80 x 12 mm with a flat end mill D16: a ramp into each layer of 3 mm, then lanes 8 mm apart."""
    radius, step, down = 8.0, 8.0, 3.0
    low, high = (15.0 + radius, 15.0 + radius), (135.0 - radius, 95.0 - radius)
    out = head("POCKET", "T1 D=16 - flat end mill", tool=1, speed=8000)
    out += [f"G0 X{low[0]:g} Y{low[1]:g}", f"Z{SAFE:g}", "G1 Z0.5 F800"]
    for layer in range(1, 5):
        z = -down * layer
        out += [f"G1 X{high[0]:g} Z{z + 1.5:g} F600", f"X{low[0]:g} Z{z:g}", "F1600"]  # down the first lane and back
        y, at_low = low[1], True
        while True:
            out.append(f"X{high[0] if at_low else low[0]:g}")
            at_low = not at_low
            if y >= high[1] - 1e-9:
                break
            y = min(y + step, high[1])
            out.append(f"Y{y:g}")
        out += [f"G0 Z{SAFE:g}", f"X{low[0]:g} Y{low[1]:g}"]
        if layer < 4:
            out += [f"Z{z + 0.5:g}"]
    return [*out, "M5", "M30"]


def contour() -> list[str]:
    """A boss of 100 x 60 mm with rounded corners: roughed around with 1 mm left, then finished, D12, climb milled."""
    out = head("CONTOUR", "T2 D=12 - flat end mill", tool=2, speed=9000)
    for left, feed in ((1.0, 1200), (0.0, 900)):
        off = 6.0 + left  # centre of the cutter from the boss
        x0, y0, x1, y1, corner = 20.0 - off, 20.0 - off, 120.0 + off, 80.0 + off, 10.0 + off
        out += [f"G0 X{x0 - 20:g} Y50", f"Z{SAFE:g}", "G1 Z-8 F800", f"X{x0:g} F{feed}"]
        out += [f"Y{y1 - corner:g}", f"G2 X{x0 + corner:g} Y{y1:g} I{corner:g} J0", f"G1 X{x1 - corner:g}"]
        out += [f"G2 X{x1:g} Y{y1 - corner:g} I0 J{-corner:g}", f"G1 Y{y0 + corner:g}"]
        out += [f"G2 X{x1 - corner:g} Y{y0:g} I{-corner:g} J0", f"G1 X{x0 + corner:g}"]
        out += [f"G2 X{x0:g} Y{y0 + corner:g} I0 J{corner:g}", "G1 Y52", f"X{x0 - 20:g}", f"G0 Z{SAFE:g}"]
    return [*out, "M5", "M30"]


def wave_stock() -> bytes:
    """An OBJ of the block of 200 x 150 mm under the wave of make_example.py, with LEFT mm on it."""
    xs, ys = (np.linspace(-LEFT, size + LEFT, round(size / PITCH) + 2) for size in (200.0, 150.0))
    x, y = np.meshgrid(xs, ys, indexing="ij")
    wave = 5.0 * np.cos(2 * np.pi * x / 110.0) * np.cos(2 * np.pi * y / 170.0)
    top = np.stack([x, y, wave - 9.0 - 3.0 * ((y - 75.0) / 150.0) ** 2 + LEFT], axis=2)
    under = top * [1, 1, 0] + [0, 0, BOTTOM]
    rim = [top[:, 0], top[-1], top[::-1, -1], top[0, ::-1]]  # counterclockwise, seen from above
    low = [under[:, 0], under[-1], under[::-1, -1], under[0, ::-1]]
    facets = [_sheet(top), _sheet(under)[:, ::-1]]
    facets += [_sheet(np.stack([b, t], axis=1)) for b, t in zip(low, rim, strict=True)]
    return _obj(np.concatenate(facets))


def _sheet(points: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Facets (T, 3, 3) of a grid of points (n, m, 3)."""
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    return np.concatenate([np.stack([a, b, c], axis=2), np.stack([a, c, d], axis=2)]).reshape(-1, 3, 3)


def _obj(facets: npt.NDArray[np.float64]) -> bytes:
    """Each corner once, on a grid of 1 um, so that no libm shows."""
    corner, of = np.unique(np.round(facets.reshape(-1, 3), 3) + 0.0, axis=0, return_inverse=True)
    lines = ["# made by examples/make_jobs.py, BSD-3-Clause"]
    lines += [f"v {x:g} {y:g} {z:g}" for x, y, z in corner]
    lines += [f"f {a} {b} {c}" for a, b, c in of.reshape(-1, 3) + 1]
    return ("\n".join(lines) + "\n").encode()


def head(name: str, tool_words: str, *, tool: int, speed: int) -> list[str]:
    """The lines before the first move."""
    made = "(made by examples/make_jobs.py, BSD-3-Clause)"
    return [f"({name})", made, f"({tool_words})", "G90 G94 G17", "G21", f"T{tool} M6", f"S{speed} M3", "G54"]


def main() -> None:
    """Write the files."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--out", type=Path, default=Path(__file__).parent)
    folder = parser.parse_args().out
    for name, lines in (("pocket", pocket()), ("contour", contour())):
        (folder / f"{name}.nc").write_bytes(("\n".join(lines) + "\n").encode())
    (folder / "wave-stock.obj").write_bytes(wave_stock())


if __name__ == "__main__":
    main()
