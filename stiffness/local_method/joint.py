"""One joint by the local method: from a reading and a lever to an angle, from torque and angle to a stiffness.

The paper's equations, set right. A reading is a sum of displacements, y = sum w_P . d_P over the points A, B, C:

    joints 1, 2, 3, 6   Eq. 1-3, 21   w_A along the way that joint k alone moves A (the signed projection)
    joint 4             Eq. 5-12      w_B along the way of B, w_A = -w_B: the turn of A-B, with its sign
    joint 5             Eq. 13-20     the turn of B-C less the turn of A-B about axis 5, with its sign

A joint j that turns by theta_j adds s_j theta_j with s_j = sum w_P . dP/dq_j, so with known joints taken off

    theta_k = (y - sum_j s_j theta_j) / s_k        theta_j = tau_j / K_j        K_k = tau_k / theta_k

tau = J^T W, not J W. It is the change of load AND gravity between state 0 and the deflected posture, the
complementary stiffness that the statics (statics.py) have too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.local_method.setup import LocalSetup, StateReadings
from stiffness.session.table import SessionError

Floats = npt.NDArray[np.float64]

EQUATIONS = ("Eq. 1-2", "Eq. 1-2", "Eq. 3-4", "Eq. 5-12", "Eq. 13-20", "Eq. 21-24")
PRE_LOADED, NON_LOADED, UNKNOWN = "pre-loaded", "non-loaded", "unknown"

SHORT = 0.01  # m: a lever below this turns nothing
LEAST = 0.2  # of a joint's turn that an angle between reflectors has to show
NOTICED = 0.01  # share of joint k's own part of a reading above which an unknown joint is not overlooked
_BACK_AND_FORTH = 4  # times between angle and torque: a hundredth is left each time


@dataclass(frozen=True, repr=False, eq=False)
class Angle:
    """The turn of a joint under one loaded state of one set-up, and what it was made of.

    Attributes:
        setup, state: where it comes from.
        sides: for every joint the flank that carries its load: pre-loaded, non-loaded, unknown.
        force: N. torque: N*m, J^T W at the commanded posture. balance: the same at the deflected one, with the
            change of gravity.
        lever: m, torque per force. reading: m/rad (rad/rad for joint 5), s_k: the reading per turn of the joint.
        shares: (n,) s_j of all joints.
        others: (n,) rad, turns of the other joints that were taken off; NaN where not known.
        turn: rad, theta_k; its part of the variance from positions is ``variance``.
        torques: (n,) N*m, J^T W.
    """

    setup: LocalSetup
    state: StateReadings
    sides: tuple[str, ...]
    force: float
    torque: float
    balance: float
    lever: float
    reading: float
    shares: Floats
    others: Floats
    turn: float
    variance: float
    torques: Floats

    @property
    def stiffness(self) -> float:
        """N*m/rad, of this state alone."""
        return self.balance / self.turn

    @property
    def side(self) -> str:
        """Of the joint itself."""
        return self.sides[self.setup.joint]

    @property
    def parts(self) -> Floats:
        """(n,) what the other joints put into the reading, relative to this joint's part; 0 where not known."""
        return np.asarray(np.abs(self.shares * np.nan_to_num(self.others)) / abs(self.reading * self.turn))


@dataclass(frozen=True, repr=False, eq=False)
class Estimate:
    """Stiffness of a joint, N*m/rad, with its sd: ``gradient`` (n,) by the stiffness of the joints taken off,
    ``own`` the variance of this joint's own readings and forces."""

    stiffness: float
    gradient: Floats
    own: float

    def variance(self, covariance: Floats) -> float:
        """With the covariance (n, n) of the other joints."""
        return float(self.own + self.gradient @ covariance @ self.gradient)


def weights(setup: LocalSetup) -> dict[str, Floats]:
    """w_P (3,) of every point of a set-up, so that s_k is positive.

    Raises:
        SessionError: the points tell nothing of the joint.
    """
    k, p = setup.joint, setup.points
    if k == 4:
        axis = setup.at.axis[k]
        before, after = p["B"].where - p["A"].where, p["C"].where - p["B"].where
        _long_enough(setup, "A-B", before, axis)
        _long_enough(setup, "B-C", after, axis)
        inner, outer = _turning(axis, before), _turning(axis, after)
        return {"A": inner, "B": -inner - outer, "C": outer}
    letter = "B" if k == 3 else "A"
    way = p[letter].jacobian[:, k]
    length = float(np.linalg.norm(way))
    if length < SHORT:
        raise SessionError(
            f"{setup.place}: {letter} = {p[letter].name!r} sits {length * 1e3:.1f} mm from axis {k + 1}: it does not "
            f"show how joint {k + 1} turns; take a reflector farther out"
        )
    way = way / length
    return {"A": -way, "B": way} if k == 3 else {"A": way}


def _turning(axis: Floats, vector: Floats) -> Floats:
    """(3,) rad/m: turn about an axis of a vector, per displacement of its end."""
    across = vector - axis * (axis @ vector)
    return np.asarray(np.cross(axis, across) / (across @ across))


def _long_enough(setup: LocalSetup, name: str, vector: Floats, axis: Floats) -> None:
    across = float(np.linalg.norm(np.cross(axis, vector)))
    if across < SHORT:
        raise SessionError(
            f"{setup.place}: {name} lies {across * 1e3:.1f} mm across axis {setup.joint + 1}: its angle says nothing; "
            "take reflectors farther apart"
        )


def reading(setup: LocalSetup, state: StateReadings, weight: dict[str, Floats]) -> tuple[float, float]:
    """y, and the variance of it that this state alone brings in."""
    y = sum(float(w @ setup.displacement(state, p)) for p, w in weight.items())
    return y, sum(float(w**2 @ state.readings[p].variance) for p, w in weight.items())


def angles(setup: LocalSetup, stiffness: Floats) -> tuple[list[Angle], str]:
    """The turns of a joint under the loaded states of a set-up, with those of the joints of ``stiffness`` (n,) N*m/rad,
    NaN: not known, taken off; or, in words, why there are none.

    Raises:
        SessionError: the load or the points have nothing to do with the joint that the set-up is for.
    """
    k, weight = setup.joint, weights(setup)
    shares = sum((w @ setup.points[p].jacobian for p, w in weight.items()), np.zeros(len(stiffness)))
    if k == 4 and shares[k] < LEAST:
        raise SessionError(
            f"{setup.place}: the angle A-B-C changes by {shares[k]:.2f} of what joint {k + 1} turns; put B = "
            f"{setup.points['B'].name!r} nearer to axis {k + 1} than C"
        )
    found: list[Angle] = []
    for state in setup.loaded:
        torque, noise = _torque(setup, state)
        force = float(np.linalg.norm(_load_change(setup, state)[:3]))
        needed = SHORT * force if force > 0 else 0.0
        if abs(torque[k]) <= max(needed, 3 * noise[k]):
            raise SessionError(
                f"{setup.place} purpose = 'joint-{k + 1}': the {force:.0f} N of state {state.number} turn joint "
                f"{k + 1} with {torque[k]:.1f} N*m only; is it the set-up for this joint?"
            )
        why = _unknown_joint(setup=setup, shares=shares, torque=torque, noise=noise, stiffness=stiffness)
        if why:
            return [], why
        found.append(
            _angle(
                setup=setup,
                state=state,
                weight=weight,
                shares=shares,
                torque=torque,
                force=force,
                stiffness=stiffness,
            )
        )
    return found, ""


def _load_change(setup: LocalSetup, state: StateReadings) -> Floats:
    """(6,) N and N*m that a state adds to the reference, base axes."""
    arm, at = setup.arm, setup.at
    return arm.in_base(at, state.force) - arm.in_base(at, setup.reference.force)


def _torque(setup: LocalSetup, state: StateReadings) -> tuple[Floats, Floats]:
    """(n,) N*m J^T W that a state adds, and its standard deviation."""
    both = (state, setup.reference)
    variance = sum((x.turns**2 @ setup.noise / x.sensed for x in both), np.zeros(len(setup.at.q)))
    return state.torque - setup.reference.torque, np.sqrt(variance)


def _unknown_joint(setup: LocalSetup, shares: Floats, torque: Floats, noise: Floats, stiffness: Floats) -> str:
    k = setup.joint
    share = np.abs(shares * torque) - 3 * np.abs(shares) * noise
    share = share / abs(shares[k] * torque[k])
    for j in np.flatnonzero((share > NOTICED) & np.isnan(stiffness) & (np.arange(len(share)) != k)):
        return (
            f"the same force turns joint {j + 1} with {torque[j]:.0f} N*m and that moves the reading; joint {j + 1} "
            "has to be known for that, and it is not identified"
        )
    return ""


def _angle(
    setup: LocalSetup,
    state: StateReadings,
    weight: dict[str, Floats],
    shares: Floats,
    torque: Floats,
    force: float,
    stiffness: Floats,
) -> Angle:
    k, reference, arm, q = setup.joint, setup.reference, setup.arm, setup.at.q
    y, loaded = reading(setup, state, weight)
    _, rest = reading(setup, reference, weight)
    start = arm.balance(q, reference.force)
    turn, balance = np.zeros(len(q)), torque
    known = ~np.isnan(stiffness)
    known[k] = False
    for _ in range(_BACK_AND_FORTH):
        turn[known] = balance[known] / stiffness[known]
        turn[k] = (y - shares[known] @ turn[known]) / shares[k]
        balance = arm.balance(q + turn, state.force) - start
    others = np.where(known, turn, np.nan)
    return Angle(
        setup=setup,
        state=state,
        sides=tuple(_side(int(a), t, t + b) for a, t, b in zip(setup.approach, start, balance, strict=True)),
        force=force,
        torque=float(torque[k]),
        balance=float(balance[k]),
        lever=float(abs(torque[k]) / force) if force > 0 else float("nan"),
        reading=float(shares[k]),
        shares=shares,
        others=others,
        turn=float(turn[k]),
        variance=(loaded + rest) / float(shares[k]) ** 2,
        torques=torque,
    )


def _side(approach: int, start: float, end: float) -> str:
    """Pre-loaded: the torque of gravity and load goes where the joint last turned (paper, section 5)."""
    turned_over = start * end < 0 and abs(start) > 0.05 * abs(end - start)
    if approach == 0 or turned_over:
        return UNKNOWN
    return PRE_LOADED if approach * end > 0 else NON_LOADED


def estimate(found: Sequence[Angle], stiffness: Floats) -> Estimate:
    """Least squares of turn = torque / K over states; for one state its torque over its turn.

    Standard deviations by first order from the noise of positions and forces; the states of one set-up share
    the noise of its reference.
    """
    k = found[0].setup.joint
    torque = np.array([a.balance for a in found])
    turn = np.array([a.turn for a in found])
    share = torque / np.array([a.variance for a in found])
    share = share / (share @ torque)  # d(1/K) per turn of each state
    flexible = float(share @ turn)
    scale = -1 / flexible**2
    gradient, own = np.zeros(len(stiffness)), 0.0
    for setup in dict.fromkeys(a.setup for a in found):
        mine = [(a, p) for a, p in zip(found, share, strict=True) if a.setup is setup]
        own += _own_variance(setup, mine, flexible, stiffness)
        for a, p in mine:
            known = ~np.isnan(a.others)
            gradient[known] += scale * p * (a.shares * a.others)[known] / a.shares[k] / stiffness[known]
    return Estimate(1 / flexible, gradient, own * scale**2)


def _own_variance(setup: LocalSetup, mine: Sequence[tuple[Angle, float]], flexible: float, stiffness: Floats) -> float:
    """Variance of 1/K from the readings and forces of one set-up."""
    k, reference, weight = setup.joint, setup.reference, weights(setup)
    total, rest, rest_force = 0.0, 0.0, np.zeros(6)
    for a, p in mine:
        known = ~np.isnan(a.others)
        by_torque = np.zeros(len(stiffness))
        by_torque[known] = -a.shares[known] / a.shares[k] / stiffness[known]
        by_torque[k] = -flexible
        by_torque *= p
        by_force = by_torque @ a.state.turns
        total += (p / a.shares[k]) ** 2 * reading(setup, a.state, weight)[1]
        total += float(by_force**2 @ setup.noise) / a.state.sensed
        rest += p / float(a.shares[k])
        rest_force += by_torque @ reference.turns
    total += rest**2 * reading(setup, reference, weight)[1]
    return total + float(rest_force**2 @ setup.noise) / reference.sensed
