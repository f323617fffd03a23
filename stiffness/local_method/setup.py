"""Set-ups that the local method is made from: their purpose, their points A, B, C, their loaded states.

Displacements are differences of means over all repeats (paper, section 5: "mean values").
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.local_method.arm import Force, LocalArm, Stance
from stiffness.session.session import Session
from stiffness.session.table import SessionError

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

NEEDED = ("A", "A", "A", "AB", "ABC", "A")  # points of joints 1 to 6 in the paper's equations


@dataclass(frozen=True, repr=False, eq=False)
class Point:
    """A reflector that plays A, B or C: ``where`` (3,) m in the base, on ``link``; ``jacobian`` (3, n) m/rad."""

    name: str
    link: int
    where: Floats
    jacobian: Floats


@dataclass(frozen=True, repr=False, eq=False)
class PointReadings:
    """Readings of one point in one state: ``single`` (R, 3) m, their mean, and the variance (3,) of the mean."""

    single: Floats
    mean: Floats
    variance: Floats


@dataclass(frozen=True, repr=False, eq=False)
class StateReadings:
    """A load state: mean force, ``sensed`` times read, ``turns`` (n, 6) joint torques per unit of it, readings of
    the points, ``trouble`` that keeps it out (in words)."""

    number: int
    force: Force
    sensed: int
    turns: Floats
    readings: Mapping[str, PointReadings]
    trouble: str

    @property
    def torque(self) -> Floats:
        """(n,) N*m, J^T W at the commanded posture."""
        return np.asarray(self.turns @ self.force.wrench)


@dataclass(frozen=True, repr=False, eq=False)
class LocalSetup:
    """A set-up made for one joint, complete.

    Attributes:
        joint: counted from 0.
        at: the arm in state 0.
        approach: (n,) sign of the last rotation.
        points: by letter.
        reference: state 0; ``loaded``: the others, in order.
        noise: (6,) variance of one reading of the sensor.
    """

    session: Session
    number: int
    joint: int
    arm: LocalArm
    at: Stance
    approach: npt.NDArray[np.int64]
    points: Mapping[str, Point]
    reference: StateReadings
    loaded: tuple[StateReadings, ...]
    noise: Floats

    @property
    def place(self) -> str:
        """How messages call it."""
        return f"{self.session.source}: [setups.{self.number}]"

    def displacement(self, state: StateReadings, point: str) -> Floats:
        """(3,) m, of a point, loaded minus reference."""
        return np.asarray(state.readings[point].mean - self.reference.readings[point].mean)

    def singles(self, state: StateReadings, point: str) -> Floats:
        """(R, 3) m, displacements of single readings, in the order of reading."""
        loaded, rest = state.readings[point].single, self.reference.readings[point].single
        count = min(len(loaded), len(rest))
        return np.asarray(loaded[:count] - rest[:count])


@dataclass(frozen=True)
class Incomplete:
    """A set-up made for ``joint`` (from 0) that lacks something: ``why``, in words."""

    number: int
    joint: int
    why: str


def local_setups(session: Session, stiffness: Floats | None = None) -> list[LocalSetup | Incomplete]:
    """The set-ups with a purpose.

    Args:
        stiffness: (n,) N*m/rad, NaN: not known; levers are then those of the arm as it sags under gravity.

    Raises:
        SessionError: none has one, positions are not in the base, nothing pulls, the points contradict the purpose.
    """
    purposes = {number: p for number, p in session.purposes.items() if p.joint is not None}
    if not purposes:
        raise SessionError(
            f"{session.source}: no [setups.N] says purpose = 'joint-k': the local method goes joint by joint; add "
            "them, with points = {A = ..., B = ..., C = ...}, or take --method global"
        )
    if not session.registered:
        raise SessionError(
            f"{session.source}: registered = false: the local method projects displacements on axes of the base; "
            "measure the base with the tracker, or take --method global"
        )
    if not session.has_wrench:
        raise SessionError(f"{session.source}: the samples have no wrench: the local method needs each state's load")
    arm = LocalArm(session.robot, session.tool)
    return [_setup(session, arm, number, stiffness) for number in sorted(purposes)]


def _setup(
    session: Session, arm: LocalArm, number: int, stiffness: Floats | None
) -> LocalSetup | Incomplete:
    purpose, s = session.purposes[number], session.samples
    joint = (purpose.joint or 0) - 1
    place = f"{session.source}: [setups.{number}] purpose = 'joint-{joint + 1}'"
    needed = NEEDED[joint]
    extra = [p for p in purpose.points if p not in needed]
    if extra:
        raise SessionError(f"{place}: point {extra[0]} has no part in it, it takes {', '.join(needed)}; take it out")
    mine = s.setup == number
    missing = _missing(session, mine, purpose.points, needed) if mine.any() else "it has no readings"
    if missing:
        return Incomplete(number, joint, missing)
    first = int(np.argmax(mine))
    at = arm.stance(arm.at_rest(s.q[first], stiffness))
    points = {p: _point(session, at, mine, purpose.points[p]) for p in needed}
    _check_sides(place, joint, points)
    states = [
        _state(session=session, arm=arm, at=at, mine=mine, number=int(k), points=purpose.points)
        for k in np.unique(s.state[mine])
    ]
    loaded = [x for x in states if x.number and all(p in x.readings for p in needed)]
    usable = tuple(x for x in loaded if not x.trouble)
    if not usable:
        why = loaded[0].trouble if loaded else f"no loaded state in which {' and '.join(needed)} were read"
        return Incomplete(number, joint, why)
    noise = np.repeat([session.instruments.force**2, session.instruments.torque**2], 3)
    return LocalSetup(
        session=session,
        number=number,
        joint=joint,
        arm=arm,
        at=at,
        approach=s.approach[first],
        points=points,
        reference=states[0],
        loaded=usable,
        noise=noise,
    )


def _missing(session: Session, mine: Bools, points: Mapping[str, int], needed: str) -> str:
    unnamed = [p for p in needed if p not in points]
    if unnamed:
        return f"points names no {', '.join(unnamed)}"
    s = session.samples
    unread = [p for p in needed if not np.any(mine & (s.state == 0) & (s.reflector == points[p]))]
    if unread:
        names = [f"{p} ({session.reflectors[points[p]].name})" for p in unread]
        return f"state 0 has no reading of {', '.join(names)}"
    return ""


def _point(session: Session, at: Stance, mine: Bools, index: int) -> Point:
    reflector = session.reflectors[index]
    where = at.point(reflector.link, _position(session, at, mine, index))
    return Point(reflector.name, reflector.link, where, at.jacobian(reflector.link, where)[:3])


def _position(session: Session, at: Stance, mine: Bools, index: int) -> Floats:
    """(3,) m in its link's frame: as given, or where it is only roughly known, as read without load."""
    reflector, s = session.reflectors[index], session.samples
    rows = mine & (s.state == 0) & (s.reflector == index)
    if reflector.exact or not rows.any():
        return reflector.position
    # calibrated-out: the sag is not in the readings
    seen = LocalArm(session.robot, session.tool).stance(s.q[rows][0]) if session.gravity == "calibrated-out" else at
    frame = seen.links[reflector.link]
    return np.asarray(frame[:3, :3].T @ (s.position[rows].mean(axis=0) - frame[:3, 3]))


def _state(
    session: Session, arm: LocalArm, at: Stance, mine: Bools, number: int, points: Mapping[str, int]
) -> StateReadings:
    s, load = session.samples, session.samples.load
    here = np.flatnonzero(mine & (s.state == number))
    first = here[0]
    _, once = np.unique(session.sensor_reading[here], return_index=True)
    reflector = int(load.at[first])
    point = load.point[first] if reflector < 0 else _position(session, at, mine, reflector)
    wrench = load.wrench[here[once]].mean(axis=0)
    force = Force(
        wrench=wrench,
        link=int(load.link[first]),
        in_tool=bool(load.in_tool[first]),
        point=point,
        point_link=int(load.point_link[first]),
    )
    readings = {}
    for letter, index in points.items():
        rows = here[s.reflector[here] == index]
        if len(rows):
            variance = (s.sd[rows] ** 2).sum(axis=0) / len(rows) ** 2
            readings[letter] = PointReadings(s.position[rows], s.position[rows].mean(axis=0), variance)
    trouble = ""
    rest = mine & (s.state == 0)
    if np.ptp(np.append(s.payload[here], s.payload[rest])) > 0:
        trouble = f"state {number} changes the payload, which no force sensor shows"
    elif np.ptp(load.at[here]):
        trouble = f"state {number} names several load_at"
    return StateReadings(
        number=number,
        force=force,
        sensed=len(once),
        turns=arm.turns(at, force),
        readings=readings,
        trouble=trouble,
    )


def _check_sides(place: str, joint: int, points: Mapping[str, Point]) -> None:
    """Points before and beyond the joint, as its equations have them."""
    beyond = {3: "B", 4: "C"}.get(joint, "A")
    for letter, point in points.items():
        inside = point.link <= joint
        if inside == (letter == beyond):
            turns = f"does not move with joint {joint + 1}" if inside else f"moves with joint {joint + 1}"
            wanted = f"link {joint + 1} or farther out" if inside else f"link {joint} or nearer to the base"
            raise SessionError(
                f"{place}: {letter} = {point.name!r} sits on link {point.link} and {turns}; expected one on {wanted}"
            )
