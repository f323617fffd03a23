"""One suite over the whole catalogue: a new effect needs a line there, an oracle, and a section in docs/effects.md."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import FrozenInstanceError, replace
from importlib import import_module
from pathlib import Path

import casadi as ca
import numpy as np
import numpy.typing as npt
import pytest
import tomli_w

import stiffness.effects
from stiffness import model as model_module
from stiffness.effects import BY_NAME, CATALOGUE
from stiffness.effects.effect import Effect, JointInput, Parameter, TwistInput
from stiffness.effects.table import markdown
from stiffness.errors import ModelError
from stiffness.model import ComplianceModel, load_model, model_text
from tests.oracles.effects import ORACLES, Joints, Oracle

Floats = npt.NDArray[np.float64]
Numbers = dict[str, Floats]
N = 6
FOLDER = Path(stiffness.effects.__file__).parent
PAGE = Path(__file__).parents[2] / "docs" / "effects.md"
STIFFNESS = np.array([2.0e6, 1.7e6, 1.3e6, 2.8e5, 9.6e4, 3.7e4])
SUFFIX = {
    "_nm_per_rad": "N*m/rad",
    "_rad_per_nm": "rad/(N*m)",
    "_m_per_n": "m/N",
    "_per_k": "1/K",
    "_nm": "N*m",
    "_rad": "rad",
    "_kg": "kg",
    "_m": "m",
}

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


def symbols(values: Mapping[str, Floats]) -> dict[str, ca.SX]:
    return {k: ca.SX.sym(k, len(v)) for k, v in values.items()}


def joints(effect: Effect, values: Numbers, seed: int, **changes: object) -> Joints:
    """Random torques of both signs and states that the effect can have."""
    rng = np.random.default_rng(seed)
    half = effect.memory.bounds(values) if effect.memory else np.zeros(N)
    torque = rng.normal(size=N) * np.array([3e3, 3e3, 2e3, 500, 300, 200])
    given = Joints(torque, STIFFNESS, rng.uniform(-3, 3, N), rng.uniform(-1, 1, N) * half, rng.uniform(-10, 20))
    return replace(given, **changes)  # type: ignore[arg-type]


class JointLaw:
    """The joint slot as a function of torque, angle, state, temperature and parameters."""

    def __init__(self, effect: Effect, values: Numbers) -> None:
        p = symbols(values)
        self.torque, angle, state = (ca.SX.sym(s, N) for s in ("torque", "angle", "state"))
        temperature = ca.SX.sym("temperature")
        if effect.joint is None:
            raise TypeError(f"{effect} has no joint slot")
        dq = effect.joint(JointInput(self.torque, self.torque / STIFFNESS, angle, state, temperature), p)
        self.shape = dq.shape
        arguments = [self.torque, angle, state, temperature, *p.values()]
        self.value = ca.Function("dq", arguments, [ca.densify(dq)])
        wanted = ca.vertcat(self.torque, *p.values())
        if effect.memory:  # identification holds the share of the range fixed, not the state
            share = state * ca.SX(effect.memory.bounds(p))
            dq = effect.joint(JointInput(self.torque, self.torque / STIFFNESS, angle, share, temperature), p)
        self.slope = ca.Function("slope", arguments, [ca.densify(ca.jacobian(dq, wanted))])

    def __call__(self, given: Joints, values: Numbers) -> Floats:
        return np.array(self.value(*self._arguments(given, values))).ravel()

    def jacobian(self, given: Joints, values: Numbers) -> Floats:
        """(n, n + P) by torque and parameters; ``given.state`` is a share of its half range, -1 ... 1."""
        return np.array(self.slope(*self._arguments(given, values)))

    @staticmethod
    def _arguments(given: Joints, values: Numbers) -> list[Floats | float]:
        return [given.torque, given.angle, given.state, given.temperature, *values.values()]


class TwistLaw:
    """The twist slot of one place as a function of wrench, temperature and parameters."""

    def __init__(self, effect: Effect, place: int, values: Numbers) -> None:
        p = symbols(values)
        wrench, temperature = ca.SX.sym("wrench", 6), ca.SX.sym("temperature")
        if effect.twist is None:
            raise TypeError(f"{effect} has no twist slot")
        twist = effect.twist(TwistInput(place, wrench, temperature), p)
        self.shape = twist.shape
        arguments = [wrench, temperature, *p.values()]
        self.value = ca.Function("twist", arguments, [ca.densify(twist)])
        self.slope = ca.Function("slope", arguments, [ca.densify(ca.jacobian(twist, ca.vertcat(wrench, *p.values())))])

    def __call__(self, wrench: Floats, temperature: float, values: Numbers) -> Floats:
        return np.array(self.value(wrench, temperature, *values.values())).ravel()

    def jacobian(self, wrench: Floats, temperature: float, values: Numbers) -> Floats:
        return np.array(self.slope(wrench, temperature, *values.values()))


def wrench(seed: int) -> Floats:
    return np.random.default_rng(seed).normal(size=6) * np.r_[np.full(3, 1000.0), np.full(3, 200.0)]


def nothing(effect: Effect, seed: int) -> Numbers | None:
    """Values for which there is no effect, the rest random."""
    neutral = oracle_of(effect).nothing
    if neutral is None:
        return None
    values = sample(effect, seed)
    return {k: np.full_like(v, neutral[k]) if k in neutral else v for k, v in values.items()}


# ------------------------------------------------------------------------------------ the catalogue


def test_every_effect_has_an_oracle() -> None:
    assert [e.name for e in CATALOGUE if e.name not in ORACLES] == []


def test_names_are_unique_and_joint_stiffness_comes_first() -> None:
    assert len(BY_NAME) == len(CATALOGUE)
    assert CATALOGUE[0].name == "joint-stiffness"


def test_every_file_of_an_effect_stands_in_the_catalogue_under_its_name() -> None:
    found = set()
    for path in sorted(FOLDER.glob("*.py")):
        if path.stem not in ("__init__", "__main__"):
            effect = getattr(import_module(f"stiffness.effects.{path.stem}"), "EFFECT", None)
            if effect is not None:
                assert effect.name == path.stem.replace("_", "-")
                found.add(effect.name)
    assert found == set(BY_NAME)


@every_effect
def test_an_effect_is_closed_and_says_what_it_is(effect: Effect) -> None:
    slots = [effect.joint, effect.torque, effect.mass, effect.twist]
    assert any(slots) or effect.scope == "instruments"
    assert bool(effect.twist) == bool(effect.places(N))
    assert all(0 <= k <= N for k in effect.places(N)) and len(set(effect.places(N))) == len(effect.places(N))
    assert effect.memory is None or effect.joint is not None
    assert effect.scope in ("robot", "tool", "instruments")
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
        assert p.meaning and p.count(N) >= 1
        suffix = next((s for s in SUFFIX if p.name.endswith(s)), None)
        if suffix:
            assert p.unit == SUFFIX[suffix], f"{p.name}: {p.unit}"
        else:
            assert p.unit == "1" or ", " in p.unit, f"{p.name} does not say its unit {p.unit}"
    start = {p.name: np.full(p.count(N), p.start) for p in effect.parameters}
    assert effect.check(start) == "" and effect.check(sample(effect, 0)) == ""


@every_effect
def test_effects_without_memory_or_threshold_are_odd_in_their_load(effect: Effect) -> None:
    """``needs_torque_sign`` is set where doubling a torque does not double the deflection."""
    if effect.joint is None or oracle_of(effect).without_load:
        return
    values = sample(effect, 1)
    law, given = JointLaw(effect, values), joints(effect, values, 1)
    once, twice = (law(replace(given, torque=f * given.torque), values) for f in (1.0, 2.0))
    linear = np.allclose(twice, 2 * once, rtol=1e-9, atol=1e-18)
    reversed_too = np.allclose(law(replace(given, torque=-given.torque), values), -once, rtol=1e-9, atol=1e-18)
    assert effect.needs_torque_sign == (not (linear and reversed_too))


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
def test_twist_is_that_of_the_oracle(effect: Effect, seed: int) -> None:
    expected = oracle_of(effect).twist
    assert (expected is None) == (effect.twist is None)
    if expected is None:
        return
    values = sample(effect, seed)
    for place in effect.places(N):
        law, w = TwistLaw(effect, place, values), wrench(seed)
        assert law.shape == (6, 1)
        wanted = expected(place, w, 7.0, values)
        np.testing.assert_allclose(law(w, 7.0, values), wanted, rtol=1e-9, atol=1e-18)
        assert np.abs(wanted).min() > 1e-9


@every_effect
def test_internal_springs_and_masses_are_those_of_the_oracle(effect: Effect) -> None:
    expected = oracle_of(effect)
    assert (expected.torque is None) == (effect.torque is None)
    assert (expected.mass is None) == (effect.mass is None)
    values = sample(effect, 2)
    p = {k: ca.SX(ca.DM(v)) for k, v in values.items()}
    if effect.torque and expected.torque:
        angle = np.random.default_rng(2).uniform(-2, 2, N)
        got = np.array(ca.evalf(ca.densify(effect.torque(ca.SX(ca.DM(angle)), p)))).ravel()
        np.testing.assert_allclose(got, expected.torque(angle, values), rtol=1e-9, atol=1e-9)
    if effect.mass and expected.mass:
        for got_mass, (link, kg, com) in zip(effect.mass(N, p), expected.mass(N, values), strict=True):
            assert got_mass.link == link and 0 <= link <= N
            assert float(ca.evalf(got_mass.mass)) == pytest.approx(kg)
            np.testing.assert_allclose(np.array(ca.evalf(ca.densify(got_mass.com))).ravel(), com, atol=1e-12)


@every_effect
@pytest.mark.parametrize("seed", range(4))
def test_memory_advances_as_the_oracle_says(effect: Effect, seed: int) -> None:
    step = oracle_of(effect).step
    assert (step is None) == (effect.memory is None)
    if step is None or effect.memory is None:
        return
    values, rng = sample(effect, seed), np.random.default_rng(seed)
    half = effect.memory.bounds(values)
    assert half.shape == (N,) and np.all(half >= 0) and effect.memory.gain(values).shape == (N,)
    move = rng.choice([0.0, 1e-7, 1e-5, 1e-3], (40, N)) * rng.choice([-1, 1], (40, N))
    torque = rng.choice([0.0, 1e-3, 0.1, 30.0, 3000.0], (40, N)) * rng.choice([-1, 1], (40, N))
    clamp = effect.memory.rule(move, torque, values)
    assert all(np.shape(a) == (40, N) for a in (clamp.shift, clamp.low, clamp.high))
    assert np.all(clamp.low <= clamp.high)
    assert np.all(clamp.low >= -half - 1e-18) and np.all(clamp.high <= half + 1e-18)
    state = rng.uniform(-half, half)
    for k in range(40):
        after = np.clip(state + clamp.shift[k], clamp.low[k], clamp.high[k])
        for j in range(N):
            p = {name: float(v[j]) for name, v in values.items() if len(v) == N}
            assert after[j] == pytest.approx(step(state[j], move[k, j], torque[k, j], p), abs=1e-15)
        state = after
    wide = effect.memory.rule(move[:, None], torque[:, None], values)
    assert all(np.shape(a) == (40, 1, N) for a in (wide.shift, wide.low, wide.high))


# --------------------------------------------------------------------------------------- physics


@every_effect
@pytest.mark.parametrize("seed", range(3))
def test_no_load_no_deflection(effect: Effect, seed: int) -> None:
    if oracle_of(effect).without_load:
        return
    values = sample(effect, seed)
    if effect.joint:
        unloaded = joints(effect, values, seed, torque=np.zeros(N), state=np.zeros(N), temperature=0.0)
        np.testing.assert_array_equal(JointLaw(effect, values)(unloaded, values), 0)
    for place in effect.places(N):
        np.testing.assert_array_equal(TwistLaw(effect, place, values)(np.zeros(6), 0.0, values), 0)


@every_effect
@pytest.mark.parametrize("seed", range(3))
def test_neutral_values_do_nothing(effect: Effect, seed: int) -> None:
    values = nothing(effect, seed)
    if values is None:
        assert effect.name == "joint-stiffness"  # an arm without it would be rigid, and there is no such value
        return
    assert all(np.all((p.low <= values[p.name]) & (values[p.name] <= p.high)) for p in effect.parameters)
    assert effect.check(values) == ""
    if effect.joint:
        given = joints(effect, values, seed)
        np.testing.assert_allclose(JointLaw(effect, values)(given, values), 0, atol=1e-18)
    for place in effect.places(N):
        np.testing.assert_allclose(TwistLaw(effect, place, values)(wrench(seed), 9.0, values), 0, atol=1e-18)
    p = {k: ca.SX(ca.DM(v)) for k, v in values.items()}
    if effect.torque:
        np.testing.assert_allclose(np.array(ca.evalf(effect.torque(ca.SX.ones(N), p))), 0, atol=1e-12)
    if effect.mass:
        assert all(float(ca.evalf(m.mass)) == 0 for m in effect.mass(N, p))


@every_effect
@pytest.mark.parametrize("seed", range(20))
def test_a_deflection_never_works_against_its_load(effect: Effect, seed: int) -> None:
    if oracle_of(effect).without_load:
        return
    values = sample(effect, seed)
    if effect.joint:
        given = joints(effect, values, seed)
        if effect.memory and np.any(effect.memory.gain(values)):
            # The state is itself a deflection: it lies where a torque beyond everything has put it.
            clamp = effect.memory.rule(np.zeros((1, N)), 1e10 * np.sign(given.torque)[None], values)
            given = replace(given, state=np.clip(given.state, clamp.low[0], clamp.high[0]))
        work = given.torque * JointLaw(effect, values)(given, values)
        assert np.all(work >= 0) and work.max() > 0
    for place in effect.places(N):
        assert wrench(seed) @ TwistLaw(effect, place, values)(wrench(seed), 0.0, values) >= 0


@every_effect
@pytest.mark.parametrize("seed", range(3))
def test_more_load_never_deflects_less(effect: Effect, seed: int) -> None:
    """Stable: the slope of every law along its own load is not negative."""
    if oracle_of(effect).without_load:
        return
    values = sample(effect, seed)
    if effect.joint:
        share = np.random.default_rng(seed).uniform(-1, 1, N)
        slope = JointLaw(effect, values).jacobian(joints(effect, values, seed, state=share), values)[:, :N]
        assert np.linalg.eigvalsh(slope + slope.T).min() >= -1e-18
    for place in effect.places(N):
        slope = TwistLaw(effect, place, values).jacobian(wrench(seed), 0.0, values)[:, :6]
        scaled = slope / np.outer(*2 * [np.sqrt(np.maximum(np.diag(slope), 1e-30))])
        assert np.linalg.eigvalsh(scaled + scaled.T).min() >= -1e-9


@every_effect
@pytest.mark.parametrize("seed", range(3))
def test_derivatives_are_those_of_finite_differences(effect: Effect, seed: int) -> None:
    """By the load and by every parameter, away from corners."""
    values = sample(effect, seed)
    if effect.joint:
        law = JointLaw(effect, values)
        given = joints(effect, values, seed, state=np.random.default_rng(seed).uniform(-1, 1, N))

        def joint_at(x: Floats) -> Floats:
            now = split(x[N:], values)
            half = effect.memory.bounds(now) if effect.memory else np.zeros(N)
            return law(replace(given, torque=x[:N], state=given.state * half), now)

        x = np.concatenate([given.torque, *values.values()])
        same_slope(law.jacobian(given, values), joint_at, x)
    for place in effect.places(N)[:2]:
        twist = TwistLaw(effect, place, values)

        def twist_at(x: Floats, twist: TwistLaw = twist) -> Floats:
            return twist(x[:6], 5.0, split(x[6:], values))

        x = np.concatenate([wrench(seed), *values.values()])
        same_slope(twist.jacobian(wrench(seed), 5.0, values), twist_at, x)


def split(x: Floats, values: Numbers) -> Numbers:
    ends = np.cumsum([len(v) for v in values.values()])
    return dict(zip(values, np.split(x, ends[:-1]), strict=True))


def same_slope(slope: Floats, function, x: Floats) -> None:  # type: ignore[no-untyped-def]
    assert np.abs(slope).max() > 0 and np.isfinite(slope).all()
    for i in range(len(x)):
        h = 1e-5 * abs(x[i])
        e = np.eye(len(x))[i] * h
        difference = (function(x + e) - function(x - e)) / (2 * h)
        size = np.abs(difference) + 1e-4 * np.abs(function(x)) / abs(x[i])
        np.testing.assert_array_less(np.abs(slope[:, i] - difference), 1e-6 * size + 1e-22)


# ------------------------------------------------------------------------------------- model files


def model_of(effect: Effect, values: Numbers) -> ComplianceModel:
    base = {"joint-stiffness": {"k_nm_per_rad": STIFFNESS}}
    tools = {effect.name: "spindle"} if effect.scope == "tool" else {}
    return ComplianceModel(
        "memory",
        "ur10",
        "uncompensated",
        20.0,
        None,
        None,
        {**base, effect.name: values},
        {effect.name: {k: np.abs(v) / 7 for k, v in values.items()}},
        {},
        tools,
    )


@every_effect
@pytest.mark.parametrize("seed", range(3))
def test_survives_the_model_file_unchanged(effect: Effect, seed: int, tmp_path: Path) -> None:
    values = sample(effect, seed)
    path = tmp_path / "model.toml"
    path.write_text(model_text(model_of(effect, values)), encoding="utf-8")
    back = load_model(path)
    assert effect in back.effects
    for k, v in values.items():
        assert back.values[effect.name][k].tobytes() == np.asarray(v).tobytes()
        assert back.sd[effect.name][k].tobytes() == (np.abs(v) / 7).tobytes()
    assert model_text(replace(back, source="memory")) == path.read_text(encoding="utf-8")


def refused(effect: Effect, change: dict[str, object], folder: Path) -> str:
    numbers: dict[str, object] = {k: v.tolist() for k, v in sample(effect, 0).items()}
    effects = {"joint-stiffness": {"k_nm_per_rad": STIFFNESS.tolist()}, effect.name: {**numbers, **change}}
    path = folder / "model.toml"
    path.write_text(tomli_w.dumps({"schema": "model/1", "robot": "ur10", "effects": effects}), encoding="utf-8")
    with pytest.raises(ModelError) as caught:
        load_model(path)
    return str(caught.value)


@every_effect
def test_refuses_what_it_does_not_know_and_what_is_out_of_range(effect: Effect, tmp_path: Path) -> None:
    assert f"unknown key effects.{effect.name}.stifness" in refused(effect, {"stifness": 1.0}, tmp_path)
    good = sample(effect, 0)
    for p in effect.parameters:
        for wrong in (p.low - max(abs(p.low), p.scale) * 1e-6, p.high * (1 + 1e-6) + 1e-12):
            numbers = good[p.name].tolist()
            numbers[-1] = wrong
            place = f"effects.{effect.name}.{p.name}[{len(numbers)}]"
            text = refused(effect, {p.name: numbers}, tmp_path)
            assert place in text and p.unit in text and f"{p.low:g} ... {p.high:g}" in text
        many = [*good[p.name].tolist(), p.start]
        assert f"expected {p.count(N)} number" in refused(effect, {p.name: many}, tmp_path)
        assert "must be finite" in refused(effect, {p.name: [float("nan")] * p.count(N)}, tmp_path)


@every_effect
def test_instruments_never_take_part_in_a_path(effect: Effect) -> None:
    model = model_of(effect, sample(effect, 0))
    applied, left_out = model.applied("spindle")
    assert (effect in applied) == (effect.scope != "instruments")
    assert (effect.name in left_out) == (effect.scope == "instruments")
    if effect.scope == "tool":
        assert effect not in model.applied("another tool")[0]


def test_an_effect_of_instruments_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    bias = replace(BY_NAME["tool-compliance"], name="bias", scope="instruments")
    monkeypatch.setattr(model_module, "CATALOGUE", (*CATALOGUE, bias))
    model = model_of(bias, sample(BY_NAME["tool-compliance"], 0))
    assert model.applied("spindle") == ((BY_NAME["joint-stiffness"],), ("bias",))


# -------------------------------------------------------------------------------------------- docs


def test_the_table_of_the_page_is_the_catalogue() -> None:
    printed = re.search(r"<!-- python -m stiffness.effects -->\n(.*?)<!-- end -->", PAGE.read_text("utf-8"), re.DOTALL)
    assert printed is not None and printed[1].strip() == markdown().strip()


def test_the_module_prints_the_table() -> None:
    done = subprocess.run([sys.executable, "-m", "stiffness.effects"], capture_output=True, text=True, check=True)
    assert done.stdout == markdown() and done.stderr == ""
    assert all(f"| `{e.name}` | {e.scope} | `{p.name}` |" in done.stdout for e in CATALOGUE for p in e.parameters)


@every_effect
def test_the_page_tells_of_every_effect(effect: Effect) -> None:
    sections = PAGE.read_text("utf-8").split("\n## ")
    own = [s for s in sections if s.startswith(f"`{effect.name}`")]
    assert len(own) == 1
    for word in ("**Equation**", "**Parameters**", "**Typical size**", "**How it shows**", "**Confused with**"):
        assert word in own[0], f"{effect.name}: {word}"
    assert all(f"`{p.name}`" in own[0] for p in effect.parameters)
