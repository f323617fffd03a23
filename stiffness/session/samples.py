"""Readings of a session: from the cells of samples.csv to SI arrays, every cell checked."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
import numpy.typing as npt

from stiffness.schema import meant
from stiffness.session.file import SessionTool
from stiffness.session.loads import WRENCH, Loads, SessionHeader, read_loads, reflector_index
from stiffness.session.table import CsvTable, SessionError

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

SLACK = 1e-3  # rad beyond a joint limit that rounding of angles and limits explains
FARTHEST_LAG = 0.02  # rad: no servo holds an axis at rest so far from its command
SAME = 2e-6  # rad between the angles of one set-up: the last digit of a display


@dataclass(frozen=True, repr=False, eq=False)
class Samples:
    """N readings in the order of the file; arrays read-only.

    Attributes:
        line: (N,) row in samples.csv, the header being 1.
        setup, state, repeat, block: (N,); repeat and block are 0 without their columns.
        q: (N, n) rad, commanded.
        reflector: (N,) index into the reflectors of the session.
        position: (N, 3) m, in the base or, where the session is not registered, in the tracker's frame.
        sd: (N, 3) m of this reading: sx sy sz, else the tracker's.
        approach: (N, n) -1, 0 unknown, +1: sign of the last commanded rotation.
        step: (N, n) rad, the last commanded move; NaN where not known.
        payload: (N,) kg beside the tool.
        time: (N,) s, NaN without the column. temperature: (N,) deg C, the same.
        load: what pulls.
        extra: further numeric columns, name -> (N,), as written; ``read1`` ...: rad, the angle read back minus q.
    """

    line: Ints
    setup: Ints
    state: Ints
    repeat: Ints
    block: Ints
    q: Floats
    reflector: Ints
    position: Floats
    sd: Floats
    approach: Ints
    step: Floats
    payload: Floats
    time: Floats
    temperature: Floats
    load: Loads
    extra: Mapping[str, Floats]

    def __post_init__(self) -> None:
        for part in (self, self.load):
            for array in (getattr(part, f.name) for f in fields(part)):
                if isinstance(array, np.ndarray):
                    array.setflags(write=False)
        for column in self.extra.values():
            column.setflags(write=False)

    def __len__(self) -> int:
        return len(self.line)

    def __repr__(self) -> str:
        return f"Samples({len(self)} readings, {len(np.unique(self.setup))} set-ups)"

    def take(self, rows: Ints | Bools) -> Samples:
        """Some of the readings, by index or mask, in the given order."""
        mine = {f.name: getattr(self, f.name)[rows] for f in fields(self) if f.name not in ("load", "extra")}
        load = Loads(**{f.name: getattr(self.load, f.name)[rows] for f in fields(Loads)})
        return replace(self, **mine, load=load, extra={k: v[rows] for k, v in self.extra.items()})


def read_samples(table: CsvTable, header: SessionHeader) -> tuple[Samples, tuple[str, ...]]:
    """The readings, and the names of columns that are no regressors because cells of theirs are no numbers.

    Raises:
        SessionError: names file, row, column, value and what to do.
    """
    n = header.robot.n
    known = _check_columns(table, header)
    per_joint = {stem: [f"{stem}{k + 1}" for k in range(n)] for stem in ("q", "approach", "step", "read")}
    setup, state = table.integers(["setup", "state"]).T
    table.refuse(state < 0, ["state"], "a load step is 0 (the reference) or above")
    approach, step = _approach(table, per_joint["approach"], per_joint["step"], header.units.radian)
    q = _angles(table, per_joint["q"], header)
    extra = {name: table.numeric(name) for name in table.cells if name not in known}
    extra |= _lag(table, per_joint["read"], q, header.units.radian)
    samples = Samples(
        line=table.line,
        setup=setup,
        state=state,
        repeat=_column(table, "repeat"),
        block=_column(table, "block"),
        q=q,
        reflector=reflector_index(table, "reflector", header),
        position=table.numbers(["x", "y", "z"]) * header.units.metre,
        sd=_noise(table, header),
        approach=approach,
        step=step,
        payload=_payload(table, header.tool),
        time=_optional(table, "time"),
        temperature=_temperature(table),
        load=read_loads(table, header),
        extra={name: values for name, values in extra.items() if values is not None},
    )
    return samples, tuple(name for name, values in extra.items() if values is None)


def _check_columns(table: CsvTable, header: SessionHeader) -> set[str]:
    n = header.robot.n
    needed = ["setup", "state", *(f"q{k + 1}" for k in range(n)), "reflector", "x", "y", "z"]
    optional = ["load_link", "load_at", "block", "sx", "sy", "sz", "time", "temperature", "payload", "repeat", "reseat"]
    optional += [*WRENCH, *(f"{stem}{k + 1}" for stem in ("approach", "step", "read") for k in range(n))]
    known = {*needed, *optional}
    for name in table.cells:
        joint = re.fullmatch(r"(q|approach|step|read)(\d+)", name)
        if joint and name not in known:
            raise SessionError(
                f"{table.label}: column {name}: robot {header.robot.name} has {n} joints; "
                "is it the robot that was measured?"
            )
        if name not in known and name.lower() in known:
            raise SessionError(f"{table.label}: column {name}: write {name.lower()}")
    missing = [name for name in needed if name not in table.cells]
    if missing:
        hint = meant(missing[0], [name for name in table.cells if name not in known])
        raise SessionError(f"{table.label}: column {', '.join(missing)} missing{hint or '; add it'}")
    return known


def _column(table: CsvTable, name: str) -> Ints:
    return table.integers([name])[:, 0] if name in table.cells else np.zeros(len(table.line), dtype=np.int64)


def _optional(table: CsvTable, name: str) -> Floats:
    return table.numbers([name])[:, 0] if name in table.cells else np.full(len(table.line), np.nan)


def _temperature(table: CsvTable) -> Floats:
    values = _optional(table, "temperature")
    table.refuse((values < -60) | (values > 150), ["temperature"], "not deg C of a robot; kelvin?")
    return values


def _angles(table: CsvTable, names: Sequence[str], header: SessionHeader) -> Floats:
    robot, unit = header.robot, header.units.angle
    q = table.numbers(names) * header.units.radian
    outside = (q < robot.lower - SLACK) | (q > robot.upper + SLACK)
    if outside.any():
        joint = int(np.nonzero(outside)[1][0])
        low, high = (float(limit[joint]) / header.units.radian for limit in (robot.lower, robot.upper))
        degrees = unit == "rad" and np.abs(q).max() > 4 * np.pi
        hint = "these look like degrees: correct units.angle" if degrees else f"is it the {robot.name}?"
        why = f"outside the limits {low:.6g} ... {high:.6g} {unit} of joint {joint + 1}; correct it; {hint}"
        table.refuse(outside, names, why)
    return q


def _lag(table: CsvTable, names: Sequence[str], q: Floats, radian: float) -> dict[str, Floats]:
    """The angles read back minus those commanded, rad, by column; where the links are is counted from the commanded."""
    if not table.has(names):
        return {}
    lag = table.numbers(names) * radian - q
    why = f"more than {np.degrees(FARTHEST_LAG):.2g} deg from the commanded angle of the same row; correct one of them"
    table.refuse(np.abs(lag) > FARTHEST_LAG, names, why)
    return {name: lag[:, k].copy() for k, name in enumerate(names)}


def _approach(table: CsvTable, signs: Sequence[str], sizes: Sequence[str], radian: float) -> tuple[Ints, Floats]:
    """Sign and size of the last move; where the size alone is given, the sign is its own."""
    shape = (len(table.line), len(signs))
    step = table.numbers(sizes) * radian if table.has(sizes) else np.full(shape, np.nan)
    if not table.has(signs):
        return np.sign(np.nan_to_num(step)).astype(np.int64), step
    approach = table.integers(signs)
    table.refuse(np.abs(approach) > 1, signs, "expected -1, 0 (unknown) or 1")
    table.refuse(approach * step < 0, signs, "the step of this joint has the opposite sign; correct one of them")
    return approach, step


def _noise(table: CsvTable, header: SessionHeader) -> Floats:
    names = ["sx", "sy", "sz"]
    if not table.has(names):
        return np.full((len(table.line), 3), header.tracker)
    sd = table.numbers(names)
    table.refuse(sd <= 0, names, f"a standard deviation is above zero, in {header.units.length}")
    return sd * header.units.metre


def _payload(table: CsvTable, tool: SessionTool | None) -> Floats:
    if "payload" not in table.cells:
        return np.zeros(len(table.line))
    payload = table.numbers(["payload"])[:, 0]
    table.refuse(payload < 0, ["payload"], "a mass, kg, is not negative")
    if tool is None or tool.com is None:
        table.refuse(payload > 0, ["payload"], "hangs at the tool's com, and [tool] gives none: add tool.com")
    return payload
