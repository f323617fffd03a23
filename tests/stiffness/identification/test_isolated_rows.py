"""evaluate leaves out single wrong rows and gross ones, and nothing that a poor model misses."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from stiffness.identification.evaluate import evaluate
from stiffness.identify import identify
from stiffness.model.model import ComplianceModel
from stiffness.session.session import Session
from tests.plant.lab import Form
from tests.stiffness.bench_lab import Lab

Index = npt.NDArray[np.intp]


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Session:
    return Lab("ur10").session(tmp_path_factory.mktemp("s"), 5, setups=20, form=Form(registered=False))[0]


@pytest.fixture(scope="module")
def model(session: Session) -> ComplianceModel:
    return identify([session], ["joint-stiffness"]).model("ur10", {})


def spoiled(session: Session, rows: Index, size: float) -> Session:
    position = session.samples.position.copy()
    position[rows] += size * np.array([0.6, 0.0, 0.8])
    return replace(session, samples=replace(session.samples, position=position))


def test_a_clean_session_keeps_every_row(session: Session, model: ComplianceModel) -> None:
    found = evaluate(session, model)
    assert not found.wrong.any()
    assert found.with_wrong == {"displacement": found.displacement, "absolute": found.absolute, "path": None}


@pytest.mark.parametrize("size", [0.403, 0.02, 5e-4])
def test_single_wrong_rows_are_left_out_and_both_numbers_given(
    session: Session, model: ComplianceModel, size: float
) -> None:
    clean = evaluate(session, model).absolute
    rows = np.array([31, 100, 199])
    found = evaluate(spoiled(session, rows, size), model)
    assert np.flatnonzero(found.wrong).tolist() == rows.tolist()
    every, right = found.with_wrong["absolute"], found.absolute
    assert every is not None and right is not None and clean is not None
    assert right.rms == pytest.approx(clean.rms, rel=0.05)
    scored = every.count - right.count  # of the three, those that did not place the tracker
    squares = every.rms**2 * 3 * every.count - right.rms**2 * 3 * right.count
    assert 0 < scored <= 3
    assert squares == pytest.approx(scored * size**2, rel=0.4)


def test_what_a_poor_model_misses_is_not_called_wrong(session: Session, model: ComplianceModel) -> None:
    stiff = model.values["joint-stiffness"]["k_nm_per_rad"] * np.array([1e3, 1.0, 1e3, 1.0, 1.0, 1.0])
    poor = replace(model, values={"joint-stiffness": {"k_nm_per_rad": stiff}})
    found = evaluate(session, poor)
    assert found.absolute is not None and found.absolute.rms > 5 * found.absolute.noise_floor
    assert not found.wrong.any()


def test_one_set_up_under_a_load_that_the_model_gets_wrong_is_not_wrong(
    session: Session, model: ComplianceModel, tmp_path: Path
) -> None:
    """All reflectors of one state are missed by twenty times the noise, alike: the arm did that, not a reading."""
    s = session.samples
    rows = np.flatnonzero((s.setup == 4) & (s.state == 2))
    assert not evaluate(spoiled(session, rows, 2e-4), model).wrong.any()
