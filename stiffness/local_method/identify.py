"""The paper's local method: one joint after the other, each from the set-up that was made for it.

Berntsen, Bertheussen, Tyapin, Combined Stiffness Identification of 6-DoF Industrial Robot, section 3, Eq. 1-24.
One joint from its readings: joint.py. What the equations give as they are printed: printed.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from stiffness.errors import ModelError
from stiffness.local_method.fit import JointRecord, LoadedState, LocalFit, MeasuredValue
from stiffness.local_method.joint import (
    EQUATIONS,
    NON_LOADED,
    PRE_LOADED,
    UNKNOWN,
    Angle,
    Estimate,
    angles,
    estimate,
)
from stiffness.local_method.printed import printed
from stiffness.local_method.setup import Incomplete, LocalSetup, local_setups
from stiffness.session.session import Session

Floats = npt.NDArray[np.float64]

NOISE = 3.0  # standard deviations that a stiffness must stand out of its noise
ROUNDS = 3
WORTH_A_WORD = 1e-3  # share of a reading below which a joint that was taken off is not listed


def identify_local(*sessions: Session) -> LocalFit:
    """Stiffness joint by joint, 1 to n, each with the motion of the joints before it taken off.

    A joint without a complete set-up is not identified, nor is one that needs it: the record has the reason. Two more
    rounds take off the little that later joints and the sag under gravity do: half a percent on a heavy arm.

    Raises:
        SessionError: a session has no purposes, no wrench, no registration, or a purpose that its set-up cannot serve.
        ModelError: the sessions are not of one robot.
    """
    _check_one_robot(sessions)
    n = sessions[0].robot.n
    fit = LocalFit(sessions, np.full(n, np.nan), np.full((n, n), np.nan), ())
    for _ in range(ROUNDS):
        fit = _round(fit)
    return fit


def _round(last: LocalFit) -> LocalFit:
    """All joints in order, with what the round before knew of the later ones and of the sag."""
    stiffness, covariance = last.stiffness.copy(), last.covariance.copy()
    setups = [x for s in last.sessions for x in local_setups(s, last.stiffness)]
    records: list[JointRecord] = []
    for k in range(len(stiffness)):
        record, best = _joint(k, [x for x in setups if x.joint == k], stiffness, covariance)
        sides = [r.side for r in (*records, record, *last.joints[k + 1 :])]
        records.append(replace(record, notes=(*record.notes, *_other_flanks(record, sides))))
        _enter(k, best, stiffness, covariance)
    return LocalFit(last.sessions, stiffness, covariance, tuple(records))


def _check_one_robot(sessions: Sequence[Session]) -> None:
    if not sessions:
        raise ModelError("the local method needs a session")
    first = sessions[0]
    for s in sessions[1:]:
        if not s.robot.same_kinematics(first.robot) or s.gravity != first.gravity:
            raise ModelError(
                f"{s.source}: robot {s.robot.name} with gravity {s.gravity!r} is not that of {first.source} "
                f"({first.robot.name}, {first.gravity!r})"
            )


def _enter(k: int, best: Estimate | None, stiffness: Floats, covariance: Floats) -> None:
    """Take a joint up among the known ones, or off them."""
    stiffness[k], covariance[k], covariance[:, k] = np.nan, np.nan, np.nan
    if best is None:
        return
    known = np.flatnonzero(~np.isnan(stiffness))
    covariance[k, known] = covariance[known, k] = covariance[np.ix_(known, known)] @ best.gradient[known]
    covariance[k, k] = best.variance(np.nan_to_num(covariance))
    stiffness[k] = best.stiffness


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
        return _record(k=k, problem=problem, side=UNKNOWN, states=(), non_loaded=None, ratio=None, notes=()), None
    states = tuple(_loaded_state(a, stiffness) for a in found)
    side = next(s for s in (PRE_LOADED, UNKNOWN, NON_LOADED) if any(a.side == s for a in found))
    best = estimate([a for a in found if a.side == side], stiffness)
    known = np.nan_to_num(covariance)
    problem = _noisy(best, known)
    if problem:
        return _record(
            k=k,
            problem=problem,
            side=side,
            states=states,
            non_loaded=None,
            ratio=None,
            notes=tuple(notes),
        ), None
    against = [a for a in found if a.side == NON_LOADED] if side == PRE_LOADED else []
    other = estimate(against, stiffness) if against else None
    if other is not None and _noisy(other, known):
        notes.append(f"non-loaded: {_noisy(other, known)}")
        other = None
    notes += _said(found, side, other is not None)
    non_loaded = None if other is None else MeasuredValue(other.stiffness, float(np.sqrt(other.variance(known))))
    ratio = None if other is None else _ratio(other, best, known)
    return _record(
        k=k,
        problem="",
        side=side,
        states=states,
        non_loaded=non_loaded,
        ratio=ratio,
        notes=tuple(notes),
    ), best


def _record(
    k: int,
    problem: str,
    side: str,
    states: tuple[LoadedState, ...],
    non_loaded: MeasuredValue | None,
    ratio: MeasuredValue | None,
    notes: tuple[str, ...],
) -> JointRecord:
    return JointRecord(
        joint=k + 1,
        equation=EQUATIONS[k],
        problem=problem,
        side=side,
        states=states,
        non_loaded=non_loaded,
        ratio=ratio,
        notes=notes,
    )


def _noisy(e: Estimate, covariance: Floats) -> str:
    """Why an estimate is not usable, in words; empty when it is."""
    sd = float(np.sqrt(e.variance(covariance)))
    if abs(e.stiffness) < NOISE * sd:
        return (
            f"the deflection does not stand out of the noise: 1/K = {1 / e.stiffness:.2g} +- {sd / e.stiffness**2:.2g} "
            "rad/(N*m); repeat more often or pull harder"
        )
    if e.stiffness < 0:
        return "it moves against its load: is the sign of the force or the frame of the wrench right?"
    return ""


def _ratio(non_loaded: Estimate, pre_loaded: Estimate, covariance: Floats) -> MeasuredValue:
    """Non-loaded over pre-loaded; what both take off they share."""
    ratio = non_loaded.stiffness / pre_loaded.stiffness
    gradient = non_loaded.gradient / non_loaded.stiffness - pre_loaded.gradient / pre_loaded.stiffness
    own = non_loaded.own / non_loaded.stiffness**2 + pre_loaded.own / pre_loaded.stiffness**2
    return MeasuredValue(ratio, float(ratio * np.sqrt(own + gradient @ covariance @ gradient)))


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


def _other_flanks(record: JointRecord, sides: Sequence[str]) -> list[str]:
    """Notes on joints taken off with a stiffness of another flank than they stood on."""
    return [
        f"set-up {p.setup}: joint {j} stood {at}, its {sides[j - 1]} stiffness was taken off"
        for p in record.states
        for j, at in p.taken_off_sides.items()
        if j <= len(sides) and UNKNOWN not in (at, sides[j - 1]) and at != sides[j - 1]
    ]


def _loaded_state(a: Angle, stiffness: Floats) -> LoadedState:
    counts = {
        letter: (p.name, len(a.state.readings[letter].single), len(a.setup.reference.readings[letter].single))
        for letter, p in a.setup.points.items()
    }
    moved = np.flatnonzero(a.parts > WORTH_A_WORD)
    return LoadedState(
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
        taken_off_sides={int(j) + 1: a.sides[j] for j in moved},
        stiffness=a.stiffness,
        printed=printed(a, stiffness),
    )
