"""Wrong rows beside structure, beside reflectors on the base, and gross ones: which are left out, and which stay."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from stiffness.diagnosis.doubts import session_doubts
from stiffness.identification.outliers import contradicting
from stiffness.identify import identify
from stiffness.session.far_readings import far_rows
from stiffness.session.session import Session, load_session
from tests.plant import lab
from tests.plant.lab_design import random_setups
from tests.stiffness import session_desk
from tests.stiffness.bench_lab import FORCE, Lab

ON_ARM = (("tcp", 6, (0.02, -0.01, 0.25)), ("side", 6, (0.15, 0.0, 0.2)), ("elbow", 3, (0.1, 0.1, 0.1)))
ON_BASE = ((0.5, 0.2, 0.1), (-0.4, 0.5, 0.1), (-0.3, -0.5, 0.3), (0.4, -0.3, 0.6))


def session(
    folder: Path, gap: tuple[float, ...] | None = None, setups: int = 14, group: str | None = None
) -> Session:
    """Reflectors on arm and base, none exactly known, the tracker not registered; a gap is what no spring explains.
    ``group``: those at the tool are one probe."""
    plant = Lab("ur10", gap=gap).plant()
    targets = [lab.Target(*t, exact=False, group=group if t[1] == 6 else None) for t in ON_ARM]
    targets += [lab.Target(f"base {k}", 0, at, exact=False) for k, at in enumerate(ON_BASE)]
    plan = random_setups(plant.arm, setups, 3, force=FORCE["ur10"], levels=(0.4, 1.0))
    notes = lab.measure(plant, plan, targets, form=lab.Form(registered=False, rough=0.003), seed=1003)
    return load_session(notes.write(folder, "ur10"))


def spoiled(given: Session, rows: npt.NDArray[np.intp], size: float) -> Session:
    """Rows moved by ``size``, m, in random directions."""
    away = np.random.default_rng(1).normal(size=(len(rows), 3))
    position = given.samples.position.copy()
    position[rows] += size * away / np.linalg.norm(away, axis=1, keepdims=True)
    return replace(given, samples=replace(given.samples, position=position))


@pytest.fixture(scope="module")
def clean(tmp_path_factory: pytest.TempPathFactory) -> Session:
    return session(tmp_path_factory.mktemp("clean"))


@pytest.fixture(scope="module")
def loose(tmp_path_factory: pytest.TempPathFactory) -> Session:
    return session(tmp_path_factory.mktemp("loose"), gap=(2e-3,) * 6)


@pytest.mark.parametrize("size", [0.4, 0.003])
def test_wrong_rows_of_a_base_reflector_cost_no_others(clean: Session, size: float) -> None:
    rows = np.flatnonzero(clean.samples.reflector == 3)[[5, 20, 40, 60]]
    fit = identify([spoiled(clean, rows, size)], ["joint-stiffness", "kinematic-offset"])
    assert [line for _, line in fit.outlier_rows()] == clean.samples.line[rows].tolist()
    assert fit.solution.misfit == 1.0


def test_base_reflectors_at_the_noise_make_no_arm_reading_wrong(loose: Session) -> None:
    """Springs alone on an arm with a gap: the arm's readings miss by many times the noise, the base's do not."""
    fit = identify([loose], ["joint-stiffness", "kinematic-offset"])
    assert fit.solution.misfit > 5
    assert len(fit.outlier_rows()) <= 0.005 * len(loose)


def test_a_gross_row_is_found_beside_structure(loose: Session) -> None:
    rows = np.flatnonzero(loose.samples.reflector == 0)[[10, 40]]
    fit = identify([spoiled(loose, rows, 0.4)], ["joint-stiffness", "kinematic-offset"])
    out = [line for _, line in fit.outlier_rows()]
    assert set(clean_lines := loose.samples.line[rows].tolist()) <= set(out)
    assert len(out) - len(clean_lines) <= 0.005 * len(loose)


def test_a_wrong_reading_of_a_probe_is_found_beside_structure(tmp_path: Path) -> None:
    """All its points are off alike, as they are where the model lacks something: but they are one reading."""
    loose = session(tmp_path, gap=(5e-4,) * 6, group="probe")
    s = loose.samples
    probe = np.flatnonzero((loose.group[s.reflector] >= 0) & (s.setup == s.setup[60]) & (s.state == s.state[60]))
    position = s.position.copy()
    position[probe] += [0.015, -0.01, 0.012]
    fit = identify([replace(loose, samples=replace(s, position=position))], ["joint-stiffness", "kinematic-offset"])
    assert fit.solution.misfit > 2
    out = {line for _, line in fit.outlier_rows()}
    assert set(s.line[probe].tolist()) <= out
    assert len(out) <= len(probe) + 4


def test_a_reflector_of_which_a_quarter_is_moved_loses_no_rows(clean: Session) -> None:
    """Too many to be wrong: they stay, and it is said what happened to them."""
    rows = np.flatnonzero(clean.samples.reflector == 0)[-18:]
    position = clean.samples.position.copy()
    position[rows] += [0.004, 0.0, 0.003]
    moved = replace(clean, samples=replace(clean.samples, position=position))
    fit = identify([moved], ["joint-stiffness", "kinematic-offset"])
    assert len(fit.outlier_rows()) <= 6
    assert contradicting(fit.sessions[0])[rows].sum() > 3
    (said,) = session_doubts(fit.sessions)
    assert "jumped" in said.what and clean.reflectors[0].name in said.what
    assert said.first in clean.samples.line[rows]  # near the first of them
    assert not contradicting(identify([clean], ["joint-stiffness"]).sessions[0]).any()


def test_far_rows_are_those_that_no_arm_explains(clean: Session, loose: Session) -> None:
    assert not far_rows(clean).any() and not far_rows(loose).any()
    rows = np.flatnonzero(clean.samples.reflector == 5)[::9]  # one in nine, all of one reflector
    assert np.array_equal(np.flatnonzero(far_rows(spoiled(clean, rows, 0.4))), rows)
    assert np.array_equal(np.flatnonzero(far_rows(spoiled(clean, rows, 0.09))), rows)
    assert not far_rows(spoiled(clean, rows, 0.03)).any()


@pytest.mark.parametrize("registered", [True, False])
def test_a_probe_of_two_reflectors_is_read_as_five_numbers(
    registered: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The rotation about the line through them moves none: it was a matrix without an inverse."""
    targets = [lab.Target(name, 6, at, exact=False, group="probe") for name, _, at in ON_ARM[:2]]
    monkeypatch.setattr(session_desk, "TARGETS", targets)
    form = lab.Form(rough=0.004, registered=registered)
    noise = lab.Noise(tracker=1e-5, tracker_angle=1e-4)
    given, _ = session_desk.write(tmp_path, noise=noise, form=form, design={"count": 14})
    fit = identify([given], ["backlash"])
    assert fit.solution.count == 5 * len(given.states)
    assert fit.solution.misfit == 1.0
    stiffness = fit.values()["joint-stiffness"]["k_nm_per_rad"]
    truth = np.array([5e4, 5e4, 3e4, 1e4, 1e4, 8e3])
    assert np.abs((1 / stiffness - 1 / truth) / fit.sd[:6]).max() < 3.5
    assert np.abs(stiffness / truth - 1)[:5].max() < 0.1
