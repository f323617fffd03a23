"""Checks: what must agree between the readings of a session, and between the session and its robot."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from stiffness.robot.robot import Robot
from stiffness.session.file import Reflector, Units
from stiffness.session.rigid_arm import placed, rigid_points
from stiffness.session.samples import SAME, Samples
from stiffness.session.table import CsvTable, SessionError

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

_FAR = (0.1, 0.3)  # m from a rigid arm, exact and roughly known reflectors: no arm yields or is off like that
_MANY = 2000  # readings are enough to see that nothing fits


def check_agreement(table: CsvTable, samples: Samples) -> None:
    """Rows of one set-up command the same, rows of one state carry the same, no row stands there twice.

    Raises:
        SessionError: names the row, the row that it contradicts, and the column.
    """
    n = samples.q.shape[1]
    joint = np.arange(1, n + 1)
    first = _first([samples.setup])
    same = "one set-up is one commanded configuration: correct it or give it another set-up"
    _agree(table=table, first=first, names=[f"q{k}" for k in joint], values=samples.q, slack=SAME, why=same)
    if "approach1" in table.cells:
        _agree(
            table=table,
            first=first,
            names=[f"approach{k}" for k in joint],
            values=samples.approach,
            slack=0,
            why=same,
        )
    if "step1" in table.cells:
        _agree(
            table=table,
            first=first,
            names=[f"step{k}" for k in joint],
            values=np.nan_to_num(samples.step),
            slack=SAME,
            why=same,
        )
    first = _first([samples.setup, samples.state])
    one = "one state is one load: correct it or give it another state"
    if "payload" in table.cells:
        _agree(table=table, first=first, names=["payload"], values=samples.payload[:, None], slack=1e-9, why=one)
    if "load_link" in table.cells:
        _agree(table=table, first=first, names=["load_link"], values=samples.load.link[:, None], slack=0, why=one)
    _check_duplicates(table, samples)
    _check_references(table, samples)


def _first(keys: Sequence[Ints]) -> Ints:
    """(N,) the first row with the same keys."""
    _, index, inverse = np.unique(np.column_stack(keys), axis=0, return_index=True, return_inverse=True)
    return np.asarray(index[inverse.reshape(-1)])


def _agree(table: CsvTable, first: Ints, names: Sequence[str], values: Floats | Ints, slack: float, why: str) -> None:
    bad = np.abs(values - values[first]) > slack
    if bad.any():
        row, column = (int(k[0]) for k in np.nonzero(bad))
        other = int(first[row])
        cell = table.cells[names[column]][other]
        table.refuse(bad, names, f"row {table.line[other]} has {cell!r}; {why}")


def _check_duplicates(table: CsvTable, samples: Samples) -> None:
    first = _first([samples.setup, samples.state, samples.reflector, samples.block, samples.repeat])
    again = first != np.arange(len(first))
    if again.any():
        other = table.line[first[int(np.argmax(again))]]
        cure = "number repeats differently" if "repeat" in table.cells else "number them in a column repeat"
        why = f"row {other} reads it in the same set-up and state; {cure}, or take one row out"
        table.refuse(again, ["reflector"], why)


def _check_references(table: CsvTable, samples: Samples) -> None:
    alone = ~np.isin(samples.setup, samples.setup[samples.state == 0])
    if alone.any():
        number = samples.setup[int(np.argmax(alone))]
        why = f"set-up {number} has no reading of state 0, its reference; add it or take the set-up out"
        table.refuse(alone, ["setup"], why)


def check_fit(
    label: str,
    robot: Robot,
    reflectors: tuple[Reflector, ...],
    samples: Samples,
    units: Units,
    registered: bool,
    in_other_frames: Callable[[], Mapping[str, Robot]],
) -> None:
    """Refuse a session whose readings lie nowhere near the arm: wrong unit, frame or robot.

    The measure is the median distance from the reflectors of the rigid arm, where the session is not
    registered after the best placement of every tracker station.

    Args:
        in_other_frames: what the file might have said of base and tip -> the robot with it.

    Raises:
        SessionError: names the change of unit or frame with which it would fit.
    """
    allowed = _FAR[0] if all(r.exact for r in reflectors) else _FAR[1]
    rows = np.unique(np.linspace(0, len(samples) - 1, min(len(samples), _MANY)).astype(int))
    part = samples.take(rows)

    def off_with(q: Floats, scale: float, known: bool, arm: Robot = robot) -> float:
        points = rigid_points(robot=arm, reflectors=reflectors, samples=part, q=q, scale=scale)
        return _misfit(points, part.position * scale, part.block, known)

    off = off_with(part.q, 1.0, registered)
    if off <= allowed:
        return
    turn = np.pi / 180 if units.angle == "rad" else 180 / np.pi
    grow = 1e-3 if units.length == "m" else 1e3
    other = {
        f"units.angle = {'deg' if units.angle == 'rad' else 'rad'!r}": (part.q * turn, 1.0, registered),
        f"units.length = {'mm' if units.length == 'm' else 'm'!r}": (part.q, grow, registered),
        "registered = false": (part.q, 1.0, False),
    }
    fits = [words for words, arm in in_other_frames().items() if off_with(part.q, 1.0, registered, arm) <= allowed]
    fits += [words for words, (q, scale, known) in other.items() if off_with(q, scale, known) <= allowed]
    hint = f"they would fit with {' or '.join(fits)}" if fits else "are robot, base and tip those that were measured?"
    raise SessionError(
        f"{label}: columns x y z: the readings do not fit robot {robot.name}: they lie {off * 1e3:.0f} mm "
        f"(median) from where the rigid arm has its reflectors; {hint}"
    )


def _misfit(points: Floats, position: Floats, block: Ints, registered: bool) -> float:
    distance = np.empty(len(points))
    for number in np.unique(block):
        rows = block == number
        seen = position[rows] if registered else placed(points[rows], position[rows])
        distance[rows] = np.linalg.norm(seen - points[rows], axis=1)
    return float(np.median(distance))
