"""diagnose as a command: files in, files out, the JSON of the contract."""

from __future__ import annotations

import json
import shutil
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from compensator.cli import main
from compensator.errors import CompensatorError
from compensator.report.html.diagnosis import diagnosis_page
from compensator.report.json.diagnosis import diagnosis_report
from compensator.report.words.diagnosis import diagnosis_lines
from compensator.tasks.diagnose import diagnose_files, refined_text
from stiffness.diagnosis.attribution import ResidualSource
from stiffness.diagnosis.result import AddedEffect, MovedParameter, RemovedEffect
from stiffness.errors import StiffnessError
from stiffness.identification.evaluate import evaluate
from stiffness.model.model import load_model
from stiffness.planning.next_setups import NextSetup
from stiffness.session.session import load_session
from tests.compensator.conftest import Sick, only

CONTRACT = {
    "verdict", "added", "changed", "rms_mm", "candidates", "residual_points_at", "next_setups", "outlier_rows",
}  # fmt: skip
OUTPUTS = ("refined.toml", "out.json", "report.html")


def told(sick: Sick) -> dict[str, Any]:
    return json.loads((sick.folder / "out.json").read_text())  # type: ignore[no-any-return]


def test_json_has_the_numbers_of_the_diagnosis(loose: Sick) -> None:
    out, d = told(loose), loose.done.diagnosis
    assert set(out) >= CONTRACT
    assert out["verdict"] == d.verdict == "explained"
    assert [a["effect"] for a in out["added"]] == [a.effect for a in d.added] == ["backlash"]
    assert out["added"][0]["where"] == ["joint-1"]
    assert set(out["added"][0]["parameters"]) == set(d.added[0].parameters)
    for name, (value, sd, unit) in d.added[0].parameters.items():
        written = out["added"][0]["parameters"][name]
        assert written == {"value": value[0], "sd": sd[0], "unit": unit}  # one site: a number, not a list
    gap = out["added"][0]["parameters"]["gap_rad"]
    assert gap["unit"] == "rad" and gap["value"] > 10 * gap["sd"] > 0
    assert d.scores["path"] is out["rms_mm"]["path"] is None
    for kind in ("displacement", "absolute"):
        line = d.scores[kind]
        assert line is not None
        scores = {"before": line.before, "refitted": line.refitted, "after": line.after}
        for key, score in scores.items():
            assert out["rms_mm"][kind][key] == pytest.approx(1e3 * score.rms, rel=1e-12)
        assert out["rms_mm"][kind]["noise_floor"] == pytest.approx(1e3 * line.after.noise_floor, rel=1e-12)
        split = out["split_mm"][kind]
        assert split["noise"] == out["rms_mm"][kind]["noise_floor"]
        whole = split["noise"] ** 2 + split["structure"] ** 2
        assert whole == pytest.approx(max(split["noise"], out["rms_mm"][kind]["refitted"]) ** 2, rel=1e-9)
    assert [(c["effect"], c["heldout_rms_mm"]) for c in out["candidates"]] == [
        (c.effect, pytest.approx(1e3 * c.heldout_rms)) for c in d.candidates
    ]
    assert out["candidates"][0]["effect"] == "backlash"
    assert [c["confused_with"] for c in out["candidates"]] == [list(c.confused_with) for c in d.candidates]
    assert [(s["what"], s["share"], s["follows"]) for s in out["residual_points_at"]] == [
        (s.what, s.fraction, s.follows) for s in d.residual_sources
    ]
    shares = [s["share"] for s in out["residual_points_at"]]
    assert shares == sorted(shares, reverse=True)
    assert [(r["session"], r["row"]) for r in out["outlier_rows"]] == list(d.outliers)
    assert out["notes"] == list(d.notes)


def test_before_and_after_are_what_evaluate_says(loose: Sick, tmp_path: Path) -> None:
    """Recomputed from the files: only the set-ups that took no part, without the rows that were left out."""
    d, out = loose.done.diagnosis, told(loose)
    folder = tmp_path / "held"
    shutil.copytree(loose.session.parent, folder)
    wrong = {row for _, row in d.outliers}
    only(folder / "samples.csv", lambda setup, line: setup in d.held[0] and line not in wrong)
    held = load_session(folder / "session.toml")
    fitted = d.fit.model(held.robot_name, {})
    for key, model in (("before", loose.model), ("after", fitted)):
        found = evaluate(held, model)
        for kind, score in (("displacement", found.displacement), ("absolute", found.absolute)):
            assert score is not None
            assert out["rms_mm"][kind][key] == pytest.approx(1e3 * score.rms, rel=1e-6)
    refined = evaluate(held, load_model(loose.folder / "refined.toml")).absolute
    assert refined is not None and refined.rms < 1.2 * refined.noise_floor
    assert out["rms_mm"]["absolute"]["before"] > 2 * out["rms_mm"]["absolute"]["after"]


def test_refined_model_says_where_it_comes_from(loose: Sick) -> None:
    refined = load_model(loose.folder / "refined.toml")
    assert set(refined.values) == {"joint-stiffness", "backlash"}
    (added,) = loose.done.diagnosis.added
    gaps = refined.values["backlash"]["gap_rad"]
    assert gaps[0] == added.parameters["gap_rad"][0][0] > 0
    assert gaps[1:].tolist() == [0.0] * 5
    assert refined.provenance["kind"] == "static"  # the model's own is kept
    diagnosis = refined.provenance["diagnosis"]
    assert diagnosis["verdict"] == "explained" and diagnosis["added"] == ["backlash in joint-1"]
    assert load_session(loose.session).sha256["samples"][:16] in diagnosis["source"][0]
    assert "sha256:" in diagnosis["model"] and "toolpath-compensator" in diagnosis["software"]


def test_same_inputs_same_bytes(loose: Sick, tmp_path: Path) -> None:
    """Through the command this time; quiet, because the output is no terminal."""
    again = {name: tmp_path / name for name in OUTPUTS}
    asked = ["diagnose", str(loose.session), "--model", str(loose.folder / "model.toml")]
    asked += ["-o", str(again["refined.toml"]), "--json", str(again["out.json"]), "--report", str(again["report.html"])]
    done = CliRunner().invoke(main, asked)
    assert done.exit_code == 0 and done.output == ""
    for name in OUTPUTS:
        assert again[name].read_bytes() == (loose.folder / name).read_bytes()


def test_adequate_model_is_written_as_it_is(healthy: Sick, tmp_path: Path) -> None:
    out = told(healthy)
    assert out["verdict"] == "adequate" and out["added"] == [] and out["changed"] == []
    assert (healthy.folder / "refined.toml").read_bytes() == (healthy.folder / "model.toml").read_bytes()
    for kind in ("displacement", "absolute"):
        assert out["rms_mm"][kind]["before"] == out["rms_mm"][kind]["after"]
        assert out["rms_mm"][kind]["after"] < 1.1 * out["rms_mm"][kind]["noise_floor"]


def test_robot_of_the_refined_model_is_found_from_its_own_folder(healthy: Sick, tmp_path: Path) -> None:
    near, far = tmp_path / "a", tmp_path / "b" / "c"
    for folder in (near, far):
        folder.mkdir(parents=True)
    (tmp_path / "own.toml").write_text("")
    text = (healthy.folder / "model.toml").read_text().replace('"ur10"', '"../own.toml"')
    (near / "model.toml").write_text(text)
    model = load_model(near / "model.toml")
    found = replace(healthy.done.diagnosis, model=model)
    (far / "refined.toml").write_text(refined_text(found, model, [], far / "refined.toml"))
    refined = load_model(far / "refined.toml")
    assert refined.robot == "../../own.toml"
    for name, values in model.values.items():
        for key, value in values.items():
            assert np.array_equal(refined.values[name][key], value)
            assert np.array_equal(refined.sd[name][key], model.sd[name][key])


def test_no_such_evidence_is_null_and_several_numbers_are_a_list(healthy: Sick) -> None:
    q = np.radians([10.0, -20.0, 30.0, 40.0, -50.0, 60.0])
    posture = NextSetup(q, np.array([1.0, -2.0, 3.0, 0.0, 0.5, 0.0]), ("tcp",), "tells a from b", 1e-4)
    com = {"com_m": (np.array([0.1, -0.2, 0.3]), np.array([0.01, 0.02, 0.03]), "m")}
    d = replace(
        healthy.done.diagnosis, verdict="unexplained", scores={"displacement": None, "absolute": None},
        added=(AddedEffect("payload", ("tool",), com, 0.5, ("tool-compliance",)),),
        changed=(MovedParameter("joint-stiffness", ("joint-2",), "k_nm_per_rad", 5e4, 4e4, 300.0, "N*m/rad"),),
        residual_sources=(ResidualSource("joint-3", 0.7, "angle of joint 3"), ResidualSource("column:humidity", 0.2)),
        next_setups=(posture,),
    )  # fmt: skip
    out = diagnosis_report(d)
    assert out["rms_mm"] == out["split_mm"] == {"displacement": None, "absolute": None, "path": None}
    expected = {"value": [0.1, -0.2, 0.3], "sd": [0.01, 0.02, 0.03], "unit": "m"}
    assert out["added"][0]["parameters"] == {"com_m": expected}
    assert out["changed"] == [
        {
            "effect": "joint-stiffness", "where": ["joint-2"], "parameter": "k_nm_per_rad",
            "from": 5e4, "to": 4e4, "sd": 300.0, "unit": "N*m/rad", "confused_with": [],
        }
    ]  # fmt: skip
    assert out["next_setups"][0]["q_deg"] == pytest.approx([10.0, -20.0, 30.0, 40.0, -50.0, 60.0])
    assert out["next_setups"][0]["wrench_n_nm"] == [1.0, -2.0, 3.0, 0.0, 0.5, 0.0]
    assert out["next_setups"][0]["reflectors"] == ["tcp"]
    lines = " | ".join(diagnosis_lines(d, out))
    for words in (
        "Unexplained", "beside payload in tool", "sits at joint-3 and follows angle of joint 3", "joint-3 (70 %",
        "com 100 ± 10, -200 ± 20, 300 ± 30 mm", "payload from tool-compliance", "50,000 -> 40,000 ± 300 N·m/rad",
        "the column humidity (20 %)", "(10, -20, 30, 40, -50, 60) deg", "force (1, -2, 3) N", "tells a from b",
    ):  # fmt: skip
        assert words in lines


def test_what_is_removed_reaches_every_output(healthy: Sick, tmp_path: Path) -> None:
    """JSON, terminal, page, and the provenance of the refined model."""
    gone = RemovedEffect("backlash", ("joint-2", "joint-3"), "the readings need none")
    d = replace(healthy.done.diagnosis, verdict="explained", removed=(gone,))
    report = diagnosis_report(d)
    (said,) = report["removed"]
    assert said == {"effect": "backlash", "where": ["joint-2", "joint-3"], "why": "the readings need none"}
    lines = diagnosis_lines(d, report)
    assert lines[0].startswith("Explained: needs no backlash in joint-2 and joint-3")
    assert "removed: backlash in joint-2 and joint-3: the readings need none" in lines
    page = diagnosis_page(d, healthy.model, report)
    assert "Removed: backlash in joint-2 and joint-3: the readings need none." in page
    session = load_session(healthy.session)
    written = tomllib.loads(refined_text(d, healthy.model, [session], tmp_path / "refined.toml"))
    assert written["provenance"]["diagnosis"]["removed"] == ["backlash in joint-2, joint-3"]


def test_terminal_lines_say_it_in_words(loose: Sick, healthy: Sick) -> None:
    lines = diagnosis_lines(loose.done.diagnosis, loose.done.report)
    story = [line for line in lines if not line.startswith("  - ")]
    assert 7 <= len(story) <= 12
    assert story[0].startswith("Explained: the model lacks backlash in joint-1")
    rms = loose.done.report["rms_mm"]["absolute"]
    assert f"{rms['before']:.4g}"[:5] in " ".join(story) and f"{rms['after']:.5f}" in " ".join(story)
    first = diagnosis_lines(healthy.done.diagnosis, healthy.done.report)
    assert first[0].startswith("Adequate") and any("cannot be excluded" in line for line in first)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('robot = "ur10"', 'robot = "kuka-kr210-r2700"', "robot 'ur10' is not the robot 'kuka-kr210-r2700'"),
        ('robot = "ur10"', 'robot = "gone.toml"', "'gone.toml', which cannot be loaded"),
        ('gravity = "uncompensated"', 'gravity = "calibrated-out"', "'calibrated-out'"),
        ('schema = "model/1"', 'schema = "model/9"', "expected 'model/1'"),
    ],
)
def test_refusals_leave_everything_as_it_was(healthy: Sick, tmp_path: Path, old: str, new: str, words: str) -> None:
    text = (healthy.folder / "model.toml").read_text()
    assert old in text
    model, refined, report = tmp_path / "m.toml", tmp_path / "refined.toml", tmp_path / "out.json"
    model.write_text(text.replace(old, new))
    refined.write_text("mine")
    asked = ["diagnose", str(healthy.session), "--model", str(model), "-o", str(refined), "--json", str(report)]
    done = CliRunner().invoke(main, asked)
    assert done.exit_code == 1
    assert words in done.output and "Traceback" not in done.output
    assert refined.read_text() == "mine"
    assert {p.name for p in tmp_path.iterdir()} == {"m.toml", "refined.toml"}


def test_other_frames_are_refused(healthy: Sick, tmp_path: Path) -> None:
    """The same robot by name, but a file that puts its flange elsewhere."""
    (tmp_path / "m.toml").write_text((healthy.folder / "model.toml").read_text().replace('"ur10"', '"ur10.toml"'))
    built_in = Path(__file__).parents[3] / "stiffness" / "robot" / "data" / "ur10.toml"
    (tmp_path / "ur10.toml").write_text(built_in.read_text() + "\n[flange]\nxyz = [0.0, 0.0, 10.0]\n")
    with pytest.raises(StiffnessError, match="not the frames of the model"):
        diagnose_files([healthy.session], tmp_path / "m.toml")


def test_outputs_appear_together_or_not_at_all(healthy: Sick, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("compensator.tasks.diagnose.diagnose", lambda *given: healthy.done.diagnosis)
    model = healthy.folder / "model.toml"
    with pytest.raises(CompensatorError, match="cannot write"):
        diagnose_files([healthy.session], model, tmp_path / "r.toml", json=tmp_path / "no" / "out.json")
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(CompensatorError, match="input of this run"):
        diagnose_files([healthy.session], model, model, json=tmp_path / "out.json")
    with pytest.raises(CompensatorError, match="asked for twice"):
        diagnose_files([healthy.session], model, tmp_path / "r.toml", json=tmp_path / "r.toml")
    assert list(tmp_path.iterdir()) == []
    done = diagnose_files([healthy.session], model, json=tmp_path / "out.json")
    assert [p.name for p in done.files] == ["out.json"]
    assert json.loads((tmp_path / "out.json").read_text()) == told(healthy)
