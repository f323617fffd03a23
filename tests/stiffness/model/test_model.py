"""Model files: every number comes back to the last bit, and whatever does not belong is refused by name."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w

from stiffness.effects import CATALOGUE
from stiffness.effects.effect import Effect
from stiffness.errors import ModelError, StiffnessError
from stiffness.model import model as module
from stiffness.model.model import ComplianceModel, builtin_model, load_model, model_text, save_model
from stiffness.robot.load import load_robot

K = [3.0e6, 2.7e6, 2.1e6, 4.2e5, 1.4e5, 5.6e4]
LEAST: dict[str, Any] = {
    "schema": "model/1",
    "robot": "abb-irb6600-175-255",
    "effects": {"joint-stiffness": {"k_nm_per_rad": K}},
}


def table(**changes: Any) -> dict[str, Any]:
    """The smallest model, with keys changed; None takes a key out."""
    merged = {**LEAST, **changes}
    return {k: v for k, v in merged.items() if v is not None}


def with_effect(name: str, **keys: Any) -> dict[str, Any]:
    return table(effects={**LEAST["effects"], name: {**LEAST["effects"].get(name, {}), **keys}})


def written(folder: Path, content: dict[str, Any] | str) -> Path:
    path = folder / "model.toml"
    path.write_text(content if isinstance(content, str) else tomli_w.dumps(content), encoding="utf-8")
    return path


def refused(folder: Path, content: dict[str, Any] | str) -> str:
    """The message of the refusal; it names the file first."""
    path = written(folder, content)
    with pytest.raises(ModelError) as caught:
        load_model(path)
    text = str(caught.value)
    assert text.startswith(f"{path}: ") and "\n" not in text.split(", to copy and to adapt:\n")[0]
    return text


def same(a: ComplianceModel, b: ComplianceModel) -> None:
    """Equal in everything but the name of the file; numbers to the last bit."""
    assert (a.robot, a.gravity, a.base, a.tip) == (b.robot, b.gravity, b.base, b.tip)
    assert a.reference_temperature.hex() == b.reference_temperature.hex()
    assert dict(a.tools) == dict(b.tools) and dict(a.provenance) == dict(b.provenance)
    for one, other in ((a.values, b.values), (a.sd, b.sd)):
        assert {e: sorted(p) for e, p in one.items()} == {e: sorted(p) for e, p in other.items()}
        for e, parameters in one.items():
            for p, numbers in parameters.items():
                assert [v.hex() for v in numbers.tolist()] == [v.hex() for v in other[e][p].tolist()]
    assert {e: f.tolist() for e, f in a.identified.items()} == {e: f.tolist() for e, f in b.identified.items()}


def random_model(seed: int) -> ComplianceModel:
    """Every effect of the catalogue with awkward numbers, standard deviations, flags and provenance."""
    rng = np.random.default_rng(seed)
    values, sd = {}, {}
    for e in CATALOGUE:
        values[e.name] = {
            p.name: np.clip(p.start * np.exp(rng.normal(size=p.count(6))), p.low, p.high) for p in e.parameters
        }
        sd[e.name] = {p.name: np.abs(rng.normal(size=p.count(6))) * 10.0 ** rng.integers(-12, 5) for p in e.parameters}
    return ComplianceModel(
        source="memory",
        robot='some robot "quoted".urdf',
        gravity="calibrated-out",
        reference_temperature=17.3 + rng.random(),
        base="base_link",
        tip="tööl0",
        values=values,
        sd=sd,
        identified={"joint-stiffness": np.array([True, False, True, True, False, True])},
        tools={e.name: "spindle-ü" for e in CATALOGUE if e.scope == "tool"},
        provenance={"kind": "static", "load_range": [0.0, 1e3], "note": "a\nb"},
    )


# ------------------------------------------------------------------------------------ what is read


def test_the_example_of_the_interface(tmp_path: Path) -> None:
    model = load_model(
        written(
            tmp_path,
            """
schema = "model/1"
robot = "abb-irb6600-175-255"
gravity = "uncompensated"
reference_temperature = 20.0

[effects.joint-stiffness]
k_nm_per_rad = [3.0e6, 2.7e6, 2.1e6, 4.2e5, 1.4e5, 5.6e4]
sd_nm_per_rad = [2.0e4, 2.0e4, 1.5e4, 4.0e3, 2.0e3, 1.0e3]        # optional

[effects.backlash]
gap_rad = [6.0e-5, 5.0e-5, 6.0e-5, 1.1e-4, 1.6e-4, 2.2e-4]        # total lost motion per joint
""",
        )
    )
    np.testing.assert_array_equal(model.values["joint-stiffness"]["k_nm_per_rad"], K)
    np.testing.assert_array_equal(model.sd["joint-stiffness"]["k_nm_per_rad"], [2e4, 2e4, 1.5e4, 4e3, 2e3, 1e3])
    np.testing.assert_array_equal(model.values["backlash"]["gap_rad"], [6e-5, 5e-5, 6e-5, 1.1e-4, 1.6e-4, 2.2e-4])
    np.testing.assert_array_equal(model.values["backlash"]["side"], np.ones(6))
    np.testing.assert_array_equal(model.values["backlash"]["breakaway_nm"], np.zeros(6))
    assert [e.name for e in model.effects] == ["joint-stiffness", "backlash"]
    assert (model.base, model.tip, dict(model.identified), dict(model.tools)) == (None, None, {}, {})
    assert "\n" not in repr(model) and "backlash" in repr(model)


def test_defaults(tmp_path: Path) -> None:
    model = load_model(written(tmp_path, LEAST))
    assert (model.gravity, model.reference_temperature) == ("uncompensated", 20.0)
    assert dict(model.sd) == {} and dict(model.provenance) == {}


def test_whole_numbers_are_numbers(tmp_path: Path) -> None:
    content = {**with_effect("joint-stiffness", k_nm_per_rad=[3000000] * 6), "reference_temperature": -5}
    model = load_model(written(tmp_path, content))
    assert model.values["joint-stiffness"]["k_nm_per_rad"].dtype == np.float64
    assert model.reference_temperature == -5.0


def test_effects_stand_in_the_order_of_the_catalogue(tmp_path: Path) -> None:
    effects = {"backlash": {"gap_rad": [0.0] * 6}, "preload-softening": {"ratio": [1.0] * 6}, **LEAST["effects"]}
    names = [e.name for e in load_model(written(tmp_path, table(effects=effects))).effects]
    assert names == ["joint-stiffness", "preload-softening", "backlash"]


def test_provenance_is_free_text(tmp_path: Path) -> None:
    free = {"kind": "modal", "whatever": [1, 2, {"deep": "x"}], "load_range": "to 1 kN"}
    model = load_model(written(tmp_path, table(provenance=free)))
    assert dict(model.provenance) == free
    same(load_model(written(tmp_path, model_text(model))), model)


def test_arrays_are_read_only(tmp_path: Path) -> None:
    content = with_effect("joint-stiffness", sd_nm_per_rad=[1.0] * 6, identified=[True] * 6)
    content["effects"]["backlash"] = {"gap_rad": [0.0] * 6}
    model = load_model(written(tmp_path, content))
    arrays = [
        *model.values["joint-stiffness"].values(),
        *model.values["backlash"].values(),
        *model.sd["joint-stiffness"].values(),
        *model.identified.values(),
    ]
    assert len(arrays) == 6 and not any(a.flags.writeable for a in arrays)


# ---------------------------------------------------------------------------------- round trip


@pytest.mark.parametrize("seed", range(5))
def test_a_model_comes_back_to_the_last_bit(tmp_path: Path, seed: int) -> None:
    model = random_model(seed)
    save_model(model, tmp_path / "a.toml")
    back = load_model(tmp_path / "a.toml")
    same(back, model)
    assert model_text(back) == (tmp_path / "a.toml").read_text(encoding="utf-8")
    assert b"\r" not in (tmp_path / "a.toml").read_bytes()


@pytest.mark.parametrize("number", [0.1 + 0.2, 1 / 3, 5e-324, 1.7976931348623157e308, 123456789.123456789, 1e22])
def test_awkward_numbers(tmp_path: Path, number: float) -> None:
    model = load_model(written(tmp_path, with_effect("joint-stiffness", sd_nm_per_rad=[number] * 6)))
    back = load_model(written(tmp_path, model_text(model)))
    assert {v.hex() for v in back.sd["joint-stiffness"]["k_nm_per_rad"].tolist()} == {number.hex()}


def test_the_published_sets_can_be_read_and_belong_to_their_robots() -> None:
    names = [p.stem for p in (Path(module.__file__).parent / "data").glob("*.toml")]
    assert len(names) >= 4
    for name in names:
        path = builtin_model(name)
        assert path is not None
        model, robot = load_model(path), load_robot(name)
        assert model.robot == name and (model.base, model.tip) == (robot.base, robot.tip)
        assert model.provenance["kind"] in ("static", "modal", "assumption") and model.provenance["source"]
        same(load_model(path), replace(model, source="x"))
        same(load_model(path), replace(load_model(name), source="x"))
    assert builtin_model("no-such-robot") is None
    with pytest.raises(ModelError, match=r"kuka-kr999: there is no such file, .* kuka-kr210-r2700, "):
        load_model("kuka-kr999")


# ------------------------------------------------------------------------------------ refusals


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"schema": None}, "schema = None; expected 'model/1'"),
        ({"schema": "model/2"}, "schema = 'model/2', expected 'model/1'; is it the right file?"),
        ({"schema": 1}, "schema = 1, expected 'model/1'"),
        ({"robot": None}, "robot = None; expected the name"),
        ({"robot": 6600}, "robot = 6600; expected the name"),
        ({"gravity": "compensated"}, "gravity = 'compensated'; expected one of uncompensated, calibrated-out"),
        ({"gravity": True}, "gravity = True"),
        ({"reference_temperature": "20"}, "reference_temperature = '20'; expected 1 number"),
        ({"reference_temperature": True}, "reference_temperature = True; expected 1 number"),
        ({"reference_temperature": float("nan")}, "reference_temperature = nan; every number must be finite"),
        ({"reference_temperature": [20.0, 21.0]}, "reference_temperature = [20.0, 21.0]; expected 1 number"),
        ({"base": 3}, "base = 3; expected the name of a frame"),
        ({"tip": ["tool0"]}, "tip = ['tool0']; expected the name of a frame"),
        ({"provenance": "a paper"}, "provenance = 'a paper'; expected a table"),
        ({"temperature": 20.0}, "unknown key temperature; expected some of base, correlations, effects, gravity"),
        ({"effects": None}, "no [effects.*] table"),
        ({"effects": {}}, "no [effects.*] table"),
        ({"effects": 5}, "no [effects.*] table"),
        ({"effects": {"joint-stifness": {"k_nm_per_rad": K}}}, "unknown effect joint-stifness; did you mean joint-"),
        ({"effects": {"backlash": {"gap_rad": [0.0] * 6}}}, "[effects.joint-stiffness] is missing"),
        ({"effects": {"joint-stiffness": K}}, "effects.joint-stiffness is not a table"),
    ],
)
def test_refused_at_the_top(tmp_path: Path, changes: dict[str, Any], expected: str) -> None:
    assert expected in refused(tmp_path, table(**changes))


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ({"k_nm_per_rad": K[:5]}, "k_nm_per_rad = [3000000.0, 2700000.0, 2100000.0, 420000.0, 140000.0]; expected 6 n"),
        ({"k_nm_per_rad": [*K, 1e5]}, "expected 6 numbers"),
        ({"k_nm_per_rad": 1e6}, "effects.joint-stiffness.k_nm_per_rad = 1000000.0; expected 6 numbers"),
        ({"k_nm_per_rad": []}, "expected 6 numbers"),
        ({"k_nm_per_rad": [*K[:5], "5e4"]}, "expected 6 numbers"),
        ({"k_nm_per_rad": [*K[:5], True]}, "expected 6 numbers"),
        ({"k_nm_per_rad": [*K[:5], [1.0]]}, "expected 6 numbers"),
        ({"k_nm_per_rad": [*K[:5], float("nan")]}, "every number must be finite"),
        ({"k_nm_per_rad": [float("inf"), *K[1:]]}, "every number must be finite"),
        ({"k_nm_per_rad": [10**400, *K[1:]]}, "a number is too large"),
        ({"k_nm_per_rad": [*K[:3], -1.0, *K[4:]]}, "k_nm_per_rad[4] = -1 N*m/rad is outside 100 ... 1e+12 (torsional"),
        ({"k_nm_per_rad": [0.0, *K[1:]]}, "k_nm_per_rad[1] = 0 N*m/rad is outside"),
        ({"k_nm_per_rad": [*K[:5], 2e12]}, "k_nm_per_rad[6] = 2e+12 N*m/rad is outside"),
        ({"k_nm_per_deg": K}, "unknown key effects.joint-stiffness.k_nm_per_deg; expected some of identified, k_nm_p"),
        ({"sd_k_nm_per_rad": K}, "unknown key effects.joint-stiffness.sd_k_nm_per_rad"),
        ({"tool": "spindle"}, "unknown key effects.joint-stiffness.tool"),
        ({"sd_nm_per_rad": [1.0] * 5}, "sd_nm_per_rad = [1.0, 1.0, 1.0, 1.0, 1.0]; expected 6 numbers"),
        ({"sd_nm_per_rad": [1.0] * 5 + [-1.0]}, "a standard deviation is negative"),
        ({"sd_nm_per_rad": [float("nan")] * 6}, "every number must be finite"),
        ({"identified": [True] * 5}, "identified = [True, True, True, True, True]; expected 6 booleans"),
        ({"identified": [1] * 6}, "expected 6 booleans"),
        ({"identified": True}, "expected 6 booleans"),
    ],
)
def test_refused_in_an_effect(tmp_path: Path, keys: dict[str, Any], expected: str) -> None:
    assert expected in refused(tmp_path, with_effect("joint-stiffness", **keys))


def test_a_parameter_without_default_must_be_there(tmp_path: Path) -> None:
    text = refused(tmp_path, with_effect("backlash", side=[1.0] * 6))
    assert "effects.backlash.gap_rad is missing: total lost motion per joint, rad" in text


@pytest.mark.parametrize(("value", "ok"), [(1.0, True), (0.05, True), (1.0000001, False), (0.0499999, False)])
def test_bounds_are_included(tmp_path: Path, value: float, ok: bool) -> None:
    content = with_effect("preload-softening", ratio=[1.0, 1.0, value, 1.0, 1.0, 1.0])
    if ok:
        assert load_model(written(tmp_path, content)).values["preload-softening"]["ratio"][2] == value
    else:
        assert "effects.preload-softening.ratio[3]" in refused(tmp_path, content)


@pytest.mark.parametrize("text", ["schema = ", "[effects\n", "a = 1\na = 2\n", "schema = 'model/1' junk"])
def test_broken_toml(tmp_path: Path, text: str) -> None:
    assert "is not TOML: line " in refused(tmp_path, text)


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    for path, why in ((tmp_path / "absent.toml", "there is no such file"), (tmp_path, "is a folder")):
        with pytest.raises(ModelError, match=why) as caught:
            load_model(path)
        assert str(path) in str(caught.value)
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00schema")
    with pytest.raises(ModelError, match="is UTF-16 text; save it as UTF-8"):
        load_model(tmp_path / "binary.toml")
    assert issubclass(ModelError, StiffnessError)


def test_a_count_for_another_robot(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="expected 7 numbers"):
        load_model(written(tmp_path, LEAST), 7)


# --------------------------------------------------------------------------------------- tools


SPRING = {"linear_m_per_n": [1e-7] * 3, "angular_rad_per_nm": [1e-6] * 3}


def test_tool_effects_hold_for_the_tool_they_were_measured_with(tmp_path: Path) -> None:
    for given, name in (({}, "tool"), ({"tool": "spindle-a"}, "spindle-a")):
        model = load_model(written(tmp_path, with_effect("tool-compliance", **SPRING, **given)))
        assert dict(model.tools) == {"tool-compliance": name}
        effects, left_out = model.applied(name)
        assert [e.name for e in effects] == ["joint-stiffness", "tool-compliance"] and left_out == ()
        effects, left_out = model.applied("another")
        assert [e.name for e in effects] == ["joint-stiffness"] and left_out == ("tool-compliance",)
        same(load_model(written(tmp_path, model_text(model))), model)


def test_the_name_of_a_tool_is_text(tmp_path: Path) -> None:
    text = refused(tmp_path, with_effect("tool-compliance", **SPRING, tool=3))
    assert "effects.tool-compliance.tool = 3; expected the name of the tool" in text


def test_effects_of_instruments_never_act_on_a_path(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    bias = Effect(name="bias", cause="test", scope="instruments", parameters=(), site_kind="sensor")
    monkeypatch.setattr(module, "CATALOGUE", (*CATALOGUE, bias))
    model = replace(load_model(written(tmp_path, LEAST)), tools={"bias": "tool"})
    model = replace(model, values={**model.values, "bias": {}})
    assert [e.name for e in model.effects] == ["joint-stiffness", "bias"]
    effects, left_out = model.applied("tool")
    assert [e.name for e in effects] == ["joint-stiffness"] and left_out == ("bias",)


def test_a_tool_compliance_must_not_yield_against_a_load(tmp_path: Path) -> None:
    def coupled(**entries: float) -> dict[str, Any]:
        names = [(r, c) for r in range(6) for c in range(r)]
        coupling = [0.0] * 15
        for key, value in entries.items():
            coupling[names.index((int(key[1]), int(key[2])))] = value
        return with_effect("tool-compliance", **SPRING, coupling=coupling)

    fine = load_model(written(tmp_path, coupled(c10=0.9e-7, c52=2.9e-7)))
    assert fine.values["tool-compliance"]["coupling"][0] == 0.9e-7
    load_model(written(tmp_path, coupled(c10=1e-7)))  # singular: one direction is rigid
    text = refused(tmp_path, coupled(c10=1.1e-7))
    assert "effects.tool-compliance.coupling: C is not positive semi-definite (smallest eigenvalue -0.1 " in text
    refused(tmp_path, coupled(c51=3.3e-7))
    load_model(written(tmp_path, coupled(c51=3.1e-7)))
    rigid = coupled(c51=1e-9)
    rigid["effects"]["tool-compliance"]["angular_rad_per_nm"] = [1e-6, 1e-6, 0.0]
    assert "row 6 of C has a zero on the diagonal and coupling" in refused(tmp_path, rigid)


def test_text_is_toml_that_others_read() -> None:
    content = tomllib.loads(model_text(random_model(9)))
    assert list(content) == [
        "schema",
        "robot",
        "gravity",
        "reference_temperature",
        "base",
        "tip",
        "provenance",
        "effects",
    ]
    assert content["effects"]["tool-compliance"]["tool"] == "spindle-ü"
    assert set(content["effects"]["joint-stiffness"]) == {"k_nm_per_rad", "sd_nm_per_rad", "identified"}
    assert "sd_gap_rad" in content["effects"]["backlash"]


def test_correlations_survive_and_are_checked(tmp_path: Path) -> None:
    path = tmp_path / "m.toml"
    text = (
        'schema = "model/1"\nrobot = "ur10"\n[effects.joint-stiffness]\n'
        "k_nm_per_rad = [1e5, 2e5, 3e5, 4e4, 5e4, 6e4]\n[correlations]\n"
    )
    names = 'names = ["joint-stiffness.k_nm_per_rad[1]", "joint-stiffness.k_nm_per_rad[6]"]\n'
    path.write_text(text + names + "matrix = [[1.0, -0.25], [-0.25, 1.0]]\n")
    model = load_model(path)
    assert model.correlations is not None
    assert model.correlations.matrix.tolist() == [[1.0, -0.25], [-0.25, 1.0]]
    save_model(model, tmp_path / "again.toml")
    again = load_model(tmp_path / "again.toml").correlations
    assert again is not None
    assert (again.names, again.matrix.tolist()) == (model.correlations.names, model.correlations.matrix.tolist())
    for bad, words in (
        (names + "matrix = [[1.0, 0.2], [0.3, 1.0]]", "symmetric"),
        (names + "matrix = [[1.0, 1.5], [1.5, 1.0]]", "between -1 and 1"),
        (names + "matrix = [[1.0]]", "2 x 2"),
        (names.replace("[6]", "[7]") + "matrix = [[1.0, 0.0], [0.0, 1.0]]", r"k_nm_per_rad\[7\]' is no number"),
        ("names = []", "keys names and matrix"),
    ):
        path.write_text(text + bad)
        with pytest.raises(ModelError, match=words):
            load_model(path)
