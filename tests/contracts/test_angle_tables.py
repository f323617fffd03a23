"""Laws of the angle alone, and the table that the catalogue has: values, chain, slopes, what was never learned."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import numpy.typing as npt
import pytest

from compensator.tasks.compensate import compensate_file
from stiffness.effects import BY_NAME
from stiffness.effects.joint_angle_error import KNOTS, SPREAD
from stiffness.identification.arm_loads import ArmLoads, LoadKind
from stiffness.identification.fit import Fit
from stiffness.identification.fitting import fitted
from stiffness.identification.learned_numbers import FAR
from stiffness.identification.problem import Problem
from stiffness.identification.readings import ReadingModel
from stiffness.identification.session_data import SessionData
from stiffness.identification.unknowns import Unknowns, start_values, unknowns
from stiffness.identification.weighting import Weighting
from stiffness.model.model import load_model, model_text
from stiffness.poses import PoseArray
from stiffness.session.session import load_session
from stiffness.statics.predictor import Predictor
from stiffness.statics.tool import Tool
from tests.compensator.small_job import ABB, files
from tests.contracts.effect_laws import N, sample
from tests.contracts.test_effects_files import model_of
from tests.oracles.effects import ORACLES
from tests.plant import Arm, lab
from tests.plant.lab_design import random_setups
from tests.plant.wear import Situation, Wear
from tests.plant.worn_plant import WornPlant
from tests.stiffness import arms, session_desk

Floats = npt.NDArray[np.float64]
NAME = "joint-angle-error"
EFFECT = BY_NAME[NAME]
STIFF = "joint-stiffness"
DEGREES = -180 + 3 * np.arange(KNOTS)


def law(angle: Floats, table: Floats) -> Floats:
    """dq (n,) rad at commanded angles (n,)."""
    q = ca.SX.sym("q", len(angle))
    if EFFECT.angle is None:
        raise TypeError("no angle slot")
    dq = EFFECT.angle(q, {k: ca.SX(ca.DM(v)) for k, v in alone(table).items()})
    return np.array(ca.Function("dq", [q], [ca.densify(dq)])(angle)).ravel()


def alone(table: Floats) -> dict[str, Floats]:
    """The table (n * 120,) rad without harmonics."""
    return EFFECT.neutral(len(table) // KNOTS) | {"error_rad": table}


def oracle(angle: Floats, table: Floats) -> Floats:
    """(N, n) rad at angles (N, n)."""
    expected = ORACLES[NAME].angle
    if expected is None:
        raise TypeError("no oracle")
    return np.array([expected(q, alone(table)) for q in angle])


def waves(seed: int, size: float = 4e-4, joints: int = N) -> Floats:
    """Smooth tables (joints x 120,): some waves of 15 ... 90 deg."""
    rng, x = np.random.default_rng(seed), np.radians(DEGREES)
    out = []
    for _ in range(joints):
        orders, phases = rng.integers(4, 24, 3), rng.uniform(0, 6, 3)
        out.append(size * sum(np.sin(o * x + f) for o, f in zip(orders, phases, strict=True)) / 1.2)
    return np.concatenate(out)


# ------------------------------------------------------------------------------------------- values


@pytest.mark.parametrize("turn", [0.0, 360.0, -360.0, 720.0])
def test_at_its_knots_a_joint_errs_by_the_numbers_of_the_table(turn: float) -> None:
    table = sample(EFFECT, 1)["error_rad"]
    own = table.reshape(N, KNOTS)
    for k in (0, 1, 57, 60, 118, 119):
        got = law(np.full(N, np.radians(DEGREES[k] + turn)), table)
        np.testing.assert_allclose(got, own[:, k], atol=1e-14)
    low, high = np.radians(180 - 1e-9 + turn), np.radians(180 + 1e-9 + turn)
    np.testing.assert_allclose(law(np.full(N, low), table), own[:, 0], atol=1e-10)  # +180 is -180
    np.testing.assert_allclose(law(np.full(N, high), table), own[:, 0], atol=1e-10)


def test_between_two_knots_it_is_their_weighted_mean() -> None:
    table = np.zeros((N, KNOTS))
    table[:, 60], table[:, 61], table[:, 119], table[:, 0] = 1e-3, 5e-3, -4e-3, 2e-3
    for degrees, expected in ((0.75, 2e-3), (1.5, 3e-3), (2.7, 4.6e-3), (4.5, 2.5e-3), (177.75, -2.5e-3)):
        np.testing.assert_allclose(law(np.full(N, np.radians(degrees)), table.ravel()), expected, rtol=1e-10)
        again = law(np.full(N, np.radians(degrees - 720)), table.ravel())
        np.testing.assert_allclose(again, expected, rtol=1e-9)


@pytest.mark.parametrize("joints", [4, 6, 7])
def test_a_number_moves_its_own_joint_near_its_own_angle_alone(joints: int) -> None:
    rng = np.random.default_rng(joints)
    count = EFFECT.parameters[0].count(joints)
    assert count == joints * 120
    for site in EFFECT.sites(joints):
        numbers = np.arange(count)[EFFECT.parameters[0].of_site(site.index)]
        number = int(rng.choice(numbers))
        table, k = np.zeros(count), (number - numbers[0])
        table[number] = 3e-3
        at = np.radians(DEGREES[k] + rng.uniform(-2.9, 2.9))
        moved = law(np.full(joints, at), table)
        assert np.flatnonzero(moved).tolist() == [site.index] and site.where == (f"joint-{(site.index or 0) + 1}",)
        for far in (-3.1, 3.1, 90.0, 180.0):
            assert not law(np.full(joints, np.radians(DEGREES[k] + far)), table).any()


def test_its_slope_is_that_of_the_straight_line() -> None:
    """By the angle: what the complementary steps of prediction and compensation use."""
    table = sample(EFFECT, 2)["error_rad"]
    own, q = table.reshape(N, KNOTS), ca.SX.sym("q", N)
    assert EFFECT.angle is not None
    dq = EFFECT.angle(q, {k: ca.SX(ca.DM(v)) for k, v in alone(table).items()})
    slope = np.array(ca.Function("s", [q], [ca.densify(ca.jacobian(dq, q))])(np.radians([1, -179, 178, 50, 400, -361])))
    knots = [60, 0, 119, 76, 73, 59]
    expected = [(own[j, (k + 1) % KNOTS] - own[j, k]) / np.radians(3) for j, k in enumerate(knots)]
    np.testing.assert_allclose(slope, np.diag(expected), rtol=1e-9, atol=1e-12)


# ------------------------------------------------------------------------------ what it leaves open


def test_what_was_never_learned_is_left_open() -> None:
    """Zero and open by SPREAD at knots nobody saw; by its standard deviation at the others."""
    table, sd = np.zeros((N, KNOTS)), np.full((N, KNOTS), 2e-5)
    table[:, 50:70], sd[:, 55] = 3e-4, 7e-5
    degrees = np.array([[-15.0, -30.0, 0.0, 30.0, 27.0, -180.0]])  # knots 55, 50, 60, 70, 69, 0
    assert EFFECT.angle_sd is not None
    got = EFFECT.angle_sd(np.radians(degrees), alone(table.ravel()), {"error_rad": sd.ravel()})
    np.testing.assert_allclose(got, [[7e-5, 2e-5, 2e-5, SPREAD, 2e-5, SPREAD]], rtol=1e-6)
    turned = EFFECT.angle_sd(np.radians(degrees + 360), alone(table.ravel()), {"error_rad": sd.ravel()})
    np.testing.assert_allclose(turned, got, rtol=1e-6)
    outside = np.radians(np.random.default_rng(1).uniform(33, 320, (6, N)))
    assert not np.any([law(q, table.ravel()) for q in outside])


def test_without_standard_deviations_only_what_was_never_learned_is_open() -> None:
    table = np.zeros((N, KNOTS))
    table[2, :] = 1e-4
    assert EFFECT.angle_sd is not None
    got = EFFECT.angle_sd(np.radians(np.full((1, N), 12.0)), alone(table.ravel()), {})
    np.testing.assert_allclose(got, SPREAD * (np.arange(N) != 2)[None], rtol=1e-6)


# ----------------------------------------------------------------------------------------- the chain


def predictor(table: Floats, name: str = "ur10", stiffness: float = 1e12) -> Predictor:
    values = {STIFF: {"k_nm_per_rad": np.full(6, stiffness)}, NAME: alone(table)}
    held = Tool(np.eye(3), np.array([0.03, -0.05, 0.2]), 0.0, None)
    return Predictor(arms.robot(name), arms.effects(NAME), values, held, gravity=arms.GRAVITY)


def tcp(name: str, q: Floats) -> tuple[Floats, Floats]:
    """(N, 3, 3) and (N, 3): kinematics alone."""
    poses = np.array([arms.robot(name).pose(a) for a in q])
    return poses[:, :3, :3], poses[:, :3, 3] + poses[:, :3, :3] @ np.array([0.03, -0.05, 0.2])


@pytest.mark.parametrize("name", ["ur10", "abb-irb6600-175-255"])
def test_a_rigid_arm_stands_where_its_joints_really_are(name: str) -> None:
    table = waves(3, 1e-3)
    q = arms.postures(arms.robot(name), 12, 4)
    got = predictor(table, name).forward(q, np.zeros((12, 6)), np.zeros((12, 0)))
    rotation, position = tcp(name, q + oracle(q, table))
    np.testing.assert_allclose(got.position, position, atol=3e-8)  # 1e12 N*m/rad still gives way
    np.testing.assert_allclose(got.rotation, rotation, atol=3e-8)
    assert np.linalg.norm(position - tcp(name, q)[1], axis=1).max() > 1e-3


def test_a_command_cancels_it() -> None:
    """Commanded there, the TCP stands at the wanted pose; the command is off by the error at the command's angle."""
    table = waves(5, 1e-3)
    q = arms.postures(arms.robot("ur10"), 12, 6)
    wanted, none = PoseArray(*tcp("ur10", q)), np.zeros((12, 0))
    wrench = arms.wrenches(12, 60.0, 3)
    for stiffness in (1e12, 4e4):
        arm = predictor(table, stiffness=stiffness)
        command = arm.command(wanted, wrench, none, q)
        assert command.converged.all()
        back = arm.forward(command.q, wrench, none)
        np.testing.assert_allclose(back.position, wanted.origin, atol=1e-8)
        np.testing.assert_allclose(back.rotation, wanted.rotation, atol=1e-8)
        if stiffness > 1e9:
            np.testing.assert_allclose(command.q + oracle(command.q, table), q, atol=2e-7)
        assert np.abs(command.q - q).max() > 5e-4


def test_a_compensated_path_lies_on_the_part(tmp_path: Path) -> None:
    """From files to files: kinematics alone, at the angles where the joints of the written commands really are."""
    table = waves(7, 8e-4)
    effects = {STIFF: {"k_nm_per_rad": [1e12] * 6}, NAME: {"error_rad": table.tolist()}}
    job = files(tmp_path, {"gravity": "uncompensated"}, {"effects": effects})
    done = compensate_file(job.toolpath, job.cell, job.out / "a.csv")
    result, cut = done.result, done.result.cutting
    q, wanted, point = result.command.q[cut], result.path.tcp.origin[cut], result.job.arm.tools.first.position
    poses = np.array([arms.robot(ABB).pose(a) for a in q + oracle(q, table)])
    reached = poses[:, :3, 3] + poses[:, :3, :3] @ point
    assert np.linalg.norm(reached - wanted, axis=1).max() < 2e-7
    assert done.report["predicted_error_mm"]["before"]["max"] > 0.5
    assert done.report["predicted_error_mm"]["after"]["max"] < 2e-3  # the written program has so many digits


# ------------------------------------------------------------------------------------------- readings


def at_rest(model: ReadingModel, p: Floats, q: Floats, wrench: Floats) -> tuple[Floats, Floats]:
    """Positions (N, 3) of a reflector on the flange, and their slopes (N, 3, T) by the tables' numbers."""
    count = len(q)
    none = np.zeros((count, 1))
    loads = ArmLoads(
        q=q, wrench=wrench, point=np.zeros((count, 3)), state=np.zeros((count, 0)), payload=none, warm=none
    )
    x = np.zeros((count, model.n_x))
    for _ in range(6):
        arms_at_rest = model.equilibria(LoadKind(6, 6, False), p, loads, x)
        x = arms_at_rest.x
    out = model.positions(arms_at_rest, 6, np.tile([0.1, 0.02, 0.15], (count, 1)))
    return out.position, out.by_angle[:, :, model.tables.joint] * model.tables.slopes(q, p)[:, None]


def test_a_reading_moves_with_every_number_as_differences_say() -> None:
    effects, q = arms.effects(NAME), arms.postures(arms.robot("ur10"), 4, 8)
    fixed = start_values(effects, 6)
    fixed[STIFF]["k_nm_per_rad"] = np.full(6, 3e4)
    fixed[NAME]["error_rad"] = waves(9)
    layout = unknowns(effects, 6, extras=lambda effect, site: True)
    held = Tool(np.eye(3), np.zeros(3), 3.0, np.array([0.0, 0.0, 0.1]))
    model = ReadingModel(arms.robot("ur10"), layout, fixed, held, gravity=arms.GRAVITY, calibrated_out=False)
    p, wrench = layout.start(fixed), arms.wrenches(4, 60.0, 5)
    assert len(model.tables.core) == 6 and len(model.tables.own) == 720
    _, slopes = at_rest(model, p, q, wrench)
    felt = np.flatnonzero(np.abs(slopes).max(axis=(0, 1)) > 1e-3)
    assert 6 * 2 < len(felt) <= 4 * 6 * 2  # two knots of every joint at every posture
    for k in [*felt[::3].tolist(), 7]:
        step = 1e-5 * (np.arange(len(p)) == model.tables.own[k])
        (up, _), (down, _) = at_rest(model, p + step, q, wrench), at_rest(model, p - step, q, wrench)
        np.testing.assert_allclose(slopes[:, :, k], (up - down) / 2e-5, atol=2e-6 * np.abs(slopes).max())


def erring(table: Floats, count: int, seed: int, bend: float) -> lab.Notes:
    """A session of an arm whose joints err by the table, without load; joint 3 stays within +-``bend`` rad."""
    arm, own = Arm.load(session_desk.ROBOT, tool=session_desk.TOOL), table.reshape(6, KNOTS)

    def wrong(at: Situation) -> Floats:
        knots = np.radians(DEGREES)
        return np.array([np.interp(a, knots, t, period=2 * np.pi) for a, t in zip(at.command, own, strict=True)])

    wear = Wear(np.full(6, 5e4), np.ones(6), np.zeros(6), np.zeros(6), laws=(wrong,))
    narrow = Arm.load(session_desk.ROBOT, tool=session_desk.TOOL)
    narrow.lower[2], narrow.upper[2] = -bend, bend
    plan = random_setups(narrow, count, seed, directions=0)
    noise = lab.Noise(1.5e-5, 0.0, 0.0)
    return lab.measure(WornPlant(arm, wear), plan, session_desk.TARGETS[:2], noise=noise, seed=seed)


@pytest.fixture(scope="module")
def learned(tmp_path_factory: pytest.TempPathFactory) -> tuple[Fit, Floats]:
    """The tables of joints 3 and 5, found in readings of an arm that errs in these two."""
    truth = waves(11).reshape(6, KNOTS)
    truth[[0, 1, 3, 5]] = 0.0
    notes = erring(truth.ravel(), 150, 5, 1.0)
    session = load_session(notes.write(tmp_path_factory.mktemp("erring"), "ur10"))
    effects = arms.effects(NAME)
    fixed = start_values(effects, 6)
    fixed[STIFF]["k_nm_per_rad"] = np.full(6, 5e4)
    every = unknowns(effects, 6, extras=lambda effect, site: True)
    free = [u for u in every.free if u.effect == NAME and u.index // KNOTS in (2, 4)]
    layout = Unknowns(effects, 6, tuple(free))
    problem = Problem.of_sessions([SessionData.of(session)], [Weighting(session, 0.0)], layout, fixed)
    return fitted(problem, problem.first_states()), truth.ravel()


def test_slopes_of_predicted_readings_are_those_of_differences(learned: tuple[Fit, Floats]) -> None:
    fit, _ = learned
    (session,) = fit.sessions
    p, predictor = fit.parameters, session.observations.predictor
    seen = session.predicted
    felt = np.flatnonzero(np.abs(seen.by_parameter).max(axis=(0, 1)) > 0.02)
    assert len(felt) > 60
    for k in felt[::15].tolist():
        step = 1e-5 * (np.arange(len(p)) == k)
        up, down = (predictor.predict(seen.state, p + s, session.own).position for s in (step, -step))
        np.testing.assert_allclose(seen.by_parameter[:, :, k], (up - down) / 2e-5, atol=1e-5)


def test_a_smooth_table_is_found_where_it_was_seen(learned: tuple[Fit, Floats]) -> None:
    fit, truth = learned
    mine = np.r_[2 * KNOTS : 3 * KNOTS, 4 * KNOTS : 5 * KNOTS]
    value, sd = (d[NAME]["error_rad"][mine] for d in (fit.values(), fit.deviations()))
    covered = sd < 0.2 * SPREAD
    assert covered.sum() > 80 and np.sqrt(np.mean(truth[mine][covered] ** 2)) > 3e-4
    z = (value - truth[mine]) / sd
    assert np.abs(z[covered]).max() < 3.5 and np.sqrt(np.mean(z[covered] ** 2)) < 1.3
    left, there = (np.sqrt(np.mean(v[covered] ** 2)) for v in (value - truth[mine], truth[mine]))
    assert left < 0.2 * there


def test_knots_that_nobody_saw_stay_zero_and_open(learned: tuple[Fit, Floats]) -> None:
    fit, truth = learned
    value, sd = (d[NAME]["error_rad"][2 * KNOTS : 3 * KNOTS] for d in (fit.values(), fit.deviations()))
    seen = np.degrees(np.abs(fit.sessions[0].samples.q[:, 2]).max())
    outside = np.abs(DEGREES) > seen + 3
    assert outside.sum() > 70 and np.abs(truth[2 * KNOTS : 3 * KNOTS][outside]).max() > 3e-4
    assert np.abs(value[outside]).max() < 1e-15
    np.testing.assert_allclose(sd[outside], SPREAD * fit.solution.misfit, rtol=1e-6)
    assert EFFECT.angle_sd is not None
    q = np.zeros((1, 6))
    q[0, 2] = np.radians(120.0)
    left = EFFECT.angle_sd(q, fit.values()[NAME], fit.deviations()[NAME])
    assert left[0, 2] == pytest.approx(SPREAD, rel=0.05)


def test_a_knot_that_ran_away_is_not_learned(learned: tuple[Fit, Floats]) -> None:
    """One reading that is wrong by far puts 18 mrad into a knot that hardly another one reaches."""
    fit, _ = learned
    assert fit.learned().sum() < len(fit.unknowns) and np.array_equal(
        fit.learned(), np.diag(fit.solution.information)[: len(fit.unknowns)] > 0
    )
    knot = int(np.flatnonzero(fit.learned())[3])
    for value, kept in ((18e-3, False), (-18e-3, False), (1.5e-3, True)):
        vector = fit.solution.vector.copy()
        vector[knot] = value
        away = replace(fit, solution=replace(fit.solution, vector=vector))
        u = fit.unknowns.free[knot]
        assert away.values()[NAME]["error_rad"][u.index] == (value if kept else 0.0)
        assert away.learned().sum() == fit.learned().sum() - (not kept)
        assert sum("far out of its table" in text for text in away.not_identified()) == (not kept)
        assert away.model("ur10", {}).values[NAME]["error_rad"][u.index] == (value if kept else 0.0)
    # an arm whose gears err by ten times as much is an arm, no wrong reading
    large = replace(fit, solution=replace(fit.solution, vector=10 * fit.solution.vector))
    assert large.learned().sum() == fit.learned().sum()
    assert np.abs(large.values()[NAME]["error_rad"]).max() > FAR * SPREAD


def test_a_model_file_keeps_table_and_deviations(learned: tuple[Fit, Floats], tmp_path: Path) -> None:
    fit, _ = learned
    path = tmp_path / "model.toml"
    values = fit.values()[NAME]
    path.write_text(model_text(model_of(EFFECT, values)), encoding="utf-8")
    back = load_model(path)
    assert back.values[NAME]["error_rad"].tobytes() == values["error_rad"].tobytes()
    text = path.read_text(encoding="utf-8")
    assert text.count("error_rad = [") == 2 and len(back.values[NAME]["error_rad"]) == 720
