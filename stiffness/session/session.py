"""Session: what a lab measured, read from files of schema ``measurement-session/1``.

All checks stand at this door: what comes out is in SI, complete, and agrees with itself and with its robot.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from stiffness.errors import RobotError
from stiffness.robot.load import load_robot
from stiffness.robot.robot import STANDARD_GRAVITY, Robot
from stiffness.session.checks import check_agreement, check_fit
from stiffness.session.file import (
    Instruments,
    Purpose,
    Reflector,
    SessionFile,
    SessionTool,
    instruments,
    purposes,
    read_file,
    reflectors,
    tool,
)
from stiffness.session.loads import SessionHeader
from stiffness.session.path_trace import PathTrace
from stiffness.session.reseat import reseated
from stiffness.session.samples import Samples, read_samples
from stiffness.session.table import SessionError, read_table
from stiffness.session.views import LoadStates, Pairs, load_states, pairs_of
from stiffness.text_file import file_bytes

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]
Array = TypeVar("Array", Floats, Ints, Bools)


@dataclass(frozen=True, repr=False, eq=False)
class Session:
    """A measurement session, in SI.

    Attributes:
        source: session.toml, as the user named it.
        samples_file: samples.csv, the same.
        sha256: of both files, by ``session`` and ``samples``.
        robot: the arm; ``robot_name`` as in the file.
        base, tip: as in the file; None: the robot's own.
        gravity: ``uncompensated`` or ``calibrated-out``.
        registered: positions are in the base; else in the tracker's frame, one per block.
        reference_temperature: deg C; None: not given.
        tool: without [tool] the bare flange, of unknown mass.
        wrench_frame, wrench_about: as in [wrench]; None where the samples have no wrench.
        reflectors: in the order of the file.
        instruments: noise.
        purposes: set-up -> what it is for, where the file has it.
        samples: the readings.
        not_numeric: columns that are no regressors because cells of theirs are no finite numbers.
        path: of a trace, the commanded path that its readings belong to; None: a session of set-ups.
    """

    source: str
    samples_file: str
    sha256: Mapping[str, str]
    robot: Robot
    robot_name: str
    base: str | None
    tip: str | None
    gravity: str
    registered: bool
    reference_temperature: float | None
    tool: SessionTool
    wrench_frame: str | None
    wrench_about: str | None
    reflectors: tuple[Reflector, ...]
    instruments: Instruments
    purposes: Mapping[int, Purpose]
    samples: Samples
    not_numeric: tuple[str, ...]
    path: PathTrace | None = None

    def __repr__(self) -> str:
        evidence = {"displacement": self.has_displacement, "absolute": self.has_absolute and self.path is None}
        evidence["path"] = self.path is not None
        kinds = " and ".join(kind for kind, there in evidence.items() if there) or "none"
        return (
            f"Session({self.source!r}, {self.robot.name}, {len(np.unique(self.samples.setup))} set-ups, "
            f"{len(self.states)} states, {len(self.samples)} readings, evidence: {kinds})"
        )

    def __len__(self) -> int:
        """Number of readings."""
        return len(self.samples)

    @property
    def has_wrench(self) -> bool:
        """Whether the samples have a wrench."""
        return self.wrench_frame is not None

    def take(self, rows: Ints | Bools) -> Session:
        """The session as if only these readings had been made. Views are made anew."""
        path = None if self.path is None else self.path.take(rows)
        return replace(self, samples=self.samples.take(rows), path=path)

    @property
    def gravity_in_base(self) -> Floats:
        """(3,) m/s2: the base stands upright, but where a cell has it otherwise."""
        return np.array(STANDARD_GRAVITY) if self.path is None else self.path.gravity

    @property
    def numbers_each(self) -> int:
        """How many numbers a reading is: a point is three; of one number it is the first of the position."""
        return 1 if self.path is not None and self.path.scalar else 3

    @cached_property
    def states(self) -> LoadStates:
        """The load states."""
        return load_states(self.samples)

    @cached_property
    def sensor_reading(self) -> Ints:
        """(N,) number of the reading of the force sensor: rows of one state that show one and the same wrench
        share one, and its noise."""
        keys = np.column_stack([self.samples.setup, self.samples.state, self.samples.load.wrench])
        return _still(np.unique(keys, axis=0, return_inverse=True)[1].reshape(-1).astype(np.int64))

    @cached_property
    def pairs(self) -> Pairs:
        """The displacements: pairs of readings."""
        return pairs_of(self.samples)

    @property
    def has_displacement(self) -> bool:
        """Whether there is a loaded reading with a reference."""
        return len(self.pairs) > 0

    @cached_property
    def has_absolute(self) -> bool:
        """Whether there are more positions than it takes to place the trackers and reflectors that are not known."""
        stations = 0 if self.registered else 6 * len(np.unique(self.samples.block))
        if self.path is not None and self.path.kind == "ballbar":
            stations = 3 if self.path.calibrated else 4
        seen = [self.reflectors[k] for k in np.unique(self.samples.reflector)]
        single = sum(not r.exact and r.group is None for r in seen)
        groups = {r.group for r in seen if not r.exact and r.group is not None}
        return self._numbers_read > stations + 3 * single + 6 * len(groups)

    @property
    def _numbers_read(self) -> int:
        """Independent numbers: three per reading; of a group in one state five for two readings, at most six."""
        s, group = self.samples, self.group
        if self.path is not None:
            return len(s) * self.numbers_each
        free = int(np.sum(group[s.reflector] < 0))
        probe = group[s.reflector] >= 0
        key = np.column_stack([s.setup, s.state, s.block, s.repeat, group[s.reflector]])[probe]
        _, members = np.unique(key, axis=0, return_counts=True)
        return 3 * free + int(np.where(members == 2, 5, np.minimum(3 * members, 6)).sum())

    @cached_property
    def group(self) -> Ints:
        """(reflectors,) number of the group of each reflector; -1 without a group."""
        names = list(dict.fromkeys(r.group for r in self.reflectors if r.group is not None))
        return _still(np.array([-1 if r.group is None else names.index(r.group) for r in self.reflectors]))

    @cached_property
    def counts(self) -> Bools:
        """(N,) readings that an RMS counts: of a group only its first reflector, the probe's origin."""
        first = np.array([g < 0 or k == list(self.group).index(g) for k, g in enumerate(self.group)])
        return _still(np.asarray(first[self.samples.reflector]))


def _still(array: Array) -> Array:
    array.setflags(write=False)
    return array


def load_session(path: str | Path) -> Session:
    """Read a session with its samples and its robot.

    Raises:
        SessionError: names file, row (the line in samples.csv), column, value, and what to do.
    """
    label, folder = str(path), Path(path).parent
    raw = file_bytes(label, Path(path), SessionError)
    file = read_file(label, raw)
    robot = _robot(label, file, folder)
    known, held = reflectors(label, file, robot.n), tool(label, file)
    csv_label = str(folder / file.samples)
    raw_samples = file_bytes(f"{label}: samples = {file.samples!r}", folder / file.samples, SessionError)
    table = read_table(csv_label, raw_samples)
    tracker = file.instruments.tracker * file.units.metre
    samples, not_numeric = read_samples(
        table,
        SessionHeader(
            label=label,
            robot=robot,
            units=file.units,
            tool=held,
            wrench=file.wrench,
            reflectors=known,
            tracker=tracker,
        ),
    )
    check_agreement(table, samples)
    samples, seats = reseated(table, samples, known)
    sensed = "fx" in table.cells
    check_fit(
        label=csv_label,
        robot=robot,
        reflectors=seats,
        samples=samples,
        units=file.units,
        registered=file.registered,
        in_other_frames=lambda: _in_other_frames(file, folder, robot),
    )
    return Session(
        source=label,
        samples_file=csv_label,
        sha256={
            "session": hashlib.sha256(raw).hexdigest(),
            "samples": hashlib.sha256(raw_samples).hexdigest(),
        },
        robot=robot,
        robot_name=file.robot,
        base=file.base,
        tip=file.tip,
        gravity=file.gravity,
        registered=file.registered,
        reference_temperature=file.reference_temperature,
        tool=held or SessionTool(
            name="tool",
            rotation=_still(np.eye(3)),
            position=_still(np.zeros(3)),
            mass=None,
            com=None,
        ),
        wrench_frame=file.wrench.frame if file.wrench and sensed else None,
        wrench_about=file.wrench.about if file.wrench and sensed else None,
        reflectors=seats,
        instruments=instruments(label, file, sensed),
        purposes=purposes(label, file, known, robot.n),
        samples=samples,
        not_numeric=not_numeric,
    )


def _robot(label: str, file: SessionFile, folder: Path) -> Robot:
    # A built-in robot's flange is its maker's tool0 (interface.md, Frames): naming it changes nothing.
    links = file.robot.endswith(".urdf")
    tip = None if file.tip == "tool0" and not links else file.tip
    try:
        robot = load_robot(file.robot, folder=folder, base=file.base, tip=tip)
    except RobotError as error:
        raise SessionError(f"{label}: robot = {file.robot!r}: {error}") from error
    if file.gravity == "uncompensated" and robot.mass is None:
        raise SessionError(
            f"{label}: gravity = 'uncompensated' needs the masses of the links: {robot.mass_problem}; take a "
            "robot file with masses, or gravity = 'calibrated-out' if the controller knows the sag"
        )
    return robot


def _in_other_frames(file: SessionFile, folder: Path, robot: Robot) -> dict[str, Robot]:
    """Keys that name the frames that the controller measures from, where the file names none -> the robot with them."""
    frames = (("base", robot.base_frame), ("tip", robot.flange_frame))
    named = {key: frame.name for key, frame in frames if frame is not None and frame.away}
    given = {"base": file.base, "tip": file.tip}
    asked = [{key: name} for key, name in named.items()] + ([named] if len(named) > 1 else [])
    return {
        " and ".join(f'{key} = "{name}"' for key, name in keys.items()): load_robot(
            file.robot, folder=folder, **{**given, **keys}
        )
        for keys in asked
    }


def count_setups(sessions: Iterable[Session]) -> int:
    """Set-ups of all sessions together."""
    return sum(len(np.unique(s.samples.setup)) for s in sessions)


def traces_alone(sessions: Iterable[Session]) -> bool:
    """Whether there are traces and no session of set-ups."""
    return all(s.path is not None for s in sessions)
