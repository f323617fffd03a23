"""The catalogue's physics: no load no deflection, passive, stable, derivatives that are those of differences."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial.transform import Rotation

from stiffness.effects.effect import Effect, Parameter, ShownWrench
from tests.contracts.effect_laws import (
    STIFFNESS,
    JointLaw,
    N,
    Numbers,
    PlaceLaw,
    every_effect,
    joints,
    neutral,
    oracle_of,
    other_laws,
    place,
    sample,
    shares,
    states_of,
    wrench,
)

Floats = npt.NDArray[np.float64]
ANGLES = [0.3, -2.9, 1.7, 4.1, -6.0, 3.2]
TURN = Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix()


@every_effect
@pytest.mark.parametrize("seed", range(3))
def test_no_load_no_deflection(effect: Effect, seed: int) -> None:
    if oracle_of(effect).without_load:
        return
    values = sample(effect, seed)
    if effect.joint:
        unloaded = joints(effect, values, seed, torque=np.zeros(N), state=np.zeros(states_of(effect)), temperature=0.0)
        np.testing.assert_array_equal(JointLaw(effect, values)(unloaded, values), 0)
    for k in effect.places(N):
        np.testing.assert_array_equal(PlaceLaw(effect, place(k, seed), values)(np.zeros(6), 0.0, values), 0)


@every_effect
@pytest.mark.parametrize("seed", range(3))
def test_neutral_values_do_nothing(effect: Effect, seed: int) -> None:
    values = neutral(effect, seed)
    if values is None:
        assert effect.name == "joint-stiffness"  # an arm without it would be rigid, and there is no such value
        return
    assert all(np.all((p.low <= values[p.name]) & (values[p.name] <= p.high)) for p in effect.parameters)
    assert effect.check(values) == ""
    if effect.joint:
        given = joints(effect, values, seed)
        np.testing.assert_allclose(JointLaw(effect, values)(given, values), 0, atol=1e-18)
    for k in effect.places(N):
        np.testing.assert_allclose(PlaceLaw(effect, place(k, seed), values)(wrench(seed), 9.0, values), 0, atol=1e-18)
    p = {k: ca.SX(ca.DM(v)) for k, v in values.items()}
    if effect.angle:
        np.testing.assert_array_equal(np.array(ca.evalf(ca.densify(effect.angle(ca.SX(ca.DM(ANGLES)), p)))), 0)
    if effect.torque:
        np.testing.assert_allclose(np.array(ca.evalf(effect.torque(ca.SX.ones(N), p))), 0, atol=1e-12)
    if effect.mass:
        assert all(float(ca.evalf(m.mass)) == 0 for m in effect.mass(N, p))
    if effect.wrench_reading:
        given = ShownWrench(ca.SX(ca.DM(wrench(seed))), ca.SX(ca.DM(TURN)))
        got = np.array(ca.evalf(ca.densify(effect.wrench_reading(given, p)))).ravel()
        np.testing.assert_allclose(got, wrench(seed), rtol=1e-12)
    if effect.position_reading:
        x = np.array([1.2, -0.7, 2.5])
        for time in (0.0, 5e3, 1e9):
            got = np.array(ca.evalf(ca.densify(effect.position_reading(ca.SX(ca.DM(x)), ca.SX(time), p)))).ravel()
            np.testing.assert_array_equal(got, x)


@every_effect
@pytest.mark.parametrize("seed", range(20))
def test_a_deflection_never_works_against_its_load(effect: Effect, seed: int) -> None:
    if oracle_of(effect).without_load:
        return
    values = sample(effect, seed)
    if effect.joint:
        given = joints(effect, values, seed)
        if effect.memory and effect.memory.deflection and not oracle_of(effect).on_base:
            # The state is itself a deflection: it lies where a torque beyond everything has put it.
            clamp = effect.memory.rule(np.zeros((1, N)), 1e10 * np.sign(given.torque)[None], values, STIFFNESS)
            given = replace(given, state=np.clip(given.state, clamp.low[0], clamp.high[0]))
        dq = JointLaw(effect, values)(given, values)
        if oracle_of(effect).on_base:
            if effect.memory:  # wind-up that stays stands against a small load: test_a_cycle_of_load_gains_no_energy
                return
            dq = dq + given.torque / STIFFNESS
        if effect.name == "joint-coupling":  # one joint alone may go either way
            assert given.torque @ dq > 0
            return
        work = given.torque * dq
        assert np.all(work >= 0) and work.max() > 0
    for k in effect.places(N):
        assert wrench(seed) @ PlaceLaw(effect, place(k, seed), values)(wrench(seed), 0.0, values) >= 0


@every_effect
@pytest.mark.parametrize("seed", range(3))
def test_more_load_never_deflects_less(effect: Effect, seed: int) -> None:
    """Stable: the slope of every law along its own load is not negative."""
    if oracle_of(effect).without_load:
        return
    values = sample(effect, seed)
    if effect.joint:
        share = shares(effect, seed)
        slope = JointLaw(effect, values).jacobian(joints(effect, values, seed, state=share), values)[:, :N]
        if oracle_of(effect).on_base:
            slope = slope + np.diag(1 / STIFFNESS)
        assert np.linalg.eigvalsh(slope + slope.T).min() >= -1e-18
    for k in effect.places(N):
        slope = PlaceLaw(effect, place(k, seed), values).jacobian(wrench(seed), 0.0, values)[:, :6]
        scaled = slope / np.outer(*2 * [np.sqrt(np.maximum(np.diag(slope), 1e-30))])
        assert np.linalg.eigvalsh(scaled + scaled.T).min() >= -1e-9


@every_effect
@pytest.mark.parametrize("seed", range(3))
def test_derivatives_are_those_of_finite_differences(effect: Effect, seed: int) -> None:
    """By the load and by every parameter, away from corners."""
    values = sample(effect, seed)
    if effect.joint:
        law = JointLaw(effect, values)
        given = joints(effect, values, seed, state=shares(effect, seed))

        def joint_at(x: Floats) -> Floats:
            now = split(x[N:], values)
            half = effect.memory.bounds(now) if effect.memory else np.zeros(N)
            return law(replace(given, torque=x[:N], state=given.state * half), now)

        x = np.concatenate([given.torque, *values.values()])
        same_slope(law.jacobian(given, values), joint_at, x)
    for k in effect.places(N)[:2]:
        law = PlaceLaw(effect, place(k, seed), values)

        def displacement_at(x: Floats, law: PlaceLaw = law) -> Floats:
            return law(x[:6], 5.0, split(x[6:], values))

        x = np.concatenate([wrench(seed), *values.values()])
        same_slope(law.jacobian(wrench(seed), 5.0, values), displacement_at, x)


@every_effect
@pytest.mark.parametrize("seed", range(3))
def test_derivatives_of_the_other_slots(effect: Effect, seed: int) -> None:
    values = sample(effect, seed)
    laws = other_laws(effect, values, TURN)
    assert len(laws) == sum(s is not None for s in (effect.angle, effect.torque, effect.mass, *readings(effect)))
    for law, x in laws.values():
        same_slope(law.jacobian(x), law, x)


@every_effect
def test_a_search_can_leave_the_neutral_values(effect: Effect) -> None:
    """There, where diagnosis begins: slopes are finite, and every number that has a neutral value is felt; what is
    freed only where the data ask for it, once the effect is there."""
    assert _felt(effect, effect.neutral(N)) >= {p.name for p in _leads(effect) if not p.extra}
    own = effect.parameters
    there = {p.name: np.full(p.count(N), p.start if p.neutral is None or not p.extra else p.neutral) for p in own}
    assert _felt(effect, there) >= {p.name for p in _leads(effect) if p.extra}


def _leads(effect: Effect) -> list[Parameter]:
    return [p for p in effect.parameters if p.neutral is not None and p.fit != "given"]


def _felt(effect: Effect, values: Numbers) -> set[str]:
    """Names of the numbers that some slot follows."""
    felt, sizes = set[str](), [(p.name, p.count(N)) for p in effect.parameters]
    slopes: list[Floats] = []
    if effect.joint:
        share = np.random.default_rng(6).choice([-0.8, 0.6], states_of(effect))
        slopes.append(JointLaw(effect, values).jacobian(joints(effect, values, 6, state=share), values))
    for k in effect.places(N):
        slopes.append(PlaceLaw(effect, place(k, 6), values).jacobian(wrench(6), 8.0, values))
    slopes += [law.jacobian(x) for law, x in other_laws(effect, values, TURN).values()]
    for slope in slopes:
        assert np.isfinite(slope).all()
        numbers = slope[:, slope.shape[1] - sum(count for _, count in sizes) :]
        ends = np.cumsum([count for _, count in sizes])
        parts = np.split(numbers, ends[:-1], axis=1)
        felt |= {name for (name, _), part in zip(sizes, parts, strict=True) if np.any(part != 0)}
    return felt


def readings(effect: Effect) -> tuple[object, ...]:
    return effect.wrench_reading, effect.position_reading, effect.process_wrench, effect.surface_reading


@every_effect
def test_an_internal_spring_has_a_potential(effect: Effect) -> None:
    """Its stiffness is symmetric; between two pins, once round the joint it gives back what it took."""
    if effect.torque is None:
        return
    values = sample(effect, 4)
    law, x = other_laws(effect, values, TURN)["torque"]
    slope = law.jacobian(x)[:, :N]
    np.testing.assert_allclose(slope, slope.T, atol=1e-12 * np.abs(slope).max())
    for j in range(N) if effect.name == "gravity-compensator" else ():
        turn = np.linspace(0, 2 * np.pi, 400, endpoint=False)
        work = [law(np.r_[x[:j], x[j] + a, x[j + 1 :]])[j] for a in turn]
        assert abs(np.mean(work)) < 1e-9 * (1 + np.abs(work).max())


@every_effect
@pytest.mark.parametrize("seed", range(3))
def test_a_cycle_of_load_gains_no_energy(effect: Effect, seed: int) -> None:
    """A joint that stands, loaded to and fro: what it gives back is at most what was put in."""
    if effect.joint is None or effect.memory is None:
        return
    values, steps = sample(effect, seed), 400
    law, amplitude = JointLaw(effect, values), np.random.default_rng(seed).uniform(0.3, 3, N) * 500
    once = np.abs(np.linspace(0, 4, steps, endpoint=False)[:, None] % 4 - 2) - 1  # a triangle: 1, -1, 1
    torque = amplitude * np.vstack([once, once, once[:1]])
    clamp = effect.memory.rule(np.zeros_like(torque), torque, values, STIFFNESS)
    state, dq = np.zeros(states_of(effect)), np.empty_like(torque)
    for k, tau in enumerate(torque):
        state = np.clip(state + clamp.shift[k], clamp.low[k], clamp.high[k])
        given = joints(effect, values, seed, torque=tau, state=state)
        dq[k] = law(given, values) + tau / STIFFNESS
    second = slice(steps, None)
    work = (0.5 * (torque[1:] + torque[:-1]) * np.diff(dq, axis=0))[second].sum(axis=0)
    one_step = 8 * amplitude / steps * np.ptp(dq, axis=0)
    assert np.all(work > -one_step)
    if effect.name == "joint-friction":
        whole = 1 + sum(values[f"weight_{name}"] for name in ("half", "double", "quarter"))
        loop = np.zeros(N)
        for ratio, name in ((1.0, ""), (0.5, "weight_half"), (2.0, "weight_double"), (0.25, "weight_quarter")):
            held = ratio * values["friction_nm"] * values.get(name, 1.0) / whole
            slips = ratio * values["friction_nm"] / values["held"]  # the load at which it slips
            loop += np.where(amplitude > slips, 4 * held / STIFFNESS * (amplitude - slips), 0)
        assert loop.max() > 1e-3
        np.testing.assert_allclose(work, loop, rtol=0.02, atol=1e-12)


def split(x: Floats, values: Numbers) -> Numbers:
    ends = np.cumsum([len(v) for v in values.values()])
    return dict(zip(values, np.split(x, ends[:-1]), strict=True))


def same_slope(slope: Floats, function, x: Floats) -> None:  # type: ignore[no-untyped-def]
    assert np.abs(slope).max() > 0 and np.isfinite(slope).all()
    for i in range(len(x)):
        near = abs(x[i]) or 1e-3
        h = 1e-5 * near
        e = np.eye(len(x))[i] * h
        difference = (function(x + e) - function(x - e)) / (2 * h)
        size = np.abs(difference) + 1e-4 * np.abs(function(x)) / near
        np.testing.assert_array_less(np.abs(slope[:, i] - difference), 1e-6 * size + 1e-22)
