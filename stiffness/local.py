"""The paper's local method: one joint after the other, each from the set-up that was made for it.

Berntsen, Bertheussen, Tyapin, Combined Stiffness Identification of 6-DoF Industrial Robot, section 3, Eq. 1-24.
What one joint's readings say is in local_joint.py, what the printed equations make of them in local_printed.py.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.errors import ModelError
from stiffness.local_joint import (
    EQUATIONS,
    NON_LOADED,
    PRE_LOADED,
    UNKNOWN,
    Angle,
    Estimate,
    angles,
    estimate,
)
from stiffness.local_printed import Printed, printed
from stiffness.local_setup import Incomplete, LocalSetup, local_setups
from stiffness.model import ComplianceModel
from stiffness.session import Session

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

NOISE = 3.0  # standard deviations that a stiffness must stand out of its noise
RIGID = 1e12  # N*m/rad written for a joint that is not identified, beside identified = false


@dataclass(frozen=True, repr=False, eq=False)
class Pull:
    """One loaded state: what its readings said of the joint.

    Attributes:
        source, setup, state: where it was read.
        side: pre-loaded, non-loaded, unknown: the flank that carried the load.
        readings: point -> (reflector, readings under load, readings of state 0).
        force: N. load_lever: m. torque: N*m, their product, J^T W.
        balance: N*m, torque at the deflected posture with the change of gravity: what the stiffness is made of.
        reading_lever: m from the axis to the reflector (L2k, R4); for joint 5 angle per angle.
        turn: rad, deflection of the joint.
        taken_off: other joint (from 1) -> rad that it turned.
        stiffness: N*m/rad, of this state alone.
        printed: what the paper's print would have given.
    """

    source: str
    setup: int
    state: int
    side: str
    readings: Mapping[str, tuple[str, int, int]]
    force: float
    load_lever: float
    torque: float
    balance: float
    reading_lever: float
    turn: float
    taken_off: Mapping[int, float]
    stiffness: float
    printed: tuple[Printed, ...]


@dataclass(frozen=True)
class Value:
    """A number and its standard deviation."""

    value: float
    sd: float


@dataclass(frozen=True, repr=False, eq=False)
class JointRecord:
    """One joint: ``equation`` of the paper; ``problem`` why it is not identified, empty when it is; ``side`` that its
    stiffness holds for; ``pulls``; the ``non_loaded`` stiffness and ``ratio`` to the pre-loaded one, where the
    approaches show both; ``notes``."""

    joint: int
    equation: str
    problem: str
    side: str
    pulls: tuple[Pull, ...]
    non_loaded: Value | None
    ratio: Value | None
    notes: tuple[str, ...]


@dataclass(frozen=True, repr=False, eq=False)
class LocalFit:
    """Joint stiffness by the local method.

    Attributes:
        sessions: it is made of.
        stiffness: (n,) N*m/rad, NaN where not identified. sd: (n,). covariance: (n, n).
        joints: a record per joint.
    """

    sessions: tuple[Session, ...]
    stiffness: Floats
    covariance: Floats
    joints: tuple[JointRecord, ...]

    def __post_init__(self) -> None:
        self.stiffness.setflags(write=False)
        self.covariance.setflags(write=False)

    def __repr__(self) -> str:
        return f"LocalFit({self.sessions[0].robot.name}, {int(self.identified.sum())} joints identified)"

    @property
    def sd(self) -> Floats:
        """(n,) N*m/rad, NaN where not identified."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def identified(self) -> Bools:
        """(n,)."""
        return ~np.isnan(self.stiffness)

    def model(self, robot: str, provenance: Mapping[str, object] | None = None) -> ComplianceModel:
        """As a model of ``robot`` (name or path as the model file shall say).

        A joint that is not identified is written as rigid, 1e12 N*m/rad with sd 0, and identified = false.

        Raises:
            ModelError: no joint was identified.
        """
        if not self.identified.any():
            why = "; ".join(f"joint {r.joint}: {r.problem}" for r in self.joints)
            raise ModelError(f"{self.sessions[0].source}: no joint is identified: {why}")
        first, known = self.sessions[0], self.identified
        values = {"joint-stiffness": {"k_nm_per_rad": np.where(known, self.stiffness, RIGID)}}
        sd = {"joint-stiffness": {"k_nm_per_rad": np.where(known, self.sd, 0.0)}}
        flags = {"joint-stiffness": known} if not known.all() else {}
        paired = np.array([r.ratio is not None for r in self.joints])
        if paired.any():
            ratio = [Value(1.0, 0.0) if r.ratio is None else r.ratio for r in self.joints]
            values["preload-softening"] = {"ratio": np.clip([r.value for r in ratio], 0.05, 1.0)}
            sd["preload-softening"] = {"ratio": np.array([r.sd for r in ratio])}
        reference = first.reference_temperature
        return ComplianceModel(
            source="",
            robot=robot,
            gravity=first.gravity,
            reference_temperature=20.0 if reference is None else reference,
            base=first.base,
            tip=first.tip,
            values=values,
            sd=sd,
            identified=flags,
            provenance={**self.provenance(), **(provenance or {})},
        )

    def provenance(self) -> dict[str, object]:
        """Where the numbers come from, for the model file."""
        pulls = [p for r in self.joints for p in r.pulls]
        forces, torques = [p.force for p in pulls], [abs(p.torque) for p in pulls]
        said: dict[str, object] = {
            "kind": "measured",
            "method": "local",
            "source": ", ".join(s.source for s in self.sessions),
            "session_sha256": [s.sha256["session"] for s in self.sessions],
            "samples_sha256": [s.sha256["samples"] for s in self.sessions],
            "load_range": f"{_span(forces)} N, {_span(torques)} N*m on the joint",
            "preload_side": "; ".join(f"joint {r.joint}: {r.side}" for r in self.joints if not r.problem),
        }
        missing = [f"joint {r.joint}: {r.problem}" for r in self.joints if r.problem]
        return said | {"not_identified": missing} if missing else said


def _span(numbers: Sequence[float]) -> str:
    low, high = f"{min(numbers):.4g}", f"{max(numbers):.4g}"
    return low if low == high else f"{low} ... {high}"


def identify_local(*sessions: Session) -> LocalFit:
    """Stiffness joint by joint, 1 to n, each with the motion of the joints before it taken off.

    A joint without a complete set-up is not identified, nor is a later one that needs it: the record says why.

    Raises:
        SessionError: a session has no purposes, no wrench, no registration, or a purpose that its set-up cannot serve.
        ModelError: the sessions are not of one robot.
    """
    _check_one_robot(sessions)
    n = sessions[0].robot.n
    stiffness, covariance = np.full(n, np.nan), np.full((n, n), np.nan)
    setups = [x for s in sessions for x in local_setups(s)]
    records = []
    for k in range(n):
        record, best = _joint(k, [x for x in setups if x.joint == k], stiffness, covariance)
        records.append(record)
        if best is not None:
            _enter(k, best, stiffness, covariance)
    return LocalFit(sessions, stiffness, covariance, tuple(records))


def _check_one_robot(sessions: Sequence[Session]) -> None:
    if not sessions:
        raise ModelError("the local method needs a session")
    first = sessions[0]
    for s in sessions[1:]:
        placements = zip((s.robot.before, s.robot.after), (first.robot.before, first.robot.after), strict=True)
        if not all(np.allclose(a, b, atol=1e-9) for a, b in placements) or s.gravity != first.gravity:
            raise ModelError(
                f"{s.source}: robot {s.robot.name} with gravity {s.gravity!r} is not that of {first.source} "
                f"({first.robot.name}, {first.gravity!r})"
            )


def _enter(k: int, best: Estimate, stiffness: Floats, covariance: Floats) -> None:
    """Take a joint up among the known ones."""
    known = np.flatnonzero(~np.isnan(stiffness))
    stiffness[k] = best.stiffness
    covariance[k, known] = covariance[known, k] = covariance[np.ix_(known, known)] @ best.gradient[known]
    covariance[k, k] = best.variance(np.nan_to_num(covariance))


def _joint(
    k: int, setups: Sequence[LocalSetup | Incomplete], stiffness: Floats, covariance: Floats
) -> tuple[JointRecord, Estimate | None]:
    """The record of a joint, and its estimate where it is identified."""
    whole = [x for x in setups if isinstance(x, LocalSetup)]
    notes = [f"set-up {x.number} is not used: {x.why}" for x in setups if isinstance(x, Incomplete)]
    found: list[Angle] = []
    for setup in whole:
        more, why = angles(setup, stiffness)
        found += more
        notes += [f"set-up {setup.number} is not used: {why}"] if why else []
    if not found:
        problem = "; ".join(notes) or f"no set-up has purpose = 'joint-{k + 1}'"
        return _record(k, problem, UNKNOWN, (), None, None, ()), None
    pulls = tuple(_pull(a, stiffness) for a in found)
    side = next(s for s in (PRE_LOADED, UNKNOWN, NON_LOADED) if any(a.side == s for a in found))
    best = estimate([a for a in found if a.side == side], stiffness)
    known = np.nan_to_num(covariance)
    problem = _noisy(best, known)
    if problem:
        return _record(k, problem, side, pulls, None, None, tuple(notes)), None
    against = [a for a in found if a.side == NON_LOADED] if side == PRE_LOADED else []
    other = estimate(against, stiffness) if against else None
    if other is not None and _noisy(other, known):
        notes.append(f"non-loaded: {_noisy(other, known)}")
        other = None
    notes += _said(found, side, other is not None)
    non_loaded = None if other is None else Value(other.stiffness, float(np.sqrt(other.variance(known))))
    ratio = None if other is None else _ratio(other, best, known)
    return _record(k, "", side, pulls, non_loaded, ratio, tuple(notes)), best


def _record(
    k: int,
    problem: str,
    side: str,
    pulls: tuple[Pull, ...],
    non_loaded: Value | None,
    ratio: Value | None,
    notes: tuple[str, ...],
) -> JointRecord:
    return JointRecord(k + 1, EQUATIONS[k], problem, side, pulls, non_loaded, ratio, notes)


def _noisy(e: Estimate, covariance: Floats) -> str:
    """Why an estimate says nothing, in words; empty when it does."""
    sd = float(np.sqrt(e.variance(covariance)))
    if abs(e.stiffness) < NOISE * sd:
        return (
            f"the deflection does not stand out of the noise: 1/K = {1 / e.stiffness:.2g} +- {sd / e.stiffness**2:.2g} "
            "rad/(N*m); repeat more often or pull harder"
        )
    if e.stiffness < 0:
        return "it moves against its load: is the sign of the force or the frame of the wrench right?"
    return ""


def _ratio(non_loaded: Estimate, pre_loaded: Estimate, covariance: Floats) -> Value:
    """Non-loaded over pre-loaded; what both take off they share."""
    ratio = non_loaded.stiffness / pre_loaded.stiffness
    gradient = non_loaded.gradient / non_loaded.stiffness - pre_loaded.gradient / pre_loaded.stiffness
    own = non_loaded.own / non_loaded.stiffness**2 + pre_loaded.own / pre_loaded.stiffness**2
    return Value(ratio, float(ratio * np.sqrt(own + gradient @ covariance @ gradient)))


def _said(found: Sequence[Angle], side: str, paired: bool) -> list[str]:
    notes = []
    if side == NON_LOADED:
        notes.append("only non-loaded: pre-loaded the joint is stiffer")
    unknown = sorted({a.setup.number for a in found if a.side == UNKNOWN})
    if unknown and side == PRE_LOADED:
        notes.append(f"not used, the flank is not known: set-up {', '.join(map(str, unknown))}")
    torques = np.abs([a.torque for a in found])
    if paired and torques.max() < 1.3 * torques.min():
        notes.append("one load level: a gap between flanks and a softer flank cannot be told apart")
    return notes


def _pull(a: Angle, stiffness: Floats) -> Pull:
    counts = {
        letter: (p.name, len(a.state.readings[letter].single), len(a.setup.reference.readings[letter].single))
        for letter, p in a.setup.points.items()
    }
    moved = np.flatnonzero(~np.isnan(a.others) & (np.abs(a.shares * np.nan_to_num(a.others)) > 1e-12))
    return Pull(
        source=a.setup.session.source,
        setup=a.setup.number,
        state=a.state.number,
        side=a.side,
        readings=counts,
        force=a.force,
        load_lever=a.lever,
        torque=a.torque,
        balance=a.balance,
        reading_lever=a.reading,
        turn=a.turn,
        taken_off={int(j) + 1: float(a.others[j]) for j in moved},
        stiffness=a.stiffness,
        printed=printed(a, stiffness),
    )
