"""Statics against Pinocchio, against virtual work, against Chen & Kao."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import numpy.typing as npt
import pytest
from scipy.optimize import root
from scipy.spatial.transform import Rotation

from stiffness.effects import BY_NAME
from stiffness.effects.effect import Effect, Parameter, PointMass
from stiffness.statics.load import Load
from stiffness.statics.small_rotation import generalised_moment, rotation
from stiffness.statics.statics import Statics
from tests.oracles.elastic_arm import ElasticArm, Push
from tests.stiffness import arms

Floats = npt.NDArray[np.float64]
SPRING = BY_NAME["joint-stiffness"]
MOUNTS = {
    "floor": (0.0, 0.0, -9.80665),
    "wall": (9.80665, 0.0, 0.0),
    "ceiling": (0.0, 0.0, 9.80665),
    "tilted": tuple(9.80665 * np.array([2.0, -3.0, 6.0]) / 7),
}


def dm(a: npt.ArrayLike) -> ca.SX:
    return ca.SX(ca.DM(np.asarray(a, dtype=float)))


def numbers(v: ca.SX) -> Floats:
    return np.array(ca.evalf(ca.densify(v)))


def six_dof(places: tuple[int, ...], spring: Effect | None = None) -> Effect:
    """A spring with any (6, 6) at any places."""
    return Effect(
        name="six-dof",
        cause="test",
        scope="robot",
        parameters=(Parameter(name="c", unit="SI", size=36, start=0, low=-1, high=1, scale=1, meaning="test"),),
        site_kind="place",
        place=lambda given, p: ca.mtimes(ca.reshape(p["c"], 6, 6), given.wrench),
        places=lambda n: places,
    )


def random_compliance(seed: int, size: float = 1.0) -> Floats:
    a = np.random.default_rng(seed).normal(size=(6, 6))
    scale = np.diag(np.sqrt([2e-7, 1e-7, 3e-7, 5e-7, 1e-6, 8e-7])) * np.sqrt(size)
    return np.asarray(scale @ (a @ a.T / 6 + 0.1 * np.eye(6)) @ scale)


def solved(
    statics: Statics,
    q: Floats,
    values: dict[str, dict[str, Floats]],
    loads: list[Push],
    gravity: Floats,
    extra: list[tuple[int, float, Floats]] | None = None,
    sweeps: int = 30,
    complementary: bool = True,
):
    """The equilibrium with numbers all through."""
    symbols = {e: {k: dm(v) for k, v in p.items()} for e, p in values.items()}
    weights = statics.loads_of_weight(dm(gravity), [(k, ca.SX(m), dm(c)) for k, m, c in extra or []], symbols)
    pushed = [Load(p.link, dm(p.point), dm(p.wrench)) for p in loads]
    return statics.equilibrium(
        dm(q),
        ca.SX.zeros(statics.n_x),
        weights=weights,
        loads=pushed,
        state=ca.SX.zeros(statics.n_state),
        values=symbols,
        sweeps=sweeps,
        complementary=complementary,
    )


# ---------------------------------------------------------------------------------------------- rotation


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-6, 1e-3, 0.01, 0.049])
def test_rotation_is_that_of_the_rotation_vector(angle: float) -> None:
    for axis in np.random.default_rng(1).normal(size=(20, 3)):
        v = angle * axis / np.linalg.norm(axis)
        np.testing.assert_allclose(numbers(rotation(dm(v))), Rotation.from_rotvec(v).as_matrix(), atol=3e-16)


@pytest.mark.parametrize("angle", [0.05, 0.5, 3.0, 40.0])
def test_rotation_is_orthogonal_whatever_the_angle(angle: float) -> None:
    for axis in np.random.default_rng(2).normal(size=(20, 3)):
        r = numbers(rotation(dm(angle * axis / np.linalg.norm(axis))))
        np.testing.assert_allclose(r @ r.T, np.eye(3), atol=1e-15)
        assert np.linalg.det(r) == pytest.approx(1, abs=1e-14)


def test_rotation_has_a_derivative_at_zero() -> None:
    v = ca.SX.sym("v", 3)
    slope = ca.Function("f", [v], [ca.jacobian(ca.vec(rotation(v)), v)])(ca.DM.zeros(3))
    expected = np.array([np.cross(np.eye(3), -np.eye(3)[k]).T.ravel(order="F") for k in range(3)])
    np.testing.assert_allclose(np.abs(np.array(slope)), np.abs(expected.T), atol=1e-15)
    np.testing.assert_allclose(np.array(slope)[[5, 6, 1], [0, 1, 2]], 1.0, atol=1e-15)


@pytest.mark.parametrize("angle", [0.0, 1e-5, 0.01, 0.3])
def test_a_moment_works_on_a_rotation_vector_as_it_works_on_the_rotation(angle: float) -> None:
    rng = np.random.default_rng(3)
    phi, moment = rng.normal(size=3), rng.normal(size=3) * 1000
    phi *= angle / np.linalg.norm(phi)
    got = numbers(generalised_moment(dm(phi), dm(moment))).ravel()
    for k in range(3):
        d = 1e-6 * np.eye(3)[k]
        turn = Rotation.from_rotvec(phi + d) * Rotation.from_rotvec(phi - d).inv()
        assert got[k] == pytest.approx(moment @ turn.as_rotvec() / 2e-6, abs=2e-6)


# ---------------------------------------------------------------------------------- torques of all loads


@pytest.mark.parametrize("mount", MOUNTS)
@pytest.mark.parametrize("name", arms.NAMES)
def test_gravity_torque_is_pinocchios(name: str, mount: str) -> None:
    arm = arms.robot(name)
    assert arm.mass is not None
    gravity = np.array(MOUNTS[mount])
    statics = Statics(arm, [SPRING])
    q = ca.SX.sym("q", 6)
    values = {"joint-stiffness": {"k_nm_per_rad": dm(arms.STIFFNESS)}}
    x = ca.SX.zeros(6)
    _, tau = statics.law(
        statics.posture(q, x),
        q,
        weights=statics.loads_of_weight(dm(gravity)),
        loads=(),
        state=ca.SX(0, 1),
        values=values,
    )
    torque = ca.Function("tau", [q], [ca.densify(tau)])
    for posture in np.random.default_rng(4).uniform(-3, 3, (40, 6)):
        expected = arm.gravity_torque(posture, gravity)
        np.testing.assert_allclose(np.array(torque(posture)).ravel(), expected, atol=1e-9)
    assert np.abs(expected).max() > 10


@pytest.mark.parametrize("name", arms.NAMES)
def test_masses_are_where_the_robot_says(name: str) -> None:
    """Random masses and centres, a tool among them, against Pinocchio's derivative of potential energy."""
    rng = np.random.default_rng(5)
    arm = replace(arms.robot(name), mass=rng.uniform(1, 300, 6), com=rng.uniform(-0.5, 0.5, (6, 3)))
    heavier = arm.mass.copy(), arm.com.copy()
    heavier[0][5] += 40.0
    heavier[1][5] = (arm.mass[5] * arm.com[5] + 40.0 * np.array([0.1, 0.2, -0.3])) / heavier[0][5]
    one_body = replace(arm, mass=heavier[0], com=heavier[1])
    for q in rng.uniform(-3, 3, (10, 6)):
        eq = solved(
            Statics(arm, [SPRING]),
            q,
            {"joint-stiffness": {"k_nm_per_rad": np.full(6, 1e12)}},
            [],
            arms.GRAVITY,
            [(6, 40.0, np.array([0.1, 0.2, -0.3]))],
            complementary=False,
        )
        np.testing.assert_allclose(numbers(eq.torque).ravel(), one_body.gravity_torque(q), atol=1e-9)


@pytest.mark.parametrize("name", arms.NAMES)
def test_wrench_torque_is_pinocchios_jacobian_transposed(name: str) -> None:
    arm = arms.robot(name)
    rng = np.random.default_rng(6)
    for q in rng.uniform(-3, 3, (10, 6)):
        w, lever = rng.normal(size=6) * 1e3, rng.uniform(-0.4, 0.4, 3)
        eq = solved(
            Statics(arm, [SPRING]),
            q,
            {"joint-stiffness": {"k_nm_per_rad": np.full(6, 1e12)}},
            [Push(6, lever, w)],
            np.zeros(3),
            complementary=False,
        )
        arm_of_force = arm.pose(q)[:3, :3] @ lever
        about_flange = np.r_[w[:3], w[3:] + np.cross(arm_of_force, w[:3])]
        np.testing.assert_allclose(numbers(eq.torque).ravel(), arm.jacobian(q).T @ about_flange, atol=1e-9)


@pytest.mark.parametrize("link", range(7))
def test_a_load_on_an_inner_link_works_on_the_joints_inward_of_it(link: int) -> None:
    arm = arms.robot()
    rng = np.random.default_rng(7 + link)
    q, point, w = arms.postures(arm, 1, link)[0], rng.uniform(-0.5, 0.5, 3), rng.normal(size=6) * 500
    eq = solved(
        Statics(arm, [SPRING]),
        q,
        {"joint-stiffness": {"k_nm_per_rad": np.full(6, 1e12)}},
        [Push(link, point, w)],
        np.zeros(3),
        complementary=False,
    )
    plain = ElasticArm(arm, lambda tau, a: tau / 1e12)
    weightless = replace(plain, gravity=np.zeros(3))
    expected = weightless.generalised(q, np.zeros(6), [Push(link, point, w)])
    got = numbers(eq.torque).ravel()
    np.testing.assert_allclose(got, expected, atol=1e-8)
    assert np.all(got[link:] == 0)
    assert np.all(np.abs(got[:link]) > 1e-3)


# ------------------------------------------------------------------------------------------- equilibrium


def test_equilibrium_is_newtons_on_pinocchio() -> None:
    """K (q_act - q_cmd) = J(q_act)^T W + g(q_act) under 4 kN on a soft arm: K_c is in it."""
    arm, stiffness = arms.robot(), arms.STIFFNESS / 2
    for k, q in enumerate(arms.postures(arm, 6, 8)):
        w = arms.wrenches(1, 4000.0, k)[0]

        def out_of_balance(dq: Floats, q: Floats = q, w: Floats = w) -> Floats:
            now = q + dq
            return np.asarray(dq - (arm.jacobian(now).T @ w + arm.gravity_torque(now)) / stiffness)

        dq = root(out_of_balance, np.zeros(6), tol=1e-15).x
        assert np.abs(out_of_balance(dq)).max() < 1e-13
        eq = solved(
            Statics(arm, [SPRING]),
            q,
            {"joint-stiffness": {"k_nm_per_rad": stiffness}},
            [Push(6, np.zeros(3), w)],
            arms.GRAVITY,
        )
        np.testing.assert_allclose(numbers(eq.x).ravel(), dq, atol=1e-13)
        flange = eq.posture.links[-1]
        np.testing.assert_allclose(numbers(flange.origin).ravel(), arm.pose(q + dq)[:3, 3], atol=1e-12)
        np.testing.assert_allclose(numbers(flange.rotation), arm.pose(q + dq)[:3, :3], atol=1e-12)
        linear = (arm.jacobian(q).T @ w + arm.gravity_torque(q)) / stiffness
        assert np.abs(dq - linear).max() > 1e-5  # the test can tell K_c from none


def test_without_complementary_stiffness_it_is_the_linear_prediction() -> None:
    arm = arms.robot()
    for k, q in enumerate(arms.postures(arm, 5, 9)):
        w = arms.wrenches(1, 3000.0, k)[0]
        eq = solved(
            Statics(arm, [SPRING]),
            q,
            {"joint-stiffness": {"k_nm_per_rad": arms.STIFFNESS}},
            [Push(6, np.zeros(3), w)],
            np.zeros(3),
            complementary=False,
        )
        dq = arm.jacobian(q).T @ w / arms.STIFFNESS
        np.testing.assert_allclose(numbers(eq.x).ravel(), dq, rtol=1e-12, atol=1e-16)
        moved = numbers(eq.posture.links[-1].origin).ravel() - arm.pose(q)[:3, 3]
        linear = (arm.jacobian(q) @ dq)[:3]
        np.testing.assert_allclose(moved, linear, atol=2 * np.abs(dq).sum() ** 2 * 3)
        assert np.linalg.norm(moved) > 1e-3


def test_cartesian_stiffness_is_that_of_chen_and_kao() -> None:
    """K_x = J^-T (K - K_c) J^-1, K_c = d(J^T W)/dq, for a force on top of a large one."""
    arm = arms.robot()
    statics = Statics(arm, [SPRING])
    values = {"joint-stiffness": {"k_nm_per_rad": dm(arms.STIFFNESS)}}
    angles, wrench = ca.SX.sym("q", 6), ca.SX.sym("w", 6)
    eq = statics.equilibrium(
        angles,
        ca.SX.zeros(6),
        weights=[],
        loads=[Load(6, ca.SX.zeros(3), wrench)],
        state=ca.SX(0, 1),
        values=values,
        sweeps=20,
    )
    flange = ca.Function("flange", [angles, wrench], [eq.posture.links[6].origin, eq.posture.links[6].rotation, eq.x])
    for k, q in enumerate(arms.postures(arm, 4, 10)):
        w = np.r_[arms.wrenches(1, 5000.0, k)[0][:3], 0, 0, 0]

        def at(more: Floats, q: Floats = q, w: Floats = w) -> tuple[Floats, Floats, Floats]:
            p, r, dq = (np.array(v) for v in flange(q, w + more))
            return p.ravel(), r, dq.ravel()

        _, _, dq = at(np.zeros(6))
        actual, h = q + dq, 1e-6
        kc = np.array(
            [(arm.jacobian(actual + h * e).T @ w - arm.jacobian(actual - h * e).T @ w) / (2 * h) for e in np.eye(6)]
        ).T
        inverse = np.linalg.inv(arm.jacobian(actual))
        stiffness = inverse.T @ (np.diag(arms.STIFFNESS) - kc) @ inverse
        compliance = np.empty((6, 6))
        for i, e in enumerate(np.eye(6)):
            size = 10.0 if i < 3 else 3.0
            (p1, r1, _), (p0, r0, _) = at(size * e), at(-size * e)
            compliance[:, i] = np.r_[p1 - p0, Rotation.from_matrix(r1 @ r0.T).as_rotvec()] / (2 * size)
        np.testing.assert_allclose(compliance @ stiffness, np.eye(6), atol=2e-5)
        without = inverse.T @ np.diag(arms.STIFFNESS) @ inverse
        assert np.abs(compliance @ without - np.eye(6)).max() > 1e-3


@pytest.mark.parametrize("places", [(6,), (0,), (3,), (0, 2, 6)])
def test_places_that_yield_are_in_balance_by_virtual_work(places: tuple[int, ...]) -> None:
    arm = arms.robot()
    for k, q in enumerate(arms.postures(arm, 1, 11 + len(places))):
        c = random_compliance(k, 3.0)
        lever, w = np.array([0.1, -0.05, 0.3]), arms.wrenches(1, 3000.0, k)[0]
        pushes = [Push(6, lever, w), Push(3, np.array([0.2, 0.1, 0.0]), np.r_[300.0, -200, 500, 20, 10, -30])]
        oracle = ElasticArm(
            arm, lambda tau, a: tau / arms.STIFFNESS, dict.fromkeys(places, c), ((6, 35.0, np.array([0, 0.05, 0.1])),)
        )
        x, force = oracle.solve(q, pushes)
        eq = solved(
            Statics(arm, [SPRING, six_dof(places)]),
            q,
            {"joint-stiffness": {"k_nm_per_rad": arms.STIFFNESS}, "six-dof": {"c": c.ravel()}},
            pushes,
            arms.GRAVITY,
            [(6, 35.0, np.array([0, 0.05, 0.1]))],
        )
        np.testing.assert_allclose(numbers(eq.x).ravel(), x, atol=1e-12)
        np.testing.assert_allclose(numbers(eq.torque).ravel(), force[:6], atol=1e-7)
        for link, frame in enumerate(oracle.links(q, x)):
            reflector = np.array([0.2, -0.3, 0.15])
            expected = frame[:3, :3] @ reflector + frame[:3, 3]
            np.testing.assert_allclose(numbers(eq.posture.links[link].at(dm(reflector))).ravel(), expected, atol=4e-12)
        assert np.abs(x[6:]).max() > 1e-4


def test_a_reflector_on_an_inner_link_feels_only_what_is_inward_of_it() -> None:
    arm = arms.robot()
    q, w = arms.postures(arm, 1, 20)[0], np.array([800.0, -500.0, 300.0, 0, 0, 0])
    values = {"joint-stiffness": {"k_nm_per_rad": arms.STIFFNESS}}
    stiffer = {"joint-stiffness": {"k_nm_per_rad": np.r_[arms.STIFFNESS[:3], 1e12, 1e12, 1e12]}}
    reflector = dm([0.1, 0.4, -0.2])
    a = solved(Statics(arm, [SPRING]), q, values, [Push(6, np.zeros(3), w)], np.zeros(3), complementary=False)
    b = solved(Statics(arm, [SPRING]), q, stiffer, [Push(6, np.zeros(3), w)], np.zeros(3), complementary=False)
    np.testing.assert_allclose(
        numbers(a.posture.links[3].at(reflector)), numbers(b.posture.links[3].at(reflector)), atol=1e-15
    )
    still = solved(Statics(arm, [SPRING]), q, values, [], np.zeros(3))
    moved = np.linalg.norm(numbers(a.posture.links[3].at(reflector)) - numbers(still.posture.links[3].at(reflector)))
    tip = np.linalg.norm(numbers(a.posture.links[6].origin) - numbers(b.posture.links[6].origin))
    assert moved > 1e-5 and tip > 1e-5


def test_internal_springs_and_undeclared_masses() -> None:
    """The torque slot at the angles of the links, the mass slot inward of its link."""
    arm = arms.robot()
    compensator = Effect(
        name="compensator",
        cause="test",
        scope="robot",
        parameters=(Parameter(name="k", unit="N*m/rad", size=1, start=0, low=0, high=1e6, scale=1, meaning="test"),),
        site_kind="joint-2",
        torque=lambda angle, p: ca.vertcat(0, -p["k"] * ca.sin(angle[1]), ca.SX.zeros(4)),
        needs_torque_sign=True,
    )
    load = Effect(
        name="load",
        cause="test",
        scope="tool",
        parameters=(Parameter(name="m", unit="kg", size=1, start=0, low=0, high=1e3, scale=1, meaning="test"),),
        site_kind="tool",
        mass=lambda n, p: (PointMass(n, p["m"], dm([0.1, 0, 0.2])), PointMass(3, 2 * p["m"], dm([0, 0.3, 0]))),
    )
    values = {
        "joint-stiffness": {"k_nm_per_rad": arms.STIFFNESS},
        "compensator": {"k": np.array([2e4])},
        "load": {"m": np.array([25.0])},
    }
    oracle = ElasticArm(
        arm,
        lambda tau, a: tau / arms.STIFFNESS,
        masses=((6, 25.0, np.array([0.1, 0, 0.2])), (3, 50.0, np.array([0, 0.3, 0.0]))),
        spring=lambda angle: np.array([0, -2e4 * np.sin(angle[1]), 0, 0, 0, 0]),
    )
    for q in arms.postures(arm, 3, 21):
        x, _ = oracle.solve(q, [])
        eq = solved(Statics(arm, [SPRING, compensator, load]), q, values, [], arms.GRAVITY)
        np.testing.assert_allclose(numbers(eq.x).ravel(), x, atol=1e-12)


def test_softening_knows_the_base_spring_whatever_the_order_of_effects() -> None:
    arm, soft = arms.robot(), BY_NAME["preload-softening"]
    ratio = {"ratio": dm(np.full(6, 0.7))}
    values = {"joint-stiffness": {"k_nm_per_rad": dm(arms.STIFFNESS)}, "preload-softening": ratio}
    tau, q, state = dm(np.linspace(-800, 900, 6)), dm(np.zeros(6)), dm([1, -1, 1, -1, 1, -1])
    one, other = (
        numbers(Statics(arm, e).joint_deflection(tau, q, state, values)).ravel()
        for e in ([SPRING, soft], [soft, SPRING])
    )
    np.testing.assert_array_equal(one, other)
    torque = np.linspace(-800, 900, 6)
    against = torque * np.array([1, -1, 1, -1, 1, -1]) < 0
    np.testing.assert_allclose(one, torque / (arms.STIFFNESS * np.where(against, 0.7, 1.0)), rtol=1e-14)
    assert against.any() and not against.all()


def test_temperature_reaches_every_law() -> None:
    arm = arms.robot()
    growth = Effect(
        name="growth",
        cause="test",
        scope="robot",
        parameters=(Parameter(name="a", unit="m/K", size=1, start=0, low=-1, high=1, scale=1, meaning="test"),),
        site_kind="arm",
        joint=lambda given, p: 2 * p["a"] * given.temperature * ca.SX.ones(6),
        place=lambda given, p: ca.vertcat(p["a"] * given.temperature * given.place, ca.SX.zeros(5)),
        places=lambda n: (1, n),
    )
    values = {"joint-stiffness": {"k_nm_per_rad": dm(arms.STIFFNESS)}, "growth": {"a": dm([1e-5])}}
    statics = Statics(arm, [SPRING, growth])
    eq = statics.equilibrium(
        dm(np.full(6, 0.3)), ca.SX.zeros(18), weights=[], loads=[], state=ca.SX(0, 1), values=values, temperature=12.0
    )
    expected = np.r_[np.full(6, 2.4e-4), 1.2e-4, np.zeros(5), 7.2e-4, np.zeros(5)]
    np.testing.assert_allclose(numbers(eq.x).ravel(), expected, atol=1e-18)


def test_residual_says_how_far_the_sweeps_have_come() -> None:
    arm = arms.robot()
    q, w = arms.postures(arm, 1, 22)[0], arms.wrenches(1, 2000.0)[0]
    values = {"joint-stiffness": {"k_nm_per_rad": arms.STIFFNESS}}
    x = [
        numbers(solved(Statics(arm, [SPRING]), q, values, [Push(6, np.zeros(3), w)], arms.GRAVITY, sweeps=k).x).ravel()
        for k in (2, 3, 30)
    ]
    third = solved(Statics(arm, [SPRING]), q, values, [Push(6, np.zeros(3), w)], arms.GRAVITY, sweeps=3)
    assert numbers(third.residual).item() == pytest.approx(np.abs(x[1] - x[0]).max(), rel=1e-9)
    assert np.abs(x[1] - x[2]).max() < 0.1 * np.abs(x[0] - x[2]).max()
