"""CSV: one row per exported pose, the columns of the public interface. mm, deg, mm/min, N, N m."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain
from pathlib import Path

import numpy as np

from toolpaths.finding import Finding
from toolpaths.rotation import quaternion_from_matrix
from toolpaths.writing.program import Floats, Program

_POSE = ("x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz")
_WRENCH = ("fx_n", "fy_n", "fz_n", "mx_nm", "my_nm", "mz_nm")
_DEFLECTION = ("dx_mm", "dy_mm", "dz_mm")
_KINDS = ("rapid", "cut")


def columns(n_joints: int, external: tuple[str, ...] = ()) -> tuple[str, ...]:
    """Names of the columns for an arm of n joints, and of external axes, such as E1_mm."""
    joints = tuple(f"q{i + 1}_deg" for i in range(n_joints))
    nominal = tuple(f"nominal_{c}" for c in _POSE)
    return ("index", "kind", *_POSE, *joints, "feed_mm_min", *nominal, *_WRENCH, *_DEFLECTION, "source_line", *external)


def findings(program: Program, path: Path) -> Iterator[Finding]:
    """Nothing that every program would not refuse as well."""
    yield from ()


def name_findings(name: str, path: Path, moves: int) -> Iterator[Finding]:
    """Nothing: a table has no name."""
    yield from ()


def files(program: Program, path: Path) -> Iterator[tuple[str, Iterator[str]]]:
    """The one file."""
    yield path.name, _text(program)


def _text(program: Program) -> Iterator[str]:
    n = program.joints.shape[1]
    yield ",".join(columns(n, tuple(f"{axis.name}_{axis.unit}" for axis in program.external))) + "\n"
    joints = ",".join(["%.9f"] * n)
    position, quaternion = "%.6f,%.6f,%.6f", "%.10f,%.10f,%.10f,%.10f"
    wrench = ",".join(["%.6f"] * 6) if program.wrench is not None else "," * 5
    deflection = ",".join(["%.7f"] * 3) if program.deflection is not None else "," * 2
    pose = f"{position},{quaternion}"
    row = f"%d,%s,{pose},{joints},%s,{pose},{wrench},{deflection},%d{',%.6f' * len(program.external)}\n"
    for block in program.blocks():
        yield row * (block.stop - block.start) % tuple(chain.from_iterable(_rows(program, block)))


def _rows(program: Program, block: slice) -> Iterator[tuple[object, ...]]:
    """Values of the rows of one block, as the row's format takes them."""
    command = np.column_stack((
        program.position[block] * 1e3,
        quaternion_from_matrix(program.rotation[block]),
        np.degrees(program.joints[block]),
    ))  # fmt: skip
    rest = _nominal(program, block)
    if program.wrench is not None:
        rest = np.column_stack((rest, program.wrench[block]))
    if program.deflection is not None:
        rest = np.column_stack((rest, program.deflection[block] * 1e3))
    feeds = [f"{f:.6g}" if f == f else "" for f in (program.feed[block] * 6e4).tolist()]
    kinds = [_KINDS[k] for k in program.kind[block].tolist()]
    return zip(
        range(block.start, block.stop), kinds, *(command + 0.0).T.tolist(), feeds,
        *(rest + 0.0).T.tolist(), program.line[block].tolist(),
        *((axis.places[block] + 0.0).tolist() for axis in program.external), strict=True,
    )  # fmt: skip


def _nominal(program: Program, block: slice) -> Floats:
    """(B, 7) where the TCP has to be; the command where nothing else is known."""
    position = program.position if program.nominal_position is None else program.nominal_position
    rotation = program.rotation if program.nominal_rotation is None else program.nominal_rotation
    return np.column_stack((position[block] * 1e3, quaternion_from_matrix(rotation[block])))
