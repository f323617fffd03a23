"""Slots of an effect as functions of numbers, and random numbers to put in: what the contract suite runs on."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import casadi as ca
import numpy as np
import numpy.typing as npt
import pytest

from stiffness.effects import CATALOGUE
from stiffness.effects.effect import Effect, JointInput, Parameter, PlaceInput, ProgrammedWrench, ShownWrench
from tests.oracles.effects import ORACLES, Joints, Oracle, Place

Floats = npt.NDArray[np.float64]
Numbers = dict[str, Floats]
N = 6
STIFFNESS = np.array([2.0e6, 1.7e6, 1.3e6, 2.8e5, 9.6e4, 3.7e4])

every_effect = pytest.mark.parametrize("effect", CATALOGUE, ids=lambda e: e.name)


def oracle_of(effect: Effect) -> Oracle:
    return ORACLES[effect.name]


def sample(effect: Effect, seed: int) -> Numbers:
    """Random values within the bounds, about the start values."""
    rng = np.random.default_rng(seed)
    own = oracle_of(effect).sample
    return own(rng) if own else {p.name: _around(p, rng) for p in effect.parameters}


def _around(p: Parameter, rng: np.random.Generator) -> Floats:
    if p.low < 0:
        return rng.uniform(p.low, p.high, p.count(N))
    middle = p.start or p.scale
    return np.clip(middle * np.exp(rng.normal(size=p.count(N))), p.low, p.high)


def neutral(effect: Effect, seed: int) -> Numbers | None:
    """Values for which there is no effect, the rest random; None where there are none."""
    nothing = oracle_of(effect).nothing
    if nothing is None:
        return None
    values = sample(effect, seed)
    return {k: np.full_like(v, nothing[k]) if k in nothing else v for k, v in values.items()}


def symbols(values: Mapping[str, Floats]) -> dict[str, ca.SX]:
    return {k: ca.SX.sym(k, len(v)) for k, v in values.items()}


def joints(effect: Effect, values: Numbers, seed: int, **changes: object) -> Joints:
    """Random torques of both signs and states that the effect can have."""
    rng = np.random.default_rng(seed)
    half = effect.memory.bounds(values) if effect.memory else np.zeros(N)
    torque = rng.normal(size=N) * np.array([3e3, 3e3, 2e3, 500, 300, 200])
    given = Joints(torque, STIFFNESS, rng.uniform(-3, 3, N), rng.uniform(-1, 1, len(half)) * half, rng.uniform(-10, 20))
    return replace(given, **changes)  # type: ignore[arg-type]


def states_of(effect: Effect) -> int:
    """How many numbers its memory has; one a joint where it has none."""
    return N * (effect.memory.states if effect.memory else 1)


def shares(effect: Effect, seed: int) -> Floats:
    """Random states as shares of their half ranges."""
    return np.random.default_rng(seed).uniform(-1, 1, states_of(effect))


def wrench(seed: int) -> Floats:
    return np.random.default_rng(seed).normal(size=6) * np.r_[np.full(3, 1000.0), np.full(3, 200.0)]


def place(k: int, seed: int, **changes: object) -> Place:
    """A place under a random wrench, its link of random length in a random direction."""
    rng = np.random.default_rng([k, seed])
    given = Place(k, wrench(seed), rng.uniform(3, 20), rng.uniform(-0.6, 0.6, 3), rng.uniform(-0.6, 0.6, 3))
    return replace(given, **changes)  # type: ignore[arg-type]


class JointLaw:
    """The joint slot as a function of torque, angle, state, temperature and parameters."""

    def __init__(self, effect: Effect, values: Numbers) -> None:
        p = symbols(values)
        torque, angle = ca.SX.sym("torque", N), ca.SX.sym("angle", N)
        state = ca.SX.sym("state", states_of(effect))
        temperature = ca.SX.sym("temperature")
        if effect.joint is None:
            raise TypeError(f"{effect} has no joint slot")
        compliance = ca.SX(ca.DM(1 / STIFFNESS))
        dq = effect.joint(JointInput(torque, torque / STIFFNESS, compliance, angle, state, temperature), p)
        self.shape = dq.shape
        arguments = [torque, angle, state, temperature, *p.values()]
        self.value = ca.Function("dq", arguments, [ca.densify(dq)])
        wanted = ca.vertcat(torque, *p.values())
        if effect.memory:  # identification holds the share of the range fixed, not the state
            share = state * ca.SX(effect.memory.bounds(p))
            dq = effect.joint(JointInput(torque, torque / STIFFNESS, compliance, angle, share, temperature), p)
        self.slope = ca.Function("slope", arguments, [ca.densify(ca.jacobian(dq, wanted))])

    def __call__(self, given: Joints, values: Numbers) -> Floats:
        return np.array(self.value(*self._arguments(given, values))).ravel()

    def jacobian(self, given: Joints, values: Numbers) -> Floats:
        """(n, n + P) by torque and parameters; ``given.state`` is a share of its half range, -1 ... 1."""
        return np.array(self.slope(*self._arguments(given, values)))

    @staticmethod
    def _arguments(given: Joints, values: Numbers) -> list[Floats | float]:
        return [given.torque, given.angle, given.state, given.temperature, *values.values()]


class PlaceLaw:
    """The place slot of one place as a function of wrench, temperature and parameters."""

    def __init__(self, effect: Effect, at: Place, values: Numbers) -> None:
        p = symbols(values)
        w, temperature = ca.SX.sym("wrench", 6), ca.SX.sym("temperature")
        if effect.place is None:
            raise TypeError(f"{effect} has no place slot")
        moved = effect.place(PlaceInput(at.place, w, temperature, at.inner, at.outer), p)
        self.shape = moved.shape
        arguments = [w, temperature, *p.values()]
        self.value = ca.Function("place", arguments, [ca.densify(moved)])
        self.slope = ca.Function("slope", arguments, [ca.densify(ca.jacobian(moved, ca.vertcat(w, *p.values())))])

    def __call__(self, w: Floats, temperature: float, values: Numbers) -> Floats:
        return np.array(self.value(w, temperature, *values.values())).ravel()

    def jacobian(self, w: Floats, temperature: float, values: Numbers) -> Floats:
        return np.array(self.slope(w, temperature, *values.values()))


class Law:
    """Any other slot: its argument and the parameters as one vector -> value and Jacobian."""

    def __init__(self, slot: Callable[[ca.SX, Mapping[str, ca.SX]], ca.SX], size: int, values: Numbers) -> None:
        p, x = symbols(values), ca.SX.sym("x", size)
        out = slot(x, p)
        self.shape = out.shape
        whole = ca.vertcat(x, *p.values())
        self.function = ca.Function("law", [whole], [ca.densify(out), ca.densify(ca.jacobian(out, whole))])

    def __call__(self, x: Floats) -> Floats:
        return np.array(self.function(x)[0]).ravel()

    def jacobian(self, x: Floats) -> Floats:
        return np.array(self.function(x)[1])


def other_laws(effect: Effect, values: Numbers, to_tool: Floats) -> dict[str, tuple[Law, Floats]]:
    """Slots angle, torque, mass, readings and process, where filled, each with a point (argument and parameters)."""
    rng = np.random.default_rng(5)
    tail = list(values.values())
    out: dict[str, tuple[Law, Floats]] = {}
    if effect.angle is not None:
        out["angle"] = Law(effect.angle, N, values), np.concatenate([rng.uniform(-2, 2, N), *tail])
    if effect.torque is not None:
        out["torque"] = Law(effect.torque, N, values), np.concatenate([rng.uniform(-2, 2, N), *tail])
    if effect.mass is not None:
        masses = effect.mass
        law = Law(lambda x, p: ca.vertcat(*(ca.vertcat(m.mass, m.com) for m in masses(N, p))), 0, values)
        out["mass"] = law, np.concatenate(tail)
    if effect.wrench_reading is not None:
        acting = effect.wrench_reading
        law = Law(lambda x, p: acting(ShownWrench(x, ca.SX(ca.DM(to_tool))), p), 6, values)
        out["wrench_reading"] = law, np.concatenate([wrench(5), *tail])
    if effect.position_reading is not None:
        shown = effect.position_reading
        law = Law(lambda x, p: shown(x[:3], x[3], p), 4, values)
        out["position_reading"] = law, np.concatenate([rng.uniform(-3, 3, 3), [5000.0], *tail])
    if effect.process_wrench is not None:
        cuts = effect.process_wrench
        law = Law(lambda x, p: cuts(ProgrammedWrench(x, ca.SX(ca.DM(to_tool))), p), 6, values)
        out["process_wrench"] = law, np.concatenate([wrench(5), *tail])
    if effect.surface_reading is not None:
        out["surface_reading"] = Law(effect.surface_reading, 1, values), np.concatenate([[2e-4], *tail])
    return out
