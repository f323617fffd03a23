"""The part closes the loop: a first part is cut and measured, what the model lacks is diagnosed, a second part is cut.

`python -m tests.first_part` prints the table of docs/first-part.md and draws its picture. The plant, which shares no
code with the product, cuts both parts.
"""

from __future__ import annotations

import csv
import dataclasses
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from compensator.tasks.compensate import compensate_file
from compensator.tasks.diagnose import diagnose_files
from tests.compensator.plant_bench import MM, Bench, Table, write_poses
from tests.plant.geometry import Array
from tests.trace_bench import Ran, surface

K = [3.0e6, 2.7e6, 2.1e6, 4.2e5, 1.4e5, 5.6e4]
NOISE = 0.003  # mm, of the measuring machine
CORNERS = np.array([[-150, -100], [150, -100], [150, 100], [-150, 100], [-150, -100]], dtype=float)
OUT = np.array([[0, -1, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0]], dtype=float)
EACH = 40  # points on a wall
ENLARGED = 100.0  # in the picture


@dataclass(frozen=True)
class Cause:
    """What is not as the model has it: arguments of the plant, and a factor on the force."""

    name: str
    force: float = 1.0
    plant: Mapping[str, Any] = dataclasses.field(default_factory=dict)


CAUSES = (
    Cause("coefficients of the material 25 % too small", force=1.25),
    Cause("joint 1 softer by 30 %", plant={"stiffness": [2.1e6, *K[1:]]}),
    Cause("both: coefficients and a gap", force=1.25, plant={"gap": [1.2e-4, 0, 0, 0, 0, 0], "breakaway": 1e9}),
    Cause("a gap of 0.12 mrad in joint 1", plant={"gap": [1.2e-4, 0, 0, 0, 0, 0], "breakaway": 1e9}),
)


@dataclass(frozen=True)
class Part:
    """Walls of a part as they were cut, see ``Loop``."""

    place: Array
    normal: Array
    deviation: Array

    @property
    def rms(self) -> float:
        """um."""
        return float(np.sqrt(np.mean(self.deviation**2))) * 1e3


@dataclass(frozen=True)
class Loop:
    """What was found, and the ``deviation`` (N,) mm of the walls of both parts along ``normal`` (N, 3) at ``place``
    (N, 3) mm: the first part, the second."""

    cause: Cause
    parts: tuple[Part, Part]
    found: str
    verdict: str

    @property
    def gone(self) -> float:
        """Share of what the first part showed (RMS) that the second does not."""
        first, second = self.parts
        return 1 - second.rms / first.rms


def walls() -> tuple[Array, Array]:
    """(N, 3) mm and outward normals of the contour."""
    wall, share = np.repeat(np.arange(4), EACH), np.tile(np.arange(EACH) / EACH, 4)[:, None]
    spots = CORNERS[wall] + share * (CORNERS[wall + 1] - CORNERS[wall])
    return np.column_stack([spots, np.zeros(len(spots))]), OUT[wall]


def cell(folder: Path) -> Bench:
    """The contour is cut both ways round, with an uneven allowance; the shop's own stiffness model."""
    place, normal = walls()
    load = 150 * (1 + 0.6 * np.sin(2 * np.pi * np.arange(len(place)) / 37))
    pull = -load[:, None] * normal - 0.5 * load[:, None] * np.cross([0, 0, 1], normal) - [0, 0, 60]
    back = -load[:, None] * normal + 0.5 * load[:, None] * np.cross([0, 0, 1], normal) - [0, 0, 60]
    with open(folder / "w.csv", "w", newline="") as stream:
        table = csv.writer(stream)
        table.writerow(["index", "fx", "fy", "fz", "mx", "my", "mz"])
        table.writerows([k, *row, 0, 0, 0] for k, row in enumerate(np.vstack([pull, back[::-1]])))
    return Bench(
        folder,
        "abb-irb6600-175-255",
        {"joint-stiffness": {"k_nm_per_rad": K}},
        {"xyz": [1500.0, 0.0, 900.0], "rpy": [0.0, 0.0, 0.0]},
        {"kind": "table", "frame": "base", "file": "w.csv", "material": "aluminium"},
        start=[0.0, 10.0, 20.0, 0.0, 60.0, 0.0],
    )


def cut(bench: Bench, toolpath: Path, cause: Cause, name: str) -> Ran:
    """Compensate with the model of the cell, and let the plant cut."""
    program = bench.folder / f"{name}.csv"
    compensate_file(toolpath, bench.folder / "cell.toml", program)
    return ran(bench, program, cause)


def ran(bench: Bench, program: Path, cause: Cause) -> Ran:
    """The plant cuts by a program."""
    table = Table.read(program)
    walk = bench.plant(**cause.plant).walk(table.q, cause.force * table.wrench, start=bench.q_start)
    return Ran(bench, program, table, walk)


def part(ran: Ran, normal: Array) -> Part:
    """What was cut, no noise."""
    nominal, rows = ran.bench.in_base(ran.table.nominal)[:, :3, 3], ran.table.cut
    off = np.sum((ran.tcp - nominal) @ ran.bench.base_work[:3, :3] * normal, axis=1) / MM
    return Part(ran.table.nominal[rows, :3, 3] / MM, normal[rows], off[rows])


def toolpath_of(folder: Path) -> tuple[Path, Array, Array]:
    """path.csv, the contour both ways round; (R, 3) mm its poses and their outward normals."""
    place, normal = walls()
    there, side = np.vstack([place, place[::-1]]), np.vstack([normal, normal[::-1]])
    rows = [[*p.round(6), 0, 0, 1, 1000.0, "cut" if k else "rapid"] for k, p in enumerate(there)]
    return write_poses(folder / "path.csv", rows), there, side


def measured(one: Ran, there: Array, side: Array) -> Path:
    """part.toml and part-samples.csv of a part that was cut."""
    return surface(one, NOISE, _at(one, there, side), name="part")


def refined(cell_file: Path) -> None:
    """The cell, with the model that diagnose wrote."""
    cell_file.write_text(cell_file.read_text().replace('"model.toml"', '"refined.toml"'))


def loop(folder: Path, cause: Cause) -> Loop:
    """First part, measurement, diagnosis, second part."""
    bench = cell(folder)
    bench.cell()
    toolpath, there, side = toolpath_of(folder)
    one = cut(bench, toolpath, cause, "first")
    done = diagnose_files([measured(one, there, side)], folder / "model.toml", folder / "refined.toml")
    refined(folder / "cell.toml")
    two = cut(bench, toolpath, cause, "second")
    return Loop(
        cause=cause,
        parts=(part(one, _at(one, there, side)), part(two, _at(two, there, side))),
        found=_words(done.report),
        verdict=done.report["verdict"],
    )


def _at(ran: Ran, place: Array, normal: Array) -> Array:
    """(R, 3) normals at the rows of a program, which may have poses put in: of the nearest place in order."""
    at = ran.table.nominal[:, :3, 3] / MM
    out, k = np.zeros_like(at), 0
    for row, p in enumerate(at):
        while k + 1 < len(place) and np.linalg.norm(place[k + 1] - p) < np.linalg.norm(place[k] - p) + 1e-9:
            k += 1
        out[row] = normal[k]
    return out


def _words(report: Mapping[str, Any]) -> str:
    new = [f"`{a['effect']}` {_numbers(a)}" for a in report["added"]]
    changed = [f"`{c['effect']}` of {', '.join(c['where'])}: {c['to'] / c['from'] - 1:+.0%}" for c in report["changed"]]
    return "; ".join(new + changed) or "nothing"


def _numbers(added: Mapping[str, Any]) -> str:
    shown = {k: p["value"] for k, p in added["parameters"].items() if k not in ("side", "breakaway_nm")}
    return ", ".join(f"{k} {np.round(v, 3) if np.max(np.abs(v)) > 1e-2 else f'{v:.3g}'}" for k, v in shown.items())


def draw(loops: list[Loop], path: Path) -> None:
    """Deviations as arrows on the part, enlarged: the first part and the second."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(2, len(loops), figsize=(4.2 * len(loops), 6.4), constrained_layout=True)
    for column, done in enumerate(loops):
        for row, (one, what) in enumerate(zip(done.parts, ("first part", "second part"), strict=True)):
            a, tip = axes[row, column], one.place + ENLARGED * one.deviation[:, None] * one.normal
            a.plot(*np.vstack([CORNERS, CORNERS[:1]]).T, color="0.6", lw=1)
            shown = np.stack([one.place[:, :2], tip[:, :2]], axis=1)
            for line in shown:
                a.plot(*line.T, color="tab:red" if row == 0 else "tab:green", lw=0.8)
            a.set(aspect="equal", xlim=(-205, 205), ylim=(-150, 150))
            title = f"{what}: {one.rms:.1f} um RMS"
            a.set_title(title if row else f"{done.cause.name}\n{title}", size=9)
            a.tick_params(labelsize=7)
    figure.suptitle(f"Deviation of the walls, enlarged {ENLARGED:g} times, mm", size=10)
    figure.savefig(path, dpi=110)


def main() -> int:
    loops = []
    for cause in CAUSES:
        with tempfile.TemporaryDirectory() as folder:
            done = loop(Path(folder), cause)
        first, second = done.parts
        print(f"| {cause.name} | {first.rms:.1f} | {done.found} | {second.rms:.1f} | {done.gone:.1%} |", flush=True)
        loops.append(done)
    draw(loops, Path(__file__).parents[1] / "docs" / "images" / "first-part.png")
    return 0


if __name__ == "__main__":
    sys.exit(main())
