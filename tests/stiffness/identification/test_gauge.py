"""What the data do not determine: the solution nearest to the drawing, its words, and what is determined beside."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from scipy import linalg
from scipy.spatial.transform import Rotation

from stiffness.effects import BASE
from stiffness.identification.drawing_scale import with_drawing_scale
from stiffness.identification.evaluate import predicted_by, predicted_rigid
from stiffness.identification.fit import Fit
from stiffness.identification.gauge import TOLD
from stiffness.identification.nearest import nearest_to_drawing
from stiffness.identification.placed_station import placed_reflectors, placed_trackers
from stiffness.identify import identify
from stiffness.session.session import Session, load_session
from tests.plant.lab import Form, Noise, Notes, Target, measure
from tests.plant.lab_design import random_setups
from tests.stiffness.bench_lab import FORCE, Lab

Floats = npt.NDArray[np.float64]
ROUGH = (
    Target("tcp", 6, (0.02, -0.01, 0.25), exact=False),
    Target("side", 6, (0.15, 0.0, 0.2), exact=False),
    Target("elbow", 3, (0.1, 0.1, 0.1), exact=False),
)
OFFSETS, K = "kinematic-offset", "k_nm_per_rad"


def notes_of(robot: str, seed: int, *, setups: int = 25, force: float | None = None, form: Form) -> Notes:
    plant = Lab(robot).plant()
    plan = random_setups(plant.arm, setups, seed, force=FORCE[robot] if force is None else force)
    return measure(plant, plan, ROUGH, noise=Noise(), form=form, seed=seed + 1000)


def crooked(session: Session, size: float) -> Session:
    """Every set-up read elsewhere by ``size`` m, one sigma per axis: what a model of the arm does not hold."""
    rng = np.random.default_rng(5)
    _, of = np.unique(session.samples.setup, return_inverse=True)
    off = size * rng.normal(size=(of.max() + 1, 3))[of]
    return replace(session, samples=replace(session.samples, position=session.samples.position + off))


def unloaded_path(fit: Fit, robot: str, folder: Path) -> tuple[Floats, Floats]:
    """(N,) m that a model moves the TCP by at postures that no reading had, and what the plant's springs do."""
    notes = notes_of(robot, 99, setups=40, force=0.0, form=Form())
    session = load_session(notes.write(folder / "path", robot))
    tcp = session.samples.reflector == next(k for k, r in enumerate(session.reflectors) if r.name == "tcp")
    none = np.zeros(len(session), dtype=bool)
    rigid = predicted_rigid(session, none).predicted.position
    bent = predicted_by(fit.model(robot, {}), session, none).predicted.position
    truth = session.samples.position - rigid
    return (np.linalg.norm((v)[tcp], axis=1) for v in (bent - rigid, truth))  # type: ignore[return-value]


@pytest.mark.parametrize("size", [0.0, 3e-4])
@pytest.mark.parametrize("robot", ["ur10", "abb-irb6600-175-255"])
def test_an_unloaded_path_sags_and_does_nothing_else(robot: str, size: float, tmp_path: Path) -> None:
    """Reflectors 30 mm off, tracker anywhere, twelve times the noise unexplained: the arm is nominal, and stays so.

    What is left free ran into the robot by 17 mm here."""
    session = load_session(notes_of(robot, 5, form=Form(registered=False, rough=0.03)).write(tmp_path, robot))
    fit = identify([crooked(session, size)], [OFFSETS])
    assert (fit.solution.misfit > 8) == (size > 0)
    found, truth = unloaded_path(fit, robot, tmp_path)
    assert truth.max() > 5e-3
    # a systematic error moves the arm by less than its own size from the truth
    assert np.abs(found - truth).max() < 3e-4 + 2.5 * size


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Session:
    folder = tmp_path_factory.mktemp("rough")
    return load_session(notes_of("ur10", 5, form=Form(registered=False, rough=0.03)).write(folder, "ur10"))


@pytest.fixture(scope="module")
def fit(session: Session) -> Fit:
    return identify([session], [OFFSETS])


def test_a_session_turned_in_the_trackers_frame_gives_the_same_model(session: Session, fit: Fit) -> None:
    turn, shift = Rotation.from_euler("xyz", [0.7, -1.1, 2.9]).as_matrix(), np.array([3.0, -7.0, 1.5])
    there = session.samples.position @ turn.T + shift
    turned = identify([replace(session, samples=replace(session.samples, position=there))], [OFFSETS])
    k, other = (f.values()[BASE.name][K] for f in (fit, turned))
    assert other == pytest.approx(k, rel=1e-6)
    off = np.array([f.parameters[6:] for f in (fit, turned)])
    assert off[1] == pytest.approx(off[0], abs=1e-6 * np.abs(off).max() + 1e-9)


def test_a_start_far_off_along_what_is_free_comes_back(fit: Fit) -> None:
    """Joint zeros of 3 mrad against the twists of the links before them: no reading sees it."""
    away = fit.solution.vector.copy()
    names = [str(u) for u in fit.unknowns.free]
    for joint in (2, 3):
        away[names.index(f"{OFFSETS}.zero_rad[{joint}]")] += 3e-3
        away[names.index(f"{OFFSETS}.rz_rad[{joint - 1}]")] -= 3e-3
    moved = replace(fit, solution=replace(fit.solution, vector=away))
    seen = [f.sessions[0].further().predicted.position for f in (fit, moved)]
    assert np.abs(seen[0] - seen[1]).max() < 5e-5  # 3 mrad are 3 mm
    back, _ = with_drawing_scale(nearest_to_drawing(moved))
    assert np.abs(back.parameters[6:] - fit.parameters[6:]).max() < 2e-6
    assert np.abs(moved.parameters[6:] - fit.parameters[6:]).max() > 2e-3


def test_numbers_of_the_gauge_are_given_in_words_alone(fit: Fit) -> None:
    told = dict(zip((str(u) for u in fit.unknowns.free), fit.determined(), strict=True))
    words = fit.not_identified()
    for joint in range(1, 7):
        assert not told[f"{OFFSETS}.zero_rad[{joint}]"]
        assert sum(text.startswith(f"joint zero ({OFFSETS}) of joint {joint}:") for text in words) == 1
    assert told[f"{OFFSETS}.x_m[2]"] and told[f"{BASE.name}.{K}[2]"]
    correlations = fit.model("ur10", {}).correlations
    assert correlations is not None
    assert set(correlations.names) == {name for name, ok in told.items() if ok}


def design(fit: Fit) -> tuple[Floats, Floats]:
    """(M, P) whitened derivatives by the parameters with all that the station imitates taken out, and misfit."""
    rows = np.concatenate([b.jacobian for s in fit.sessions for b in s.blocks()])
    n = len(fit.unknowns)
    own = np.vstack([rows[:, n:], np.diag(1 / fit.problem.sd[n:])])
    mine = np.vstack([rows[:, :n], np.zeros((len(fit.problem.sd) - n, n))])
    return mine - own @ np.linalg.lstsq(own, mine, rcond=None)[0], fit.solution.misfit  # type: ignore[return-value]


def test_condition_and_observability_are_of_the_determined_directions(fit: Fit) -> None:
    """Against singular values of the stacked Jacobian: no normal equations, no Schur complement."""
    rows, misfit = design(fit)
    unit, scale = fit.gauge.unit, fit.unknowns.scale
    _, values, directions = linalg.svd(rows * unit / misfit, full_matrices=False)
    told = values**2 >= TOLD
    of = fit.observability()
    assert (of["determined"], of["undetermined"]) == (told.sum(), len(unit) - told.sum())
    assert 20 < told.sum() < 30  # six springs, and less than half of 42 offsets
    basis = linalg.orth(directions[told].T * (unit / scale)[:, None])
    singular = linalg.svdvals((rows * scale / misfit) @ basis) / np.sqrt(fit.solution.count)
    assert fit.condition_number() == pytest.approx(singular[0] / singular[-1], rel=1e-4)
    assert of["o1"] == pytest.approx(np.exp(np.log(singular).mean()), rel=1e-4)
    assert of["o3"] == pytest.approx(singular[-1], rel=1e-4)
    assert of["o2"] == pytest.approx(singular[-1] / singular[0], rel=1e-4)
    assert of["o4"] == pytest.approx(singular[-1] ** 2 / singular[0], rel=1e-4)


def test_springs_alone_are_determined_one_and_all(session: Session) -> None:
    springs = identify([session], [BASE.name])
    assert springs.observability()["undetermined"] == 0
    rows, misfit = design(springs)
    singular = linalg.svdvals(rows * springs.unknowns.scale / misfit)
    assert springs.condition_number() == pytest.approx(singular[0] / singular[-1], rel=1e-4)


def test_tracker_and_reflectors_are_where_the_lab_had_them(tmp_path: Path) -> None:
    """The arm is nominal: far nearer than the standard deviations say, which hold what a drawing leaves open."""
    notes = notes_of("ur10", 8, form=Form(registered=False, rough=0.03, blocks=2))
    fit = identify([load_session(notes.write(tmp_path, "ur10"))], [OFFSETS])
    found = {t.block: t for t in placed_trackers(fit)}
    assert set(found) == set(notes.truth.station) and len(found) == 2
    for block, truth in notes.truth.station.items():
        t = found[block]
        away = Rotation.from_matrix(t.rotation @ truth[:3, :3].T).as_rotvec()
        assert np.abs(t.origin - truth[:3, 3]).max() < 1e-4
        assert np.abs(away).max() < 1e-4
        assert 5e-4 < t.origin_sd.max() < 5e-3
        assert 1e-7 < t.rotation_sd.min() < 1e-5 and 5e-4 < t.rotation_sd.max() < 2e-3
        assert Rotation.from_euler("xyz", t.rpy).as_matrix() == pytest.approx(t.rotation)
    reflectors = {r.name: r for r in placed_reflectors(fit)}
    assert set(reflectors) == {t.name for t in ROUGH}
    for target in ROUGH:
        r = reflectors[target.name]
        assert r.link == target.link
        assert np.abs(r.position - np.array(target.at)).max() < 1e-4
        assert 1e-5 < r.sd.min() and r.sd.max() < 1.5e-3  # noqa: SIM300


@pytest.mark.parametrize("size", [0.0, 3e-4])
@pytest.mark.parametrize("robot", ["ur10", "abb-irb6600-175-255"])
def test_a_wrist_that_gravity_alone_loads_is_not_made_up(robot: str, size: float, tmp_path: Path) -> None:
    """Nothing loads joint 1, next to nothing joint 6; what is identified is right, what is not keeps its start."""
    notes = notes_of(robot, 40, setups=60, force=0.0, form=Form(registered=False, rough=0.03))
    fit = identify([crooked(load_session(notes.write(tmp_path, robot)), size)], [OFFSETS])
    k, known = fit.values()[BASE.name][K], fit.determined()[:6]
    assert known[1] and known[2]
    assert not known[0] and not known[5]
    assert k[~known] == pytest.approx(1e6, rel=0.01)
    truth = Lab(robot).stiffness
    assert np.abs((1 / k - 1 / truth) / fit.sd[:6])[known].max() < 4
    assert np.abs(k / truth - 1)[known].max() < 0.35
    assert fit.model(robot, {}).identified[BASE.name].tolist() == known.tolist()
    if size == 3e-4:
        assert not known[3:].any()  # their sag is smaller than what the model leaves of a reading


def test_a_wrist_that_is_loaded_stays_identified_beside_the_same_errors(tmp_path: Path) -> None:
    notes = notes_of("ur10", 41, setups=40, form=Form(registered=False, rough=0.03))
    fit = identify([crooked(load_session(notes.write(tmp_path, "ur10")), 3e-4)], [OFFSETS])
    assert fit.solution.misfit > 8
    assert fit.determined()[1:5].all()
    off = (fit.parameters[:6] - 1 / Lab("ur10").stiffness) / fit.sd[:6]
    assert np.abs(off[fit.determined()[:6]]).max() < 4
