"""Predictor: forwards against oracles, backwards against forwards."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial.transform import Rotation

from stiffness.effects import BY_NAME
from stiffness.effects.effect import Effect, Parameter, PointMass
from stiffness.errors import EquilibriumError
from stiffness.statics.prediction import TOLERANCE, StartValues
from stiffness.statics.predictor import MAX_STEPS, Predictor
from stiffness.statics.tool import Tool
from tests.oracles.elastic_arm import ElasticArm, Push
from tests.stiffness import arms

Floats = npt.NDArray[np.float64]
MODELS = {
    "joints": (),
    "hardening": ("joint-hardening",),
    "tool spring": ("tool-compliance",),
    "memory": ("preload-softening", "backlash"),
    "all": ("preload-softening", "backlash", "joint-hardening", "tool-compliance"),
}


def tool_compliance() -> Floats:
    """(6, 6) of arms.VALUES, put together entry by entry."""
    p = arms.VALUES["tool-compliance"]
    c = np.diag(np.r_[p["linear_m_per_n"], p["angular_rad_per_nm"]])
    entries = iter(p["coupling"])
    for row in range(6):
        for column in range(row):
            c[row, column] = c[column, row] = next(entries)
    return c


def hardened(torque: Floats, angle: Floats) -> Floats:
    p = arms.VALUES["joint-hardening"]
    further = p["further_rad"] * np.tanh(torque / p["knee_nm"] / 4)
    return np.asarray(torque / arms.STIFFNESS + p["windup_rad"] * np.tanh(torque / p["knee_nm"]) + further)


def states(predictor: Predictor, count: int, seed: int = 0) -> Floats:
    """(count, m) states as a walk leaves them: directions +-1, flanks anywhere in the gap."""
    rng = np.random.default_rng(seed)
    parts = [np.empty((count, 0))]
    for e in predictor.statics.remembering:
        half = e.memory.bounds(arms.VALUES[e.name])  # type: ignore[union-attr]
        u = rng.uniform(-1, 1, (count, 6))
        parts.append(half * (np.sign(u) if e.name == "preload-softening" else u))
    return np.hstack(parts)


def tcp(arm_pose: Floats, tool: Tool) -> tuple[Floats, Floats]:
    return arm_pose[:3, :3] @ tool.rotation, arm_pose[:3, :3] @ tool.position + arm_pose[:3, 3]


def off(r: Floats, p: Floats, r_wanted: Floats, p_wanted: Floats) -> float:
    """Largest miss of poses, m and rad."""
    turn = Rotation.from_matrix(r @ np.swapaxes(r_wanted, 1, 2)).as_rotvec()
    return float(max(np.abs(p - p_wanted).max(), np.abs(turn).max()))


# ---------------------------------------------------------------------------------------------- forwards


@pytest.mark.parametrize("name", arms.NAMES)
def test_nominal_is_pinocchio_and_the_tool(name: str) -> None:
    arm, tool = arms.robot(name), arms.tool()
    q = np.random.default_rng(1).uniform(-3, 3, (100, 6))
    wanted = arms.predictor(arm=arm).nominal(q)
    for k in range(100):
        expected_r, expected_p = tcp(arm.pose(q[k]), tool)
        np.testing.assert_allclose(wanted.rotation[k], expected_r, atol=1e-12)
        np.testing.assert_allclose(wanted.origin[k], expected_p, atol=1e-12)


@pytest.mark.parametrize(
    ("effects", "law", "compliance"),
    [
        ((), lambda tau, a: tau / arms.STIFFNESS, {}),
        (("joint-hardening",), hardened, {}),
        (("tool-compliance",), lambda tau, a: tau / arms.STIFFNESS, {6: tool_compliance()}),
        (("joint-hardening", "tool-compliance"), hardened, {6: tool_compliance()}),
    ],
)
@pytest.mark.parametrize("calibrated_out", [False, True])
def test_forward_is_the_equilibrium_of_virtual_work(effects, law, compliance, calibrated_out: bool) -> None:
    """calibrated-out: the pose, moved by what arm and tool sag without process, in base axes."""
    arm, tool, gravity = arms.robot(), arms.tool(), np.array([3.0, -2.0, -9.0])
    oracle = ElasticArm(arm, law, compliance, ((6, tool.mass, tool.com),), gravity)
    predictor = arms.predictor(*effects, gravity=gravity, calibrated_out=calibrated_out)
    q = arms.postures(arm, 2, 2)
    w = arms.wrenches(2, 2000.0, 3)
    got = predictor.forward(q, w, np.zeros(0))
    for k in range(2):
        x, force = oracle.solve(q[k], [Push(6, tool.position, w[k])])
        r, p = tcp(oracle.links(q[k], x)[6], tool)
        if calibrated_out:
            sagged, _ = oracle.solve(q[k], [])
            sag_r, sag_p = tcp(oracle.links(q[k], sagged)[6], tool)
            rigid_r, rigid_p = tcp(arm.pose(q[k]), tool)
            assert np.linalg.norm(sag_p - rigid_p) > 1e-4
            r, p = r @ sag_r.T @ rigid_r, p - sag_p + rigid_p
        np.testing.assert_allclose(got.position[k], p, atol=1e-11)
        np.testing.assert_allclose(got.rotation[k], r, atol=1e-11)
        np.testing.assert_allclose(got.torque[k], force[:6], atol=1e-6)


def test_calibrated_out_leaves_an_unloaded_arm_where_it_is() -> None:
    predictor = arms.predictor("joint-hardening", "tool-compliance", calibrated_out=True)
    q = arms.postures(arms.robot(), 20, 4)
    wanted = predictor.nominal(q)
    got = predictor.forward(q, np.zeros(6), np.zeros(0))
    assert off(got.rotation, got.position, wanted.rotation, wanted.origin) < 1e-14


def test_calibrated_out_keeps_the_flank_and_the_softer_side() -> None:
    """The controller knows the sag of neutral joints only: flanks remain as an error."""
    arm, tool = arms.robot(), arms.tool()
    predictor = arms.predictor("preload-softening", "backlash", calibrated_out=True)
    q = arms.postures(arm, 1, 5)
    flank, ratio = arms.VALUES["backlash"]["gap_rad"] / 2, arms.VALUES["preload-softening"]["ratio"]
    got = predictor.forward(q, np.zeros(6), np.r_[-np.ones(6), flank][None])
    neutral = ElasticArm(arm, lambda tau, a: tau / arms.STIFFNESS, masses=((6, tool.mass, tool.com),))
    real = replace(neutral, law=lambda tau, a: tau / (arms.STIFFNESS * np.where(tau > 0, ratio, 1)) + flank)
    nominal = predictor.nominal(q).origin
    expected = position(real, q[0], tool) - position(neutral, q[0], tool)
    np.testing.assert_allclose(got.position[0] - nominal[0], expected, atol=1e-11)
    assert np.linalg.norm(expected) > 1e-4


def position(oracle: ElasticArm, q: Floats, tool: Tool) -> Floats:
    """TCP of an arm under its weight."""
    return tcp(oracle.links(q, oracle.solve(q, [])[0])[6], tool)[1]


def test_payload_is_not_calibrated_out() -> None:
    """A mass that an effect adds sags the arm whatever the controller knows."""
    payload = Effect(
        name="payload",
        cause="test",
        scope="tool",
        parameters=(Parameter(name="mass_kg", unit="kg", size=1, start=0, low=0, high=1e3, scale=1, meaning="test"),),
        site_kind="tool",
        mass=lambda n, p: (PointMass(n, p["mass_kg"], ca.SX(ca.DM([0.1, 0, 0.2]))),),
    )
    values = {**arms.VALUES, "payload": {"mass_kg": np.array([60.0])}}
    arm, q = arms.robot(), arms.postures(arms.robot(), 3, 6)
    known, unknown = (
        Predictor(arm, effects, values, arms.tool(), gravity=arms.GRAVITY, calibrated_out=True)
        for effects in (arms.effects(), (*arms.effects(), payload))
    )
    tool = arms.tool()
    declared = ElasticArm(arm, lambda tau, a: tau / arms.STIFFNESS, masses=((6, tool.mass, tool.com),))
    loaded = replace(declared, masses=(*declared.masses, (6, 60.0, np.array([0.1, 0, 0.2]))))
    wanted = known.nominal(q)
    got = unknown.forward(q, np.zeros(6), np.zeros(0))
    for k in range(3):
        expected = position(loaded, q[k], tool) - position(declared, q[k], tool)
        np.testing.assert_allclose(got.position[k] - wanted.origin[k], expected, atol=1e-11)
        assert np.linalg.norm(expected) > 1e-4
    back = unknown.command(wanted, np.zeros((3, 6)), np.zeros((3, 0)), q)
    assert back.converged.all()
    again = unknown.forward(back.q, np.zeros(6), np.zeros(0))
    assert off(again.rotation, again.position, wanted.rotation, wanted.origin) < 1e-10


def offset(place: int) -> Effect:
    """A constant joint term and a constant displacement of a place: there without load."""
    return Effect(
        name="offset",
        cause="test",
        scope="robot",
        parameters=(Parameter(name="o", unit="SI", size=12, start=0, low=-1, high=1, scale=1, meaning="test"),),
        site_kind="arm",
        joint=lambda given, p: p["o"][:6],
        place=lambda given, p: p["o"][6:],
        places=lambda n: (place,),
    )


@pytest.mark.parametrize("complementary", [False, True])
def test_what_the_controller_knows_of_the_sag_leaves_kinematic_offsets_alone(complementary: bool) -> None:
    """An arm with offsets and no load stands away from its command, whatever sag is taken off."""
    o = 1e-3 * np.array([1, -2, 3, -4, 5, 6, 0.5, -0.3, 0.2, 4, 5, -6.0])
    values = {**arms.VALUES, "offset": {"o": o}}
    arm, tool, q = arms.robot(), arms.tool(), arms.postures(arms.robot(), 3, 23)
    predictor = Predictor(
        arm,
        (*arms.effects(), offset(3)),
        values,
        tool,
        gravity=arms.GRAVITY,
        calibrated_out=True,
        complementary=complementary,
    )
    oracle = ElasticArm(arm, lambda tau, a: tau / arms.STIFFNESS, {3: np.zeros((6, 6))})
    got = predictor.forward(q, np.zeros(6), np.zeros(0))
    for k in range(3):
        r, p = tcp(oracle.links(q[k], o)[6], tool)
        np.testing.assert_allclose(got.position[k], p, atol=1e-12)
        np.testing.assert_allclose(got.rotation[k], r, atol=1e-12)
    close(predictor, q, arms.wrenches(3, 500.0), np.zeros((3, 0)))


def test_a_warm_arm() -> None:
    growth = Effect(
        name="growth",
        cause="test",
        scope="robot",
        parameters=(Parameter(name="a", unit="m/K", size=1, start=0, low=-1, high=1, scale=1, meaning="test"),),
        site_kind="tool",
        place=lambda given, p: ca.vertcat(0, 0, p["a"] * given.temperature, ca.SX.zeros(3)),
        places=lambda n: (n,),
    )
    values = {**arms.VALUES, "growth": {"a": np.array([1e-5])}}
    arm, q = arms.robot(), arms.postures(arms.robot(), 3, 7)
    cold, warm = (
        Predictor(arm, (*arms.effects(), growth), values, arms.tool(0), gravity=np.zeros(3), temperature=t)
        for t in (0.0, 15.0)
    )
    a, b = cold.forward(q, np.zeros(6), np.zeros(0)), warm.forward(q, np.zeros(6), np.zeros(0))
    z = (a.rotation @ arms.TOOL_ROTATION.T)[:, :, 2]
    np.testing.assert_allclose(b.position - a.position, 1.5e-4 * z, atol=1e-14)


def test_without_complementary_stiffness_the_load_is_that_of_the_undeflected_arm() -> None:
    arm, tool = arms.robot(), arms.tool(0)
    predictor = arms.predictor(complementary=False, tool=tool)
    q, w = arms.postures(arm, 5, 8), arms.wrenches(5, 4000.0, 8)
    got = predictor.forward(q, w, np.zeros(0))
    for k in range(5):
        r, _ = tcp(arm.pose(q[k]), tool)
        lever = r @ tool.rotation.T @ tool.position
        about = np.r_[w[k, :3], w[k, 3:] + np.cross(lever, w[k, :3])]
        dq = (arm.jacobian(q[k]).T @ about + arm.gravity_torque(q[k])) / arms.STIFFNESS
        np.testing.assert_allclose(got.position[k], tcp(arm.pose(q[k] + dq), tool)[1], atol=1e-12)
    exact = arms.predictor(tool=tool).forward(q, w, np.zeros(0))
    assert np.abs(exact.position - got.position).max() > 1e-5


@pytest.mark.parametrize("effects", [(), ("tool-compliance",)])
@pytest.mark.parametrize("calibrated_out", [False, True])
def test_absurdly_soft_is_an_error(effects: tuple[str, ...], calibrated_out: bool) -> None:
    values = {**arms.VALUES, "joint-stiffness": {"k_nm_per_rad": np.full(6, 100.0)}}
    predictor = arms.predictor(*effects, values=values, calibrated_out=calibrated_out)
    q = arms.postures(arms.robot(), 4, 9)
    with pytest.raises(EquilibriumError, match=r"pose \d: no static equilibrium.*too large.*N\*m/rad"):
        predictor.forward(q, arms.wrenches(4, 500.0), np.zeros(0))


def test_the_error_names_the_pose_without_equilibrium() -> None:
    predictor = arms.predictor()
    q, w = arms.postures(arms.robot(), 5, 10), arms.wrenches(5, 100.0)
    w[3, :3] *= 1e5
    with pytest.raises(EquilibriumError, match="pose 3:"):
        predictor.forward(q, w, np.zeros(0))


def test_a_mass_without_its_centre_is_refused() -> None:
    with pytest.raises(ValueError, match=r"'spindle': 35 kg without a centre of mass"):
        Tool(rotation=np.eye(3), position=np.zeros(3), mass=35.0, com=None, name="spindle")


# --------------------------------------------------------------------------------------------- backwards


def test_closed_form_of_a_joint_elastic_arm() -> None:
    """q_cmd = q_act - K^-1 (J(q_act)^T W + g(q_act)), with Pinocchio's J and g, leads back to FK(q_act)."""
    arm, tool = arms.robot(), arms.tool(0)
    predictor = arms.predictor(tool=tool)
    actual, w = arms.postures(arm, 20, 11), arms.wrenches(20, 3000.0, 11)
    wanted = predictor.nominal(actual)
    commanded = np.empty_like(actual)
    for k, q in enumerate(actual):
        lever = wanted.rotation[k] @ tool.rotation.T @ tool.position
        about = np.r_[w[k, :3], w[k, 3:] + np.cross(lever, w[k, :3])]
        commanded[k] = q - (arm.jacobian(q).T @ about + arm.gravity_torque(q)) / arms.STIFFNESS
    got = predictor.forward(commanded, w, np.zeros(0))
    assert off(got.rotation, got.position, wanted.rotation, wanted.origin) < 2e-12
    solve = predictor.command(wanted, w, np.zeros((20, 0)), actual)
    np.testing.assert_allclose(solve.q, commanded, atol=1e-12)
    assert solve.steps == 0 and solve.converged.all()


@pytest.mark.parametrize("calibrated_out", [False, True])
@pytest.mark.parametrize("model", MODELS)
def test_command_then_forward_is_the_wanted_pose(model: str, calibrated_out: bool) -> None:
    predictor = arms.predictor(*MODELS[model], calibrated_out=calibrated_out)
    arm = arms.robot()
    q = arms.postures(arm, 200, 12)
    w, s = arms.wrenches(200, 1000.0, 12), states(predictor, 200)
    command = close(predictor, q, w, s)
    assert command.steps <= 8  # each gains about two digits


@pytest.mark.parametrize("name", arms.NAMES[1:])
def test_command_then_forward_on_every_robot(name: str) -> None:
    arm = arms.robot(name)
    predictor = arms.predictor(*MODELS["all"], arm=arm, calibrated_out=True)
    close(predictor, arms.postures(arm, 60, 13), arms.wrenches(60, 300.0, 13), states(predictor, 60))


@pytest.mark.parametrize("model", MODELS)
def test_command_then_forward_of_a_soft_arm_under_four_kilonewtons(model: str) -> None:
    """Joints a fifth as stiff, at their limits: deflections of centimetres."""
    arm = arms.robot()
    values = {**arms.VALUES, "joint-stiffness": {"k_nm_per_rad": arms.STIFFNESS / 5}}
    predictor = arms.predictor(*MODELS[model], values=values)
    q = arms.postures(arm, 60, 14)
    edge = np.random.default_rng(14).integers(0, 3, q.shape)
    edge[:, 4] = 0
    q = np.where(edge == 1, np.maximum(arm.lower, -np.pi) + 1e-4, np.where(edge == 2, arm.upper - 1e-4, q))
    q = q[[np.linalg.svd(arm.jacobian(k))[1][-1] > 0.1 for k in q]]
    assert len(q) > 20
    w = arms.wrenches(len(q), 4000.0, 14)
    command = close(predictor, q, w, states(predictor, len(q)))
    p = predictor.nominal(q).origin
    assert np.linalg.norm(command.position - p, axis=1).max() > 0.02


def test_command_then_forward_without_complementary_stiffness() -> None:
    for calibrated_out in (False, True):
        predictor = arms.predictor("tool-compliance", complementary=False, calibrated_out=calibrated_out)
        close(predictor, arms.postures(arms.robot(), 40, 15), arms.wrenches(40, 2000.0), np.zeros((40, 0)))


def test_command_then_forward_where_the_law_depends_on_the_commanded_angle() -> None:
    """posture-stiffness of the later catalogue: not the actual posture alone enters the law."""
    varying = Effect(
        name="varying",
        cause="test",
        scope="robot",
        parameters=(Parameter(name="a", unit="1", size="joint", start=0, low=0, high=1, scale=1, meaning="test"),),
        site_kind="joint",
        joint=lambda given, p: given.elastic * p["a"] * ca.sin(3 * given.angle),
    )
    values = {**arms.VALUES, "varying": {"a": np.full(6, 0.4)}}
    predictor = Predictor(arms.robot(), (*arms.effects(), varying), values, arms.tool(), gravity=arms.GRAVITY)
    command = close(predictor, arms.postures(arms.robot(), 40, 16), arms.wrenches(40, 3000.0), np.zeros((40, 0)))
    assert command.steps > 0


def close(predictor: Predictor, q: Floats, w: Floats, s: Floats):
    """Solve for the nominal poses of q and run the commands forward."""
    wanted = predictor.nominal(q)
    command = predictor.command(wanted, w, s, q)
    assert command.converged.all(), (command.steps, command.error.max())
    got = predictor.forward(command.q, w, s)
    assert off(got.rotation, got.position, wanted.rotation, wanted.origin) < 1e-9
    np.testing.assert_allclose(got.torque, command.torque, rtol=1e-6, atol=1e-4)
    printed = predictor.nominal(command.q)
    assert off(command.rotation, command.position, printed.rotation, printed.origin) < 1e-12
    moved = np.linalg.norm(command.position - wanted.origin, axis=1)
    assert np.median(moved) > 5e-5
    if not predictor.statics.places:
        plain = replace_calibrated(predictor)
        where = plain.forward(command.q, w, s)
        actual = plain.nominal(command.actual)
        assert off(where.rotation, where.position, actual.rotation, actual.origin) < 1e-9
    return command


def replace_calibrated(predictor: Predictor) -> Predictor:
    """The same arm before a controller takes its sag off: where the links really are."""
    return Predictor(
        predictor.robot,
        predictor.statics.effects,
        predictor.values,
        predictor.tool,
        gravity=arms.GRAVITY,
        complementary=predictor.complementary,
    )


def test_the_solve_can_begin_near() -> None:
    predictor = arms.predictor(*MODELS["all"])
    q, w = arms.postures(arms.robot(), 50, 17), arms.wrenches(50, 1000.0)
    wanted = predictor.nominal(q)
    s = states(predictor, 50)
    far = predictor.command(wanted, w, s, q)
    again = predictor.command(wanted, w, s, q, StartValues(far.q, far.actual, far.extra))
    assert again.steps < far.steps
    np.testing.assert_allclose(again.q, far.q, atol=1e-9)


@pytest.mark.parametrize("model", ["joints", "tool spring"])
@pytest.mark.parametrize("calibrated_out", [False, True])
def test_rows_without_a_solution_are_reported_and_spoil_no_other(model: str, calibrated_out: bool) -> None:
    predictor = arms.predictor(*MODELS[model], calibrated_out=calibrated_out)
    q, w = arms.postures(arms.robot(), 6, 18), arms.wrenches(6, 800.0)
    wanted = predictor.nominal(q)
    expected = predictor.command(wanted, w, np.zeros((6, 0)), q)
    wanted.origin[1] += [8.0, 0, 0]  # out of reach
    wanted.origin[4] = np.nan
    got = predictor.command(wanted, w, np.zeros((6, 0)), q)
    np.testing.assert_array_equal(got.converged, [True, False, True, True, False, True])
    keep = [0, 2, 3, 5]
    np.testing.assert_allclose(got.q[keep], expected.q[keep], atol=1e-14)
    assert not np.any(got.error[[1, 4]] <= TOLERANCE)


def test_a_start_half_a_turn_away_is_not_called_converged() -> None:
    """The rotation vector of half a turn is zero in its first order."""
    predictor = arms.predictor(tool=Tool(np.eye(3), np.zeros(3)), gravity=np.zeros(3))
    q = arms.postures(arms.robot(), 4, 19)
    q[:, 5] = np.linspace(-1.5, -0.5, 4)
    wanted = predictor.nominal(q)
    turned = q + np.pi * np.eye(6)[5]  # the flange turns about its own axis: same place, half a turn
    command = predictor.command(wanted, np.zeros((4, 6)), np.zeros((4, 0)), turned)
    reached = predictor.nominal(command.q).rotation
    wrong = np.abs(reached - wanted.rotation).max(axis=(1, 2)) > 1e-6
    assert not np.any(command.converged & wrong)


def test_commands_that_never_settle_are_not_called_converged() -> None:
    """A law that turns over within the correction has no fixed point to find."""
    wild = Effect(
        name="wild",
        cause="test",
        scope="robot",
        parameters=(Parameter(name="a", unit="1", size="joint", start=0, low=0, high=1, scale=1, meaning="test"),),
        site_kind="joint",
        joint=lambda given, p: p["a"] * ca.sin(1e5 * given.angle),
    )
    values = {**arms.VALUES, "wild": {"a": np.full(6, 1e-3)}}
    predictor = Predictor(arms.robot(), (*arms.effects(), wild), values, arms.tool(), gravity=arms.GRAVITY)
    q = arms.postures(arms.robot(), 20, 20)
    wanted = predictor.nominal(q)
    command = predictor.command(wanted, np.zeros((20, 6)), np.zeros((20, 0)), q)
    assert not command.converged.any()
    assert command.steps == MAX_STEPS - 1


def test_joint_deflection_is_the_sum_of_the_laws() -> None:
    predictor = arms.predictor("preload-softening", "backlash", "joint-hardening")
    rng = np.random.default_rng(21)
    q, tau, s = rng.uniform(-1, 1, (30, 6)), rng.normal(size=(30, 6)) * 500, states(predictor, 30)
    got = predictor.joint_deflection(q, tau, s)
    ratio = np.where(tau * s[:, :6] < 0, arms.VALUES["preload-softening"]["ratio"], 1.0)
    hardening = arms.VALUES["joint-hardening"]
    expected = tau / (ratio * arms.STIFFNESS) + s[:, 6:] + hardening["windup_rad"] * np.tanh(tau / hardening["knee_nm"])
    expected += hardening["further_rad"] * np.tanh(tau / hardening["knee_nm"] / 4)
    np.testing.assert_allclose(got, expected, rtol=1e-12, atol=1e-17)


def test_states_are_taken_row_by_row_or_shared() -> None:
    predictor = arms.predictor("preload-softening", "backlash")
    q, w, s = arms.postures(arms.robot(), 5, 22), arms.wrenches(1, 500.0)[0], states(predictor, 1)[0]
    shared = predictor.forward(q, w, s)
    tiled = predictor.forward(q, np.tile(w, (5, 1)), np.tile(s, (5, 1)))
    np.testing.assert_array_equal(shared.position, tiled.position)


def test_repr_is_one_line() -> None:
    text = repr(arms.predictor("backlash"))
    assert "\n" not in text and "backlash" in text and "abb-irb6600" in text
    assert BY_NAME["backlash"].memory is not None and replace(arms.tool(), name="x").name == "x"
