"""Force tests: what a shop or a laboratory measured while cutting. Reads the csv file of ``cutting``."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from pydantic import ValidationError

from compensator.errors import CompensatorError
from compensator.process.milling.arc import arc_shares
from compensator.process.milling.cutter import Cutter
from compensator.process.milling.cutter_table import CutterTable
from stiffness.schema import findings

Floats = npt.NDArray[np.float64]

WORDS = ("shape",)
NEEDED = ("shape", "diameter_mm", "flutes", "ap_mm", "entry_deg", "exit_deg", "feed_per_tooth_mm")
FORCES = ("fx_n", "fy_n", "fz_n")
POWER = ("power_w", "spindle_rpm")
SHAPE_KEYS = {"corner_radius_mm": "corner_radius", "half_angle_deg": "half_angle", "point_angle_deg": "point_angle"}
OPTIONAL = (*SHAPE_KEYS, "spindle_rpm")


@dataclass(frozen=True)
class ForceTest:
    """One row: a cutter, what of it was engaged, and what was measured; SI.

    Attributes:
        line: of the file.
        ap: m; arc: rad, entry and exit; feed: m per tooth; spindle: rev/s, or None.
        force: (3,) N on the tool in path axes, or None; power: W of the cut alone, or None.
    """

    line: int
    cutter: Cutter
    ap: float
    arc: tuple[float, float]
    feed: float
    spindle: float | None
    force: Floats | None
    power: float | None

    def rows(self) -> tuple[Floats, Floats, npt.NDArray[np.str_]]:
        """(R, 6) factors of the coefficients, (R,) what was measured, (R,) its kind: ``N`` or ``W``."""
        shares = arc_shares(self.cutter, self.ap, self.arc, self.feed)
        factors, measured, kinds = [], [], []
        if self.force is not None:
            factors += list(shares[:3])
            measured += self.force.tolist()
            kinds += ["N"] * 3
        if self.power is not None and self.spindle is not None:
            factors.append(-shares[5] * 2.0 * np.pi * self.spindle)
            measured.append(self.power)
            kinds.append("W")
        return np.array(factors), np.array(measured), np.array(kinds)


def read_force_tests(path: Path) -> list[ForceTest]:
    """The rows of a csv file.

    Raises:
        CompensatorError: names the file, the line, the column, the value and what was expected.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            reader = csv.reader(file)
            header = [c.strip() for c in next(reader, [])]
            _check_header(path, header)
            listed = [(reader.line_num, row) for row in reader if any(c.strip() for c in row)]
    except (OSError, UnicodeDecodeError, csv.Error) as e:
        raise CompensatorError(f"{path}: cannot read the force tests: {e}") from e
    if not listed:
        raise CompensatorError(f"{path}: the table has no rows")
    return [_test(path, line, header, row) for line, row in listed]


def _check_header(path: Path, header: list[str]) -> None:
    known = {*NEEDED, *FORCES, *POWER, *OPTIONAL}
    unknown = [c for c in header if c not in known]
    if unknown:
        listed = ", ".join(map(repr, unknown))
        raise CompensatorError(f"{path}:1: unknown column {listed}; known: {', '.join(sorted(known))}")
    twice = sorted({c for c in header if header.count(c) > 1})
    if twice:
        raise CompensatorError(f"{path}:1: column {', '.join(twice)} stands there twice")
    missing = [c for c in NEEDED if c not in header]
    if any(c in header for c in FORCES):
        missing += [c for c in FORCES if c not in header]
    elif "power_w" not in header:
        missing += ["fx_n, fy_n, fz_n (or power_w with spindle_rpm)"]
    if "power_w" in header and "spindle_rpm" not in header:
        missing.append("spindle_rpm, which power_w needs")
    if missing:
        raise CompensatorError(f"{path}:1: missing column {', '.join(missing)}")


def _test(path: Path, line: int, header: list[str], row: list[str]) -> ForceTest:
    if len(row) != len(header):
        raise CompensatorError(f"{path}:{line}: {len(row)} cells; the header has {len(header)} columns")
    cells = {name: cell.strip() for name, cell in zip(header, row, strict=True)}
    values = {name: _number(path, line, name, cell) for name, cell in cells.items() if name not in WORDS and cell}
    for name in (*NEEDED, *(f for f in FORCES if f in header and "power_w" not in header)):
        if not cells.get(name):
            raise CompensatorError(f"{path}:{line}: {name} is empty")
    for name in ("ap_mm", "feed_per_tooth_mm"):
        if not values[name] > 0:
            raise CompensatorError(f"{path}:{line}: {name} = {values[name]:g}; above 0 is expected")
    entry, exit = values["entry_deg"], values["exit_deg"]
    if not -180 <= entry < exit <= 180:
        given = f"entry_deg = {entry:g}, exit_deg = {exit:g}"
        raise CompensatorError(f"{path}:{line}: {given}; -180 <= entry < exit <= 180 is expected")
    force = [values[f] for f in FORCES if f in values]
    if len(force) not in (0, 3):
        raise CompensatorError(f"{path}:{line}: {', '.join(FORCES)}: give all three or none of them")
    power, rpm = values.get("power_w"), values.get("spindle_rpm")
    if power is not None and not (rpm or 0.0) > 0:
        raise CompensatorError(f"{path}:{line}: spindle_rpm = {rpm}; power_w needs one above 0")
    if not force and power is None:
        raise CompensatorError(f"{path}:{line}: neither a force nor a power is given")
    return ForceTest(
        line, _cutter(path, line, cells["shape"], values), values["ap_mm"] * 1e-3,
        arc=(float(np.radians(entry)), float(np.radians(exit))), feed=values["feed_per_tooth_mm"] * 1e-3,
        spindle=None if rpm is None else rpm / 60.0, force=np.array(force) if force else None, power=power,
    )  # fmt: skip


def _number(path: Path, line: int, name: str, cell: str) -> float:
    try:
        value = float(cell)
    except ValueError as e:
        raise CompensatorError(f"{path}:{line}: {name} = {cell!r}; a number is expected") from e
    if not np.isfinite(value):
        raise CompensatorError(f"{path}:{line}: {name} = {cell!r}; a finite number is expected")
    return value


def _cutter(path: Path, line: int, shape: str, values: dict[str, float]) -> Cutter:
    """The cutter of a row; its edge is as long as the cut is high."""
    if values["flutes"] != int(values["flutes"]):
        raise CompensatorError(f"{path}:{line}: flutes = {values['flutes']:g}; a whole number is expected")
    table: dict[str, object] = {key: values[column] for column, key in SHAPE_KEYS.items() if column in values}
    table |= {"shape": shape, "diameter": values["diameter_mm"], "flutes": int(values["flutes"])}
    length = max(values["ap_mm"], values["diameter_mm"])
    try:
        return CutterTable.model_validate({**table, "length": length}).cutter()
    except ValidationError as e:
        raise CompensatorError(f"{path}:{line}: " + "; ".join(str(f) for f in findings(e))) from e
