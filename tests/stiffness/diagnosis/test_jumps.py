"""Jumps, drifts and trends that were put into the readings of an independent plant: named with their row and size."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from stiffness.diagnosis.change_test import line_test, step_test
from stiffness.diagnosis.doubts import session_doubts
from stiffness.diagnosis.jumps import CHANCE, MeasurementChange, measurement_changes
from stiffness.identify import identify
from stiffness.session.session import Session, load_session
from tests.plant import lab
from tests.plant.lab_design import random_setups
from tests.stiffness.bench_lab import FORCE, Lab

Floats = npt.NDArray[np.float64]
WAY = np.array([0.6, 0.0, 0.8])
TARGETS = (
    lab.Target("tcp", 6, (0.02, -0.01, 0.25), exact=False),
    lab.Target("side", 6, (0.15, 0.0, 0.2), exact=False),
    lab.Target("elbow", 3, (0.1, 0.1, 0.1), exact=False),
    lab.Target("ground", 0, (0.5, 0.2, 0.1), exact=False),
    lab.Target("wall", 0, (-0.4, 0.5, 0.3), exact=False),
)


def measured(folder: Path, moved: Callable[[int], Floats], gap: tuple[float, ...] | None = None) -> Session:
    """A session in which the lab finds the reflector ``side`` displaced in its link, m, set-up by set-up."""
    plant = Lab("ur10", gap=gap).plant()
    plan = random_setups(plant.arm, 24, 3, force=FORCE["ur10"], levels=(1.0,))
    form = lab.Form(registered=False, rough=0.003, extra={"humidity": [float((7 * k) % 24) for k in range(24)]})
    every: list[list[dict[str, object]]] = []
    for shift in {tuple(moved(k)) for k in range(len(plan))}:
        targets = [replace(t, at=np.asarray(t.at) + shift) if t.name == "side" else t for t in TARGETS]
        notes = lab.measure(plant, plan, targets, form=form, seed=11)
        every.append([r for r in notes.rows if tuple(moved(int(str(r["setup"])) - 1)) == shift])
        if not any(shift):
            whole = notes
    rows = sorted((r for part in every for r in part), key=lambda r: int(str(r["setup"])))
    return load_session(replace(whole, rows=rows).write(folder, "ur10"))


def still(_: int) -> Floats:
    return np.zeros(3)


def changes(session: Session) -> tuple[MeasurementChange, ...]:
    fit = identify([session], ["joint-stiffness", "kinematic-offset"])
    return measurement_changes(fit.sessions[0])


@pytest.fixture(scope="module")
def clean(tmp_path_factory: pytest.TempPathFactory) -> Session:
    return measured(tmp_path_factory.mktemp("clean"), still)


def shifted(session: Session, by: Floats) -> Session:
    """Readings moved by (N, 3) m in the axes of the tracker."""
    return replace(session, samples=replace(session.samples, position=session.samples.position + by))


def test_nothing_changed_in_a_clean_session_nor_in_one_of_a_model_that_lacks_something(
    clean: Session, tmp_path: Path
) -> None:
    assert changes(clean) == ()
    loose = measured(tmp_path, still, gap=(2e-3,) * 6)
    assert changes(loose) == ()


@pytest.mark.parametrize("size", [5.8e-3, 3e-4])
def test_a_reflector_that_was_knocked_on_its_link(tmp_path: Path, size: float) -> None:
    session = measured(tmp_path, lambda k: size * WAY if k >= 9 else np.zeros(3))
    s = session.samples
    mine = np.flatnonzero(s.reflector == 1)
    last, first = int(s.line[mine[s.setup[mine] == 9][-1]]), int(s.line[mine[s.setup[mine] == 10][0]])
    (found,) = changes(session)
    assert (found.what, found.who, found.before, found.after) == ("jump", "side", last, first)
    assert np.array(found.shift) == pytest.approx(size * WAY, abs=4e-5)
    assert found.sentence.startswith(f"something jumped between rows {found.before} and {first}: reflector side, ")
    assert f"{size * 1e3:.2g} mm" in found.sentence or size < 1e-3


def test_a_reflector_on_the_base_at_the_very_row(clean: Session) -> None:
    s, at = clean.samples, 88
    by = np.where(((s.reflector == 3) & (np.arange(len(s)) > at))[:, None], 1e-3 * WAY, 0.0)
    (found,) = changes(shifted(clean, by))
    mine = s.line[s.reflector == 3]
    assert (found.what, found.who) == ("jump", "ground")
    assert found.before == mine[mine <= s.line[at]][-1] and found.after == mine[mine > s.line[at]][0]
    assert found.size == pytest.approx(1e-3, abs=3e-5)


@pytest.mark.parametrize("size", [4e-3, 1.2e-4])
def test_a_tracker_that_was_bumped(clean: Session, size: float) -> None:
    s, at = clean.samples, 150
    (found,) = changes(shifted(clean, np.where((np.arange(len(s)) >= at)[:, None], size * WAY, 0.0)))
    assert (found.what, found.who) == ("jump", "tracker")
    assert (found.before, found.after) == (s.line[at - 1], s.line[at])
    assert np.array(found.shift) == pytest.approx(size * WAY, abs=4e-5)
    assert "all reflectors at once" in found.sentence


def test_a_drift_is_no_jump(clean: Session) -> None:
    (found,) = changes(shifted(clean, 4e-4 * np.linspace(0, 1, len(clean))[:, None] * WAY))
    assert (found.what, found.who, found.column) == ("drift", "tracker", "")
    assert (found.before, found.after) == (2, int(clean.samples.line[-1]))
    assert np.array(found.shift) == pytest.approx(4e-4 * WAY, abs=6e-5)


def test_a_trend_with_a_column_is_neither(clean: Session) -> None:
    humidity = clean.samples.extra["humidity"]
    by = 4e-4 * ((humidity - humidity.mean()) / np.ptp(humidity))[:, None] * WAY
    (found,) = changes(shifted(clean, by))
    assert (found.what, found.who, found.column) == ("trend", "tracker", "humidity")
    assert "follows column humidity" in found.sentence
    assert np.array(found.shift) == pytest.approx(4e-4 * WAY, abs=6e-5)


def test_rows_that_a_short_jump_made_wrong_are_still_looked_at(clean: Session) -> None:
    """The last readings of one reflector: few enough to be left out as wrong rows, and yet a jump."""
    s = clean.samples
    last = np.flatnonzero(s.reflector == 4)[-8:]
    by = np.zeros((len(s), 3))
    by[last] = 2e-3 * WAY
    session = shifted(clean, by)
    fit = identify([session], ["joint-stiffness", "kinematic-offset"])
    jumps = [c for c in measurement_changes(fit.sessions[0]) if c.what == "jump"]
    assert [c.who for c in jumps] == ["wall"] and jumps[0].after == s.line[last[0]]
    said = [str(d) for d in session_doubts(fit.sessions)]
    assert any("something jumped between rows" in text for text in said)


@pytest.mark.parametrize("alike", [0.0, 0.7])
def test_chance_findings_are_as_rare_as_they_say(alike: float) -> None:
    """Series without any change, neighbours alike or not: 600 of each, tested at 1 % over all positions."""
    rng = np.random.default_rng(5)
    found = lines = 0
    for _ in range(600):
        noise = rng.normal(size=(60, 3))
        y = noise.copy()
        for k in range(1, 60):
            y[k] = alike * y[k - 1] + np.sqrt(1 - alike**2) * noise[k]
        found += step_test(y).p * len(y) < 0.01
        lines += line_test(y, np.arange(60.0)).p < 0.01
    assert found <= 14 and lines <= (16 if alike == 0 else 36)
    assert CHANCE <= 1e-3
