"""The catalogue in model files and on the pages of docs/."""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import tomli_w

from stiffness.effects import BUILT_IN, BY_NAME, CATALOGUE
from stiffness.effects.docs_table import markdown
from stiffness.effects.effect import Effect
from stiffness.errors import ModelError
from stiffness.model import model as model_module
from stiffness.model.model import ComplianceModel, load_model, model_text
from tests.contracts.effect_laws import STIFFNESS, N, Numbers, every_effect, sample

DOCS = Path(__file__).parents[2] / "docs"
PAGE = DOCS / "effects.md"
PAGES = (PAGE, *(DOCS / f"effects-{part}.md" for part in ("joints", "places", "instruments", "process")))


def model_of(effect: Effect, values: Numbers) -> ComplianceModel:
    base = {"joint-stiffness": {"k_nm_per_rad": STIFFNESS}}
    tools = {effect.name: "spindle"} if effect.scope == "tool" else {}
    return ComplianceModel(
        source="memory",
        robot="ur10",
        gravity="uncompensated",
        reference_temperature=20.0,
        base=None,
        tip=None,
        values={**base, effect.name: values},
        sd={effect.name: {k: np.abs(v) / 7 for k, v in values.items()}},
        identified={},
        tools=tools,
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


def test_refuses_values_that_are_wrong_only_together(tmp_path: Path) -> None:
    coupling = [0.0] * 15
    coupling[0], coupling[1], coupling[2] = 0.9, 0.9, -0.9
    text = refused(BY_NAME["joint-coupling"], {"coupling": coupling}, tmp_path)
    assert "effects.joint-coupling.coupling: 1 + coupling is not positive semi-definite" in text
    assert "(smallest eigenvalue -0.8)" in text
    text = refused(BY_NAME["force-sensor-bias"], {"in_tool_axes": 0.5}, tmp_path)
    assert "effects.force-sensor-bias.in_tool_axes = 0.5; expected 0 or 1" in text
    stiff = {"linear_m_per_n": [1e-8] * 3, "angular_rad_per_nm": [1e-8] * 3, "coupling": [2e-8, *[0.0] * 14]}
    text = refused(BY_NAME["base-compliance"], stiff, tmp_path)
    assert "effects.base-compliance.coupling: C is not positive semi-definite (smallest eigenvalue -1 " in text


@pytest.mark.parametrize("name", ["gravity-compensator", "payload", "tracker-drift", "force-sensor-bias"])
def test_a_single_number_is_written_without_brackets(name: str) -> None:
    effect = BY_NAME[name]
    text = model_text(model_of(effect, sample(effect, 4)))
    single = [p.name for p in effect.parameters if p.count(N) == 1]
    assert single and all(re.search(rf"^{key} = [-0-9.e+]+$", text, re.MULTILINE) for key in single)


def test_what_a_file_leaves_out_has_its_default(tmp_path: Path) -> None:
    """Keys that later versions added: an older file means what it meant."""
    hard = {"windup_rad": [1e-4] * 6, "knee_nm": [200.0] * 6}
    effects = {
        "joint-stiffness": {"k_nm_per_rad": STIFFNESS.tolist()},
        "joint-hardening": hard,
        "posture-stiffness": {"softer": [0.1] * 6, "stiffest_rad": [0.0] * 6},
    }
    path = tmp_path / "model.toml"
    path.write_text(tomli_w.dumps({"schema": "model/1", "robot": "ur10", "effects": effects}), encoding="utf-8")
    values = load_model(path).values
    np.testing.assert_array_equal(values["joint-hardening"]["further_rad"], np.zeros(6))
    for key in ("cos2", "sin2", "cos3", "sin3"):
        np.testing.assert_array_equal(values["posture-stiffness"][key], np.zeros(6))


@every_effect
def test_instruments_never_take_part_in_a_path(effect: Effect) -> None:
    model = model_of(effect, sample(effect, 0))
    applied, left_out = model.applied("spindle", ("", ""))
    on_path = effect.scope in ("robot", "tool") or effect.process_wrench is not None
    assert (effect in applied) == on_path
    assert (effect.name in left_out) != on_path
    if effect.scope == "tool":
        assert effect not in model.applied("another tool")[0]
    if effect.scope == "process":
        assert effect not in model.applied("spindle")[0]
        assert effect not in model.applied("spindle", ("steel", ""))[0]


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
    assert all(f"| `{e.name}` | {e.scope} | `{p.name}` |" in done.stdout for e in BUILT_IN for p in e.parameters)


@every_effect
def test_the_page_tells_of_every_effect(effect: Effect) -> None:
    sections = [s for page in PAGES for s in page.read_text("utf-8").split("\n## ")]
    own = [s for s in sections if s.startswith(f"`{effect.name}`")]
    assert len(own) == 1
    for word in ("**Equation**", "**Parameters**", "**Typical size**", "**How it shows**", "**Confused with**"):
        assert word in own[0], f"{effect.name}: {word}"
    assert all(f"`{p.name}`" in own[0] for p in effect.parameters)


def test_the_first_page_links_the_others() -> None:
    text = PAGE.read_text("utf-8")
    assert all(f"({page.name})" in text for page in PAGES[1:])
    assert all(f"](effects-{part}.md#{e.name})" in text for e in BUILT_IN for part in [_page_of(e)])


def _page_of(effect: Effect) -> str:
    return next(p.stem.removeprefix("effects-") for p in PAGES if f"\n## `{effect.name}`" in p.read_text("utf-8"))
