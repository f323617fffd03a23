"""One suite over the whole catalogue: a new effect needs a line there, an oracle, and a section in docs/effects*.md.

Here: what an effect says of itself, and its slots against the oracles. Physics in test_effects_physics, model files and
pages in test_effects_files.
"""

from __future__ import annotations

from dataclasses import FrozenInstanceError, replace
from importlib import import_module
from pathlib import Path

import casadi as ca
import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial.transform import Rotation

import stiffness.effects
from stiffness.effects import BASE, BUILT_IN, BY_NAME, CATALOGUE
from stiffness.effects.effect import Effect, ProgrammedWrench, ShownWrench
from tests.contracts.effect_laws import (
    STIFFNESS,
    JointLaw,
    N,
    PlaceLaw,
    every_effect,
    joints,
    neutral,
    oracle_of,
    place,
    sample,
    wrench,
)
from tests.oracles.effects import ORACLES, Step

Floats = npt.NDArray[np.float64]
FOLDER = Path(stiffness.effects.__file__).parent
SUFFIX = {  # the longer ones first
    "_nm_per_rad": "N*m/rad",
    "_rad_per_nm": "rad/(N*m)",
    "_m_per_n": "m/N",
    "_rad_per_k": "rad/K",
    "_per_k": "1/K",
    "_rad_per_s": "rad/s",
    "_m_per_s": "m/s",
    "_nm": "N*m",
    "_n": "N",
    "_rad": "rad",
    "_kg": "kg",
    "_m": "m",
    "_s": "s",
}
SLOTS = {  # physics.md, "Effects"
    "joint-stiffness": {"joint"},
    "preload-softening": {"joint"},
    "backlash": {"joint"},
    "joint-hardening": {"joint"},
    "joint-friction": {"joint"},
    "joint-coupling": {"joint"},
    "posture-stiffness": {"joint"},
    "kinematic-offset": {"joint", "place"},
    "joint-angle-error": {"angle"},
    "gravity-compensator": {"torque"},
    "payload": {"mass"},
    "base-compliance": {"place"},
    "link-compliance": {"place"},
    "tool-compliance": {"place"},
    "thermal-drift": {"joint", "place"},
    "tracker-drift": {"position_reading"},
    "force-sensor-bias": {"wrench_reading"},
    "cutting-force": {"process_wrench"},
    "cutter-size": {"surface_reading"},
}
ACTS_AT = {
    "kinematic-offset": (1, 2, 3, 4, 5, 6),
    "base-compliance": (0,),
    "link-compliance": (1, 2, 3, 4, 5),
    "tool-compliance": (6,),
    "thermal-drift": (0, 1, 2, 3, 4, 5, 6),
}
SITES = {  # kind: name of the k-th site, how many there are
    "joint": (lambda k, n: (f"joint-{k + 1}",), lambda n: n),
    "link": (lambda k, n: (f"link-{k + 1}",), lambda n: n),
    "inner-link": (lambda k, n: (f"link-{k + 1}",), lambda n: n - 1),
    "pair": (lambda k, n: PAIRS[k], lambda n: n * (n - 1) // 2),
    "place": (lambda k, n: ("base" if k == 0 else "tool" if k == n else f"link-{k}",), lambda n: n + 1),
}
PAIRS = [(f"joint-{c + 1}", f"joint-{r + 1}") for r, c in zip(*np.tril_indices(8, -1), strict=True)]
ALL_SLOTS = (
    *("joint", "angle", "torque", "mass", "place"),
    *("wrench_reading", "position_reading", "process_wrench", "surface_reading"),
)
READINGS = {"wrench_reading", "position_reading"}
CUTS = {"process_wrench", "surface_reading"}
TURN = Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix()


# ------------------------------------------------------------------------------------ the catalogue


def test_every_effect_has_an_oracle() -> None:
    assert [e.name for e in CATALOGUE if e.name not in ORACLES] == []


def test_names_are_unique_and_joint_stiffness_comes_first() -> None:
    assert len(BY_NAME) == len(CATALOGUE)
    assert CATALOGUE[0].name == "joint-stiffness"


def test_every_file_of_an_effect_stands_in_the_catalogue_under_its_name() -> None:
    found = set()
    for path in sorted(FOLDER.glob("*.py")):
        if not path.stem.startswith("__"):
            effect = getattr(import_module(f"stiffness.effects.{path.stem}"), "EFFECT", None)
            if effect is not None:
                assert effect.name == path.stem.replace("_", "-")
                found.add(effect.name)
    assert found == {e.name for e in BUILT_IN} <= set(BY_NAME)


@every_effect
def test_an_effect_is_closed_and_says_what_it_is(effect: Effect) -> None:
    slots = {s for s in ALL_SLOTS if getattr(effect, s) is not None}
    assert slots == SLOTS.get(effect.name, slots) != set()
    assert slots <= READINGS if effect.scope == "instruments" else not slots & READINGS
    assert slots <= CUTS if effect.scope == "process" else not slots & CUTS
    assert bool(effect.place) == bool(effect.places(N))
    assert effect not in BUILT_IN or effect.places(N) == ACTS_AT.get(effect.name, ())
    assert all(0 <= k <= N for k in effect.places(N)) and len(set(effect.places(N))) == len(effect.places(N))
    assert effect.memory is None or effect.joint is not None
    assert effect.scope in ("robot", "tool", "instruments", "process")
    assert len(effect.cause) > 20 and "\n" not in effect.cause and not effect.cause.endswith(".")
    with pytest.raises(FrozenInstanceError):
        effect.name = "other"  # type: ignore[misc]
    assert repr(effect) == f"Effect({effect.name})"


@every_effect
def test_parameters_can_begin_an_identification(effect: Effect) -> None:
    assert len({p.name for p in effect.parameters}) == len(effect.parameters)
    for p in effect.parameters:
        assert np.isfinite([p.low, p.high, p.start, p.scale]).all()
        assert p.low <= p.start <= p.high and p.low < p.high and p.scale > 0
        assert p.default is None or p.low <= p.default <= p.high
        assert p.neutral is None or p.low <= p.neutral <= p.high
        assert p.trials_of in ("", "torque") and p.fit in ("direct", "inverse", "given")
        for trial in p.trials:
            assert p.low <= trial <= p.high and trial != p.neutral
            assert p.trials_of == "" or 0 <= trial <= 1e3
        assert not p.extra or p.default is not None  # a file that never freed it need not have it
        assert p.meaning and p.count(N) >= 1
        suffix = next((s for s in SUFFIX if p.name.endswith(s)), None)
        if suffix:
            assert p.unit == SUFFIX[suffix], f"{p.name}: {p.unit}"
        else:
            assert p.unit == "1" or ", " in p.unit, f"{p.name} does not say its unit {p.unit}"
    start = {p.name: np.full(p.count(N), p.start) for p in effect.parameters}
    assert effect.check(start) == "" and effect.check(sample(effect, 0)) == ""


@every_effect
@pytest.mark.parametrize("n", [4, 6, 7])
def test_numbers_belong_to_sites(effect: Effect, n: int) -> None:
    """Sites are distinct, the numbers of each exist, and every number that some slot reads has a site."""
    sites, kinds = effect.sites(n), effect.site_kind.split("|")
    assert len({(s.kind, s.where) for s in sites}) == len(sites) >= 1
    assert {s.kind for s in sites} == (set(kinds) if len(kinds) > 1 else {""})
    assert {p.site for p in effect.parameters} == {s.kind for s in sites}
    for kind in kinds:
        own = [s for s in sites if s.kind == (kind if len(kinds) > 1 else "")]
        parameters = [p for p in effect.parameters if p.site == own[0].kind]
        if kind not in SITES:
            assert [(s.where, s.index) for s in own] == [((kind,), None)]
            assert all(isinstance(p.size, int) for p in parameters)
            continue
        named, count = SITES[kind]
        assert [s.where for s in own] == [named(k, n) for k in range(count(n))]
        assert [s.index for s in own] == list(range(len(own)))
        for p in parameters:
            more = 1 if kind == "inner-link" else 0  # the last link is the tool's place
            assert p.count(n) == (len(own) + more) * p.each
            numbers = [list(range(p.count(n)))[p.of_site(s.index)] for s in own]
            assert numbers == [list(range(k * p.each, (k + 1) * p.each)) for k in range(len(own))]


@pytest.mark.parametrize("n", [2, 3, 6])
def test_pairs_are_counted_row_by_row_below_the_diagonal(n: int) -> None:
    effect = BY_NAME["joint-coupling"]
    rows, columns = np.tril_indices(n, -1)
    expected = [(f"joint-{c + 1}", f"joint-{r + 1}") for r, c in zip(rows, columns, strict=True)]
    assert [s.where for s in effect.sites(n)] == expected and len(expected) == effect.parameters[0].count(n)


@every_effect
def test_a_number_of_a_site_acts_at_that_site(effect: Effect) -> None:
    """A change of number k of a joint moves joint k alone; of a link or place, that place alone."""
    if effect.name == "joint-coupling" or len(effect.sites(N)) == 1:
        return
    values = sample(effect, 3)
    for p in effect.parameters:
        for k in range(p.count(N)) if p.each == 1 else ():  # tables: test_angle_tables
            now = {**values, p.name: values[p.name] * (1 + 0.25 * (np.arange(p.count(N)) == k))}
            if effect.joint:
                given = joints(effect, values, 3)
                change = JointLaw(effect, values)(given, now) - JointLaw(effect, values)(given, values)
                assert np.all(change[np.arange(N) != k] == 0)
            moved = []
            for at in effect.places(N):
                law = PlaceLaw(effect, place(at, 3), values)
                if np.any(law(wrench(3), 8.0, now) != law(wrench(3), 8.0, values)):
                    moved.append(at)
            first = min(effect.places(N), default=0)
            assert moved in ([], [k + first])


@every_effect
def test_neutral_values_are_those_of_the_oracle(effect: Effect) -> None:
    stated = {p.name: p.neutral for p in effect.parameters if p.neutral is not None}
    assert stated == (oracle_of(effect).nothing or {})
    values = effect.neutral(N)
    assert list(values) == [p.name for p in effect.parameters]
    for p in effect.parameters:
        np.testing.assert_array_equal(values[p.name], np.full(p.count(N), stated.get(p.name, p.start)))
    assert effect.check(values) == ""
    assert neutral(effect, 0) is not None or effect.name == "joint-stiffness"


@every_effect
def test_effects_without_memory_or_threshold_are_odd_in_their_load(effect: Effect) -> None:
    """``needs_torque_sign`` is set where doubling a torque does not double the deflection."""
    if effect.joint is None or oracle_of(effect).without_load:
        assert not effect.needs_torque_sign
        return
    values = sample(effect, 1)
    law, given = JointLaw(effect, values), joints(effect, values, 1)
    once, twice = (law(replace(given, torque=f * given.torque), values) for f in (1.0, 2.0))
    linear = np.allclose(twice, 2 * once, rtol=1e-9, atol=1e-18)
    reversed_too = np.allclose(law(replace(given, torque=-given.torque), values), -once, rtol=1e-9, atol=1e-18)
    assert effect.needs_torque_sign == (not (linear and reversed_too))


@every_effect
def test_thermal_effects_are_those_that_temperature_moves(effect: Effect) -> None:
    """``thermal`` is set where the law is nothing at the reference temperature and something above it."""
    if effect.joint is None:
        assert not effect.thermal
        return
    values = sample(effect, 1)
    law, given = JointLaw(effect, values), joints(effect, values, 1)
    cold, warm = (law(replace(given, temperature=t), values) for t in (0.0, 7.0))
    assert effect.thermal == bool(np.abs(cold).max() == 0.0 < np.abs(warm).max())


@every_effect
@pytest.mark.parametrize("seed", range(3))
def test_restarts_are_values_that_a_fit_may_begin_with(effect: Effect, seed: int) -> None:
    """Allowed, with every extra that vanishes at neutral awake; what a joint does not have it does not get."""
    values = sample(effect, seed)
    found = effect.restarts(values)
    assert bool(found) == (effect.name in ("joint-hardening", "joint-friction"))
    extras = [p for p in effect.parameters if p.extra and p.neutral is not None]
    for more in found:
        assert more.keys() == values.keys() and effect.check(more) == ""
        for p in effect.parameters:
            assert more[p.name].shape == values[p.name].shape
            assert np.all((more[p.name] >= p.low) & (more[p.name] <= p.high))
        assert all(np.all(more[p.name] != p.neutral) for p in extras)
    for more in effect.restarts(effect.neutral(N)):
        given = joints(effect, more, seed)
        np.testing.assert_allclose(JointLaw(effect, more)(given, more), 0, atol=1e-18)


def test_one_effect_is_the_base_model() -> None:
    assert [e for e in CATALOGUE if e.is_base] == [BASE] == [CATALOGUE[0]]


@every_effect
def test_what_readings_make_identification_fit_can_show(effect: Effect) -> None:
    """Positions without load show what is there unloaded, approaches what remembers them."""
    assert effect.fitted_where != "position" or effect.unloaded
    assert effect.fitted_where != "approach" or effect.memory is not None
    assert effect.fitted_where == "load" or not effect.is_base


# ------------------------------------------------------------------------------------ against oracles


@every_effect
@pytest.mark.parametrize("seed", range(5))
def test_joint_law_is_that_of_the_oracle(effect: Effect, seed: int) -> None:
    expected = oracle_of(effect).joint
    assert (expected is None) == (effect.joint is None)
    if expected is None:
        return
    values = sample(effect, seed)
    law, given = JointLaw(effect, values), joints(effect, values, seed)
    assert law.shape == (N, 1)
    got, wanted = law(given, values), expected(given, values)
    np.testing.assert_allclose(got, wanted, rtol=1e-9, atol=1e-16)
    assert np.abs(wanted).max() > 1e-7


@every_effect
@pytest.mark.parametrize("seed", range(3))
def test_displacement_of_a_place_is_that_of_the_oracle(effect: Effect, seed: int) -> None:
    expected = oracle_of(effect).place
    assert (expected is None) == (effect.place is None)
    if expected is None:
        return
    values = sample(effect, seed)
    moves = [i for i in range(6) if i not in oracle_of(effect).still]
    for k in effect.places(N):
        given = place(k, seed)
        law = PlaceLaw(effect, given, values)
        assert law.shape == (6, 1)
        wanted = expected(given, values)
        np.testing.assert_allclose(law(given.wrench, given.temperature, values), wanted, rtol=1e-9, atol=1e-17)
        assert np.abs(wanted[moves]).min() > 1e-9


@every_effect
@pytest.mark.parametrize("seed", range(5))
def test_internal_springs_and_masses_are_those_of_the_oracle(effect: Effect, seed: int) -> None:
    expected = oracle_of(effect)
    assert (expected.torque is None) == (effect.torque is None)
    assert (expected.angle is None) == (effect.angle is None)
    assert (expected.mass is None) == (effect.mass is None)
    values = sample(effect, seed)
    p = {k: ca.SX(ca.DM(v)) for k, v in values.items()}
    if effect.angle and expected.angle:
        commanded = np.random.default_rng(seed).uniform(-7, 7, N)
        error = ca.densify(effect.angle(ca.SX(ca.DM(commanded)), p))
        assert error.shape == (N, 1)
        wanted = expected.angle(commanded, values)
        np.testing.assert_allclose(np.array(ca.evalf(error)).ravel(), wanted, rtol=1e-9, atol=1e-15)
        assert np.abs(wanted).max() > 1e-3
    if effect.torque and expected.torque:
        angle = np.random.default_rng(seed).uniform(-2, 2, N)
        got = ca.densify(effect.torque(ca.SX(ca.DM(angle)), p))
        assert got.shape == (N, 1)
        wanted = expected.torque(angle, values)
        np.testing.assert_allclose(np.array(ca.evalf(got)).ravel(), wanted, rtol=1e-9, atol=1e-9)
        assert np.abs(wanted).max() > 1
    if effect.mass and expected.mass:
        for got_mass, (link, kg, com) in zip(effect.mass(N, p), expected.mass(N, values), strict=True):
            assert got_mass.link == link and 0 <= link <= N
            assert float(ca.evalf(got_mass.mass)) == pytest.approx(kg)
            np.testing.assert_allclose(np.array(ca.evalf(ca.densify(got_mass.com))).ravel(), com, atol=1e-12)


@every_effect
@pytest.mark.parametrize("seed", range(6))
def test_readings_are_those_of_the_oracle(effect: Effect, seed: int) -> None:
    expected = oracle_of(effect)
    assert (expected.wrench_reading is None) == (effect.wrench_reading is None)
    assert (expected.position_reading is None) == (effect.position_reading is None)
    values, rng = sample(effect, seed), np.random.default_rng(seed)
    p = {k: ca.SX(ca.DM(v)) for k, v in values.items()}
    if effect.wrench_reading and expected.wrench_reading:
        shown = wrench(seed)
        got = ca.densify(effect.wrench_reading(ShownWrench(ca.SX(ca.DM(shown)), ca.SX(ca.DM(TURN))), p))
        assert got.shape == (6, 1)
        wanted = expected.wrench_reading(shown, TURN, values)
        np.testing.assert_allclose(np.array(ca.evalf(got)).ravel(), wanted, rtol=1e-11, atol=1e-11)
        assert np.abs(wanted - shown).min() > 1e-3
    if effect.position_reading and expected.position_reading:
        for time in (0.0, 1.0, 900.0, 9.99e3, 1.001e4, 3e4):
            x = rng.uniform(-3, 3, 3)
            got = ca.densify(effect.position_reading(ca.SX(ca.DM(x)), ca.SX(time), p))
            assert got.shape == (3, 1)
            wanted = expected.position_reading(x, time, values)
            np.testing.assert_allclose(np.array(ca.evalf(got)).ravel() - x, wanted - x, rtol=1e-9, atol=2e-15)
            assert time < 100 or np.abs(wanted - x).min() > 1e-8


@every_effect
@pytest.mark.parametrize("seed", range(4))
def test_what_a_process_does_is_that_of_the_oracle(effect: Effect, seed: int) -> None:
    expected = oracle_of(effect)
    assert (expected.process_wrench is None) == (effect.process_wrench is None)
    assert (expected.surface_reading is None) == (effect.surface_reading is None)
    values = sample(effect, seed)
    p = {k: ca.SX(ca.DM(v)) for k, v in values.items()}
    if effect.process_wrench and expected.process_wrench:
        said = wrench(seed)
        got = ca.densify(effect.process_wrench(ProgrammedWrench(ca.SX(ca.DM(said)), ca.SX(ca.DM(TURN))), p))
        wanted = expected.process_wrench(said, TURN, values)
        np.testing.assert_allclose(np.array(ca.evalf(got)).ravel(), wanted, rtol=1e-11, atol=1e-11)
        assert np.abs(wanted - said).min() > 1e-3
    if effect.surface_reading and expected.surface_reading:
        got = effect.surface_reading(ca.SX(1.5e-4), p)
        assert float(ca.evalf(got)) == pytest.approx(expected.surface_reading(1.5e-4, values), rel=1e-12)


@every_effect
@pytest.mark.parametrize("seed", range(4))
def test_memory_advances_as_the_oracle_says(effect: Effect, seed: int) -> None:
    step = oracle_of(effect).step
    assert (step is None) == (effect.memory is None)
    if step is None or effect.memory is None:
        return
    values, rng = sample(effect, seed), np.random.default_rng(seed)
    half = effect.memory.bounds(values)
    count, states = N * effect.memory.states, effect.memory.states
    assert states == oracle_of(effect).states
    assert half.shape == (count,) and np.all(half >= 0)
    move = rng.choice([0.0, 1e-7, 1e-5, 1e-3], (40, N)) * rng.choice([-1, 1], (40, N))
    torque = rng.choice([0.0, 1e-3, 0.1, 30.0, 3000.0], (40, N)) * rng.choice([-1, 1], (40, N))
    stiffness = STIFFNESS if seed % 2 else np.full(N, np.inf)
    clamp = effect.memory.rule(move, torque, values, stiffness)
    assert all(np.shape(a) == (40, count) for a in (clamp.shift, clamp.low, clamp.high))
    assert np.all(clamp.low <= clamp.high)
    assert np.all(clamp.low >= -half - 1e-18) and np.all(clamp.high <= half + 1e-18)
    state = rng.uniform(-half, half)
    rounding = 1e-12 if effect.memory.unit == "N*m" else 1e-15  # differences of thousands of N*m
    for k in range(40):
        after = np.clip(state + clamp.shift[k], clamp.low[k], clamp.high[k])
        for c in range(count):
            number, j = divmod(c, N)
            p = {name: float(v[j]) for name, v in values.items() if len(v) == N}
            now = Step(move[k, j], torque[k, j], torque[max(k - 1, 0), j], stiffness[j], number)
            assert after[c] == pytest.approx(step(state[c], now, p), abs=rounding)
        state = after
    wide = effect.memory.rule(move[:, None], torque[:, None], values, stiffness)
    assert all(np.shape(a) == (40, 1, count) for a in (wide.shift, wide.low, wide.high))
