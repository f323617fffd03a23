"""Diagnosis of a plant that is ill in a known way: what is named, what is left, and what is not invented.

DIAGNOSE_CLEAN=50 diagnoses that many clean sessions over three arms; docs/effects-report.md has every effect.
"""

from __future__ import annotations

import os
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stiffness.diagnosis.diagnose import diagnose
from stiffness.diagnosis.result import Diagnosis
from stiffness.identify import identify
from stiffness.model.model import ComplianceModel
from stiffness.session.session import load_session
from tests.effects_report.case import Row, Task, run
from tests.effects_report.judge import SURE, misses, within
from tests.plant.cell_design import CELLS
from tests.plant.cells import SCENARIOS, write
from tests.stiffness.session_desk import Rows

ABB, UR, KUKA = CELLS
CLEAN = int(os.environ.get("DIAGNOSE_CLEAN", "3"))
KNOWN = (
    (UR, "backlash joint-1"),
    (ABB, "joint-hardening joint-2"),
    (UR, "joint-friction joint-2"),
    (KUKA, "joint-coupling joint-2 joint-3"),
    (KUKA, "thermal-drift link-2"),
    (UR, "preload-softening joint-3 + payload"),
    (ABB, "joint-coupling joint-2 joint-3 + tracker-drift"),
)
UNKNOWN = ((UR, "unknown brake", "column:brake", "brake"), (ABB, "unknown ripple", "joint-3", "angle of joint 3"))


@pytest.fixture(scope="module")
def healthy(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Sessions of a cell with nothing wrong, and one with joint 3 a fifth softer (C)."""
    return write(SCENARIOS["clean"], tmp_path_factory.mktemp("clean"), 4, UR).paths


@pytest.fixture(scope="module")
def model(healthy: dict[str, Path]) -> ComplianceModel:
    return at_hand(healthy["A_healthy"])


def at_hand(path: Path) -> ComplianceModel:
    session = load_session(path)
    return identify([session], ["joint-stiffness"]).model(session.robot_name, {})


def copied(path: Path, folder: Path) -> Rows:
    """A copy of a session whose rows a test may spoil."""
    shutil.copytree(path.parent, folder)
    return Rows(folder)


def case(arm: str, scenario: str, folder: Path) -> Row:
    return run(Task(arm=arm, scenario=scenario, seed=1, size=3.0, keep=folder))


@pytest.mark.parametrize(("arm", "scenario"), KNOWN)
def test_an_effect_is_named_and_gone(arm: str, scenario: str, tmp_path: Path) -> None:
    """Three times the noise floor beyond joint stiffness; unseen readings come out as if the truth had been told."""
    row = case(arm, scenario, tmp_path)
    assert misses(row) == []
    assert row.told is not None
    for kind, floor in row.floor.items():
        assert 0.9 * floor < row.after[kind] < 1.05 * row.told[kind]
    assert row.before["absolute"] > 2 * row.after["absolute"]
    near, every = within([row], SURE)
    assert near == every, row.distances


@pytest.mark.parametrize(("arm", "scenario", "place", "regressor"), UNKNOWN)
def test_an_effect_of_no_catalogue_is_unexplained_and_located(
    arm: str, scenario: str, place: str, regressor: str, tmp_path: Path
) -> None:
    row = case(arm, scenario, tmp_path)
    assert misses(row) == []
    assert row.named == ()
    assert regressor in row.points_at[0][2]
    shares = {what: share for what, share, _ in row.points_at}
    assert shares[place] > 0.3
    columns = [what for what in shares if what.startswith("column:")]
    if place.startswith("column:"):
        assert columns[0] == place
    assert all(shares[c] < shares[place] / 3 for c in columns if c != place)
    assert not {"column:humidity", "column:spindle"} & set(columns)  # noise to both
    assert row.after == row.before


@pytest.mark.parametrize("seed", range(CLEAN))
def test_nothing_is_invented_on_clean_data(seed: int, tmp_path: Path) -> None:
    """Sessions differ in postures, loads and noise; one false alarm in twenty-five is what the target allows."""
    arm = (ABB, UR, KUKA)[seed % 3]
    paths = write(SCENARIOS["clean"], tmp_path, 100 + seed, arm, sessions=("A_healthy", "D")).paths
    said = diagnose([load_session(paths["D"])], at_hand(paths["A_healthy"]))
    assert (said.verdict, said.added, said.changed) == ("adequate", (), ())
    line = said.scores["absolute"]
    assert line is not None
    assert line.after.rms == line.before.rms == pytest.approx(line.before.noise_floor, rel=0.15)


def test_a_joint_that_softened_is_a_change_and_no_effect(healthy: dict[str, Path], model: ComplianceModel) -> None:
    said = diagnose([load_session(healthy["C"])], model)
    assert said.verdict == "parameters-changed"
    assert said.added == ()
    assert [(c.effect, c.where) for c in said.changed] == [("joint-stiffness", ("joint-3",))]
    (moved,) = said.changed
    assert moved.after / moved.before == pytest.approx(0.8, abs=0.02)
    assert abs(moved.after - 0.8 * CELLS[UR].stiffness[2]) < 4 * moved.sd
    line = said.scores["absolute"]
    assert line is not None and line.after.rms < 0.5 * line.before.rms


@pytest.mark.parametrize(("share", "verdict"), [(0.6, "adequate"), (0.2, "parameters-changed")])
def test_a_data_sheet_is_as_likely_too_stiff_as_too_soft(
    share: float, verdict: str, healthy: dict[str, Path], model: ComplianceModel
) -> None:
    """Two joints three times too stiff and too soft: two standard deviations of 60 %, told as such on both sides."""
    k = model.values["joint-stiffness"]["k_nm_per_rad"] * [1.0, 3.3, 1.0, 0.3, 1.0, 1.0]
    sheet = replace(
        model,
        values={"joint-stiffness": {"k_nm_per_rad": k}},
        sd={"joint-stiffness": {"k_nm_per_rad": share * k}},
        correlations=None,
    )
    said = diagnose([load_session(healthy["D"])], sheet)
    assert said.verdict == verdict
    assert {c.where for c in said.changed} == (set() if verdict == "adequate" else {("joint-2",), ("joint-4",)})


def test_four_setups_cannot_tell(healthy: dict[str, Path], model: ComplianceModel, tmp_path: Path) -> None:
    said = diagnose([load_session(first_setups(healthy["C"], tmp_path / "few", 4))], model)
    assert said.verdict == "insufficient-data"
    assert (said.added, said.changed) == ((), ())
    robot = load_session(healthy["C"]).robot
    assert said.next_setups
    assert all(np.all((robot.lower <= s.q) & (s.q <= robot.upper)) for s in said.next_setups)


def test_wrong_rows_are_listed_and_no_effect(healthy: dict[str, Path], model: ComplianceModel, tmp_path: Path) -> None:
    rows = copied(healthy["D"], tmp_path / "wrong")
    lines = [12, 57, 133, 260, 401, 555]
    for k, line in enumerate(lines):
        axis = "xyz"[k % 3]
        rows.order[line - 2][axis] = str(float(rows.order[line - 2][axis]) + 1.5 * (-1) ** k)
    said = diagnose([load_session(rows.write())], model)
    assert (said.verdict, said.added, said.changed) == ("adequate", (), ())
    assert sorted(line for _, line in said.outliers) == lines


def test_repeats_are_believed_where_the_data_sheet_is_wrong(
    healthy: dict[str, Path], model: ComplianceModel, tmp_path: Path
) -> None:
    """The tracker scatters 20 um; its sheet says 10: taken at its word, noise would be structure."""
    folder = copied(healthy["D"], tmp_path / "sheet").folder
    text = (folder / "session.toml").read_text(encoding="utf-8")
    assert "tracker = 0.02" in text
    (folder / "session.toml").write_text(text.replace("tracker = 0.02", "tracker = 0.01"), encoding="utf-8")
    said = diagnose([load_session(folder / "session.toml")], model)
    assert (said.verdict, said.added, said.changed) == ("adequate", (), ())
    (note,) = [n for n in said.notes if "repeat" in n]
    assert "the repeats are believed" in note
    (times,) = [float(word) for word in note.split() if word.replace(".", "").isdigit() and "." in word]
    assert times == pytest.approx(2.0, abs=0.3)


def test_columns_of_noise_fool_nobody(tmp_path: Path) -> None:
    """A joint follows its angle; columns that follow nothing are offered, new in every reading or in every set-up."""
    paths = write(SCENARIOS["unknown ripple"], tmp_path / "ill", 6, UR, of="left", sessions=("A_healthy", "D")).paths
    rows, rng = copied(paths["D"], tmp_path / "noisy"), np.random.default_rng(3)
    constant = rng.normal(size=(100, 3))
    for row in rows.order:
        row |= {f"noise{k}": f"{v:.4f}" for k, v in enumerate((*rng.normal(size=3), *constant[int(row["setup"])]))}
    said = diagnose([load_session(rows.write())], at_hand(paths["A_healthy"]))
    assert said.verdict == "unexplained"
    assert said.residual_sources[0].what == "joint-3"
    shares = {p.what: p.fraction for p in said.residual_sources}
    nothing = ("column:noise", "column:humidity", "column:spindle", "column:brake")
    assert [what for what in shares if what.startswith(nothing)] == []
    assert all(share < 0.2 for what, share in shares.items() if what.startswith("column:"))


def test_the_same_session_gives_the_same_diagnosis(tmp_path: Path) -> None:
    paths = write(SCENARIOS["backlash joint-3"], tmp_path, 5, UR, of="left", sessions=("A_healthy", "D")).paths
    model = at_hand(paths["A_healthy"])
    session = first_setups(paths["D"], tmp_path / "short", 15)
    first, second = (diagnose([load_session(session)], model) for _ in range(2))
    assert shown(first) == shown(second)
    assert [a.effect for a in first.added] == ["backlash"]


def first_setups(path: Path, folder: Path, count: int) -> Path:
    rows = copied(path, folder)
    rows.order = [r for r in rows.order if int(r["setup"]) <= count]
    return rows.write()


def shown(said: Diagnosis) -> tuple[object, ...]:
    """Everything that a diagnosis says, to the last bit."""
    parameters = [
        (a.effect, a.where, a.confused_with, a.explains, name, values.tobytes(), sd.tobytes())
        for a in said.added
        for name, (values, sd, _) in a.parameters.items()
    ]
    values = [(e, n, v.tobytes()) for e, numbers in said.model.values.items() for n, v in numbers.items()]
    return (
        said.verdict, parameters, said.changed, said.scores, said.candidates, said.residual_sources, said.outliers,
        said.notes, values, [(s.q.tobytes(), s.wrench.tobytes(), s.why) for s in said.next_setups],
    )  # fmt: skip


def test_every_fifth_setup_takes_part_in_nothing(
    healthy: dict[str, Path], model: ComplianceModel, tmp_path: Path
) -> None:
    said = diagnose([load_session(first_setups(healthy["D"], tmp_path / "short", 15))], model)
    assert said.held == ((3, 8, 13),)
    (fitted,) = said.fit.sessions
    assert set(fitted.samples.setup[fitted.used].tolist()) == set(range(1, 16)) - {3, 8, 13}
