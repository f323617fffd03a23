"""Effects of the catalogue in the whole chain: against Pinocchio, against rigid motions, against geometry."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial.transform import Rotation

from stiffness.effects import BUILT_IN, BY_NAME
from stiffness.effects.effect import PlaceInput
from stiffness.statics.load import Load
from stiffness.statics.predictor import Predictor
from stiffness.statics.statics import Equilibrium, Statics
from tests.oracles.effects import compliance
from tests.oracles.effects_joints import two_pins
from tests.oracles.effects_places import hinge
from tests.oracles.elastic_arm import ElasticArm, Push
from tests.stiffness import arms

Floats = npt.NDArray[np.float64]
Values = dict[str, dict[str, Floats]]
RIGID = {"joint-stiffness": {"k_nm_per_rad": np.full(6, 1e12)}}
SOFT = {"joint-stiffness": {"k_nm_per_rad": arms.STIFFNESS}}
STILL = np.zeros(3)
SPRING = {
    "linear_m_per_n": np.array([3e-8, 2e-8, 1e-8]),
    "angular_rad_per_nm": np.array([4e-8, 5e-8, 2e-8]),
    "coupling": np.array([0, 0, 0, 0, 1e-8, 0, -1e-8, 0, 0, 0, 0, 0, 0, 0, 1e-8]),
}


def sx(a: npt.ArrayLike) -> ca.SX:
    return ca.SX(ca.DM(np.asarray(a, dtype=float)))


def at_rest(
    values: Values,
    q: Floats,
    pushes: list[Push],
    gravity: Floats = STILL,
    name: str = arms.NAMES[0],
    temperature: float = 0.0,
) -> Equilibrium:
    """The arm with these effects in equilibrium, numbers all through."""
    statics = Statics(arms.robot(name), [BY_NAME[e] for e in values])
    p = {e: {k: sx(v) for k, v in own.items()} for e, own in values.items()}
    loads = [Load(push.link, sx(push.point), sx(push.wrench)) for push in pushes]
    start, state = ca.SX.zeros(statics.n_x), ca.SX.zeros(statics.n_state)
    weights = statics.loads_of_weight(sx(gravity), (), p)
    return statics.equilibrium(
        sx(q), start, weights=weights, loads=loads, state=state, values=p, sweeps=12, temperature=temperature
    )


def number(v: ca.SX) -> Floats:
    out = np.array(ca.evalf(ca.densify(v)))
    return out.ravel() if out.shape[1] == 1 else out


def frames(eq: Equilibrium) -> list[Floats]:
    """(4, 4) of links 0 ... n."""
    out = []
    for frame in eq.posture.links:
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = number(frame.rotation), number(frame.origin)
        out.append(pose)
    return out


# --------------------------------------------------------------------------------------- masses, springs


@pytest.mark.parametrize("name", arms.NAMES)
def test_payload_is_its_weight_through_pinocchios_jacobian(name: str) -> None:
    """tau = J^T m g with the Jacobian of the mass's centre, on top of the arm's own weight."""
    arm, kg, com = arms.robot(name), 17.0, np.array([0.15, -0.2, 0.3])
    payload = {"mass_kg": np.array([kg]), "com_m": com}
    for k, q in enumerate(arms.postures(arm, 5, 31)):
        gravity = Rotation.from_rotvec([0.3 * k, -0.2, 0.0]).as_matrix() @ arms.GRAVITY
        eq = at_rest({**RIGID, "payload": payload}, q, [], gravity, name)
        weight, lever = kg * gravity, arm.pose(q)[:3, :3] @ com
        about_flange = np.r_[weight, np.cross(lever, weight)]
        expected = arm.jacobian(q).T @ about_flange
        own = arm.gravity_torque(q, gravity)
        np.testing.assert_allclose(number(eq.torque) - own, expected, atol=2e-4)  # 1e12 N*m/rad still gives way
        assert np.abs(expected).max() > 5


def test_payload_loads_every_place_inward_of_it() -> None:
    """A base that yields feels its weight and its moment about the base."""
    q, kg, com = arms.postures(arms.robot(), 1, 32)[0], 40.0, np.array([0.1, 0.0, 0.2])
    payload = {"mass_kg": np.array([kg]), "com_m": com}
    with_, without = (
        number(at_rest({**RIGID, "base-compliance": SPRING, **more}, q, [], arms.GRAVITY).x)[6:]
        for more in ({"payload": payload}, {})
    )
    pose = arms.robot().pose(q)
    centre, weight = pose[:3, :3] @ com + pose[:3, 3], kg * arms.GRAVITY
    expected = compliance(SPRING) @ np.r_[weight, np.cross(centre, weight)]
    np.testing.assert_allclose(with_ - without, expected, atol=3e-3 * np.abs(expected).max())
    assert np.abs(expected).max() > 1e-5


def test_gravity_compensator_is_a_spring_between_two_pins_of_the_arm() -> None:
    """Pins on link 1 and link 2 carried along by Pinocchio's poses; minus the slope of the spring's energy."""
    arm, a, b, rate, relaxed = arms.robot(), 0.35, 0.5, 90e3, 0.45
    values = {
        "moment_nm": np.array([rate * a * b]),
        "eccentricity": np.array([2 * a * b / (a**2 + b**2)]),
        "free_length": np.array([relaxed / np.hypot(a, b)]),
        "angle_rad": np.array([0.4]),
    }
    across = np.cross(arm.axis[1], [1.0, 0.0, 0.0] if abs(arm.axis[1][0]) < 0.5 else [0.0, 1.0, 0.0])
    across /= np.linalg.norm(across)
    before = _point_before_joint(arm.before[1], Rotation.from_rotvec(0.4 * arm.axis[1]).as_matrix() @ across * a)

    def energy(q: Floats) -> float:
        on_link_1, on_link_2 = _link_frame(q, 1), _link_frame(q, 2)
        moving = np.linalg.inv(arm.after[1]) @ np.r_[across * b, 1.0]
        stretched = np.linalg.norm((on_link_1 @ np.r_[before, 1.0] - on_link_2 @ moving)[:3]) - relaxed
        return float(0.5 * rate * stretched**2)

    for q in arms.postures(arm, 5, 33):
        spring = number(at_rest({**RIGID, "gravity-compensator": values}, q, []).torque)
        h = 1e-5
        slope = [(energy(q + h * e) - energy(q - h * e)) / (2 * h) for e in np.eye(6)]
        np.testing.assert_allclose(spring, -np.array(slope), atol=1e-3)
        assert spring[1] == pytest.approx(two_pins(q[1] - 0.4, a, b, rate, relaxed), abs=1e-3)
        assert abs(spring[1]) > 10 and np.all(spring[[0, 2, 3, 4, 5]] == 0)


def _link_frame(q: Floats, link: int) -> Floats:
    """(4, 4) by products of the robot's own figures."""
    arm, pose = arms.robot(), np.eye(4)
    for k in range(link):
        turn = np.eye(4)
        turn[:3, :3] = Rotation.from_rotvec(arm.axis[k] * q[k]).as_matrix()
        pose = pose @ arm.before[k] @ turn @ arm.after[k]
    return pose


def _point_before_joint(before: Floats, point: Floats) -> Floats:
    """A point given in the axes of the joint at rest, in the frame of the link inward of it."""
    return np.asarray((before @ np.r_[point, 1.0])[:3])


def test_a_parallel_linkage_is_a_coupling_of_its_two_joints() -> None:
    """Joint 2 on a spring, the sum of joints 2 and 3 on another: K = [[k2 + k3, k3], [k3, k3]]."""
    k2, k3 = 1.6e6, 0.9e6
    inverse = np.linalg.inv(np.array([[k2 + k3, k3], [k3, k3]]))
    alone = arms.STIFFNESS.copy()
    alone[1:3] = 1 / np.diag(inverse)
    coupling = np.zeros(15)
    coupling[2] = -np.sqrt(k3 / (k2 + k3))
    arm, w = arms.robot(), Push(6, STILL, np.array([500.0, -900, 700, 30, 20, 10]))
    values: Values = {"joint-stiffness": {"k_nm_per_rad": alone}, "joint-coupling": {"coupling": coupling}}

    def linkage(torque: Floats, angle: Floats) -> Floats:
        dq = torque / alone
        dq[1:3] = inverse @ torque[1:3]
        return dq

    for q in arms.postures(arm, 2, 34):
        x, _ = ElasticArm(arm, linkage).solve(q, [w])
        np.testing.assert_allclose(number(at_rest(values, q, [w], arms.GRAVITY).x), x, atol=1e-12)
        plain = number(at_rest({"joint-stiffness": {"k_nm_per_rad": alone}}, q, [w], arms.GRAVITY).x)
        assert np.abs(x - plain)[1:3].min() > 1e-6 and np.abs(x - plain)[[0, 3, 4, 5]].max() < 2e-5


# ------------------------------------------------------------------------------------ places that yield


def test_a_base_that_yields_moves_the_whole_arm_as_one_body() -> None:
    """Every link by one and the same rigid motion: that of the spring under the wrench about the base."""
    arm, w = arms.robot(), np.array([800.0, -600, 1500, 40, -60, 80])
    for q in arms.postures(arm, 3, 35):
        push = [Push(6, np.array([0.1, 0.2, 0.3]), w)]
        rigid, yielded = (frames(at_rest({**RIGID, **more}, q, push)) for more in ({}, {"base-compliance": SPRING}))
        motion = [b @ np.linalg.inv(a) for a, b in zip(rigid, yielded, strict=True)]
        for one in motion[1:]:
            np.testing.assert_allclose(one, motion[0], atol=1e-12)
        where = (rigid[6] @ np.array([0.1, 0.2, 0.3, 1.0]))[:3]
        expected = compliance(SPRING) @ np.r_[w[:3], w[3:] + np.cross(where, w[:3])]
        turned = Rotation.from_matrix(motion[0][:3, :3]).as_rotvec()
        np.testing.assert_allclose(np.r_[motion[0][:3, 3], turned], expected, atol=2e-3 * np.abs(expected).max())
        assert np.abs(expected[3:]).max() > 1e-5


@pytest.mark.parametrize("link", range(1, 6))
def test_a_link_bends_about_a_hinge_on_it(link: int) -> None:
    """What is inward stands still, what is outward turns about the hinge; the hinge is part of the link."""
    arm, share, w = arms.robot(), 0.3, np.array([700.0, 900, -1200, 50, -70, 90])
    angular = np.array([3e-7, 2e-7, 4e-7])
    values = {f"r{axis}_rad_per_nm": np.where(np.arange(6) == link - 1, angular[k], 0) for k, axis in enumerate("xyz")}
    values["at"] = np.full(6, share)
    q = arms.postures(arm, 1, 36 + link)[0]
    push = [Push(6, np.array([0.1, 0.0, 0.2]), w)]
    rigid, bent = (frames(at_rest({**RIGID, **more}, q, push)) for more in ({}, {"link-compliance": values}))
    for inward in range(link):
        np.testing.assert_allclose(bent[inward], rigid[inward], atol=1e-9)
    motion = [bent[k] @ np.linalg.inv(rigid[k]) for k in range(link, 7)]
    for one in motion[1:]:
        np.testing.assert_allclose(one, motion[0], atol=1e-8)
    joint, next_joint = (_joint(rigid, k) for k in (link - 1, link))
    centre = joint + share * (next_joint - joint)
    moment = w[3:] + np.cross((rigid[6] @ np.array([0.1, 0.0, 0.2, 1.0]))[:3] - centre, w[:3])
    axes = rigid[link][:3, :3]
    phi = axes @ (angular * (axes.T @ moment))
    turned = Rotation.from_matrix(motion[0][:3, :3]).as_rotvec()
    np.testing.assert_allclose(turned, phi, atol=5e-3 * np.abs(phi).max())
    assert np.abs(phi).max() > 5e-5
    moved = (motion[0] @ np.r_[centre, 1.0])[:3] - centre
    assert np.linalg.norm(moved) < 2 * np.linalg.norm(phi) ** 2 * (1 + np.linalg.norm(centre))
    far = next_joint + np.array([0.3, 0.4, 0.5])
    np.testing.assert_allclose(
        (motion[0] @ np.r_[far, 1.0])[:3] - far, np.cross(phi, far - centre), atol=5e-3 * np.linalg.norm(phi)
    )


def _joint(links: list[Floats], k: int) -> Floats:
    """Where joint k (from 0) stands, from the frame of the link inward of it."""
    return np.asarray((links[k] @ arms.robot().before[k])[:3, 3])


def test_bending_links_are_in_balance_by_virtual_work() -> None:
    arm, rng = arms.robot(), np.random.default_rng(37)
    values = {f"r{axis}_rad_per_nm": rng.uniform(5e-8, 3e-7, 6) for axis in "xyz"}
    values["at"] = rng.uniform(0, 1, 6)
    matrices = {}
    for k in range(1, 6):
        inner = -arm.after[k - 1][:3, :3].T @ arm.after[k - 1][:3, 3]
        outer = arm.before[k][:3, 3]
        middle = inner + values["at"][k - 1] * (outer - inner)
        matrices[k] = hinge(np.array([values[f"r{axis}_rad_per_nm"][k - 1] for axis in "xyz"]), middle)
    oracle = ElasticArm(arm, lambda tau, a: tau / arms.STIFFNESS, matrices)
    q, push = arms.postures(arm, 1, 37)[0], [Push(6, np.array([0.0, 0.1, 0.3]), np.array([900.0, -700, 1100, 0, 0, 0]))]
    x, _ = oracle.solve(q, push)
    np.testing.assert_allclose(
        number(at_rest({**SOFT, "link-compliance": values}, q, push, arms.GRAVITY).x), x, atol=1e-12
    )
    assert np.abs(x[6:]).max() > 1e-4


@pytest.mark.parametrize("end", ["force", "moment"])
def test_a_hinge_stands_for_a_cantilever(end: str) -> None:
    """Beam tables: F L^3/3EI and F L^2/2EI at s = 1/3, M L^2/2EI and M L/EI at s = 1/2."""
    length, ei = 1.2, 4e5
    share, softness = (1 / 3, 0.75 * length / ei) if end == "force" else (1 / 2, length / ei)
    load = 300.0
    w = np.r_[0, load, 0, 0, 0, 0] if end == "force" else np.r_[0, 0, 0, 0, 0, load]
    # the link along x, its frame at the outer end
    given = PlaceInput(1, sx(w), ca.SX(0), np.array([-length, 0, 0]), np.zeros(3))
    own = {"rx_rad_per_nm": [0.0], "ry_rad_per_nm": [0.0], "rz_rad_per_nm": [softness], "at": [share]}
    effect = BY_NAME["link-compliance"]
    if effect.place is None:
        raise TypeError("no law of a place")
    displacement = number(effect.place(given, {k: sx(v) for k, v in own.items()}))
    table = (load * length**3 / (3 * ei), load * length**2 / (2 * ei))
    table = table if end == "force" else (load * length**2 / (2 * ei), load * length / ei)
    np.testing.assert_allclose(displacement, [0, table[0], 0, 0, 0, table[1]], rtol=1e-12, atol=1e-18)


# --------------------------------------------------------------------------------------------- heat


@pytest.mark.parametrize("name", arms.NAMES)
def test_a_warm_arm_is_a_longer_arm(name: str) -> None:
    """Every length of the robot's figures times 1 + a dT, zeros moved: Pinocchio's pose of that robot."""
    arm, rng, warm = arms.robot(name), np.random.default_rng(38), 14.0
    growth, zero = rng.uniform(-3e-5, 3e-5, 7), rng.uniform(-1e-5, 1e-5, 6)
    before, after = arm.before.copy(), arm.after.copy()
    for k in range(6):
        before[k][:3, 3] *= 1 + growth[k] * warm
        after[k][:3, 3] *= 1 + growth[k + 1] * warm
    longer = replace(arm, before=before, after=after)
    values = {**RIGID, "thermal-drift": {"expansion_per_k": growth, "zero_rad_per_k": zero}}
    for q in arms.postures(arm, 4, 38):
        flange = frames(at_rest(values, q, [], name=name, temperature=warm))[6]
        np.testing.assert_allclose(flange, longer.pose(q + zero * warm), atol=1e-12)
        assert np.abs(flange - arm.pose(q)).max() > 1e-4
        cold = frames(at_rest(values, q, [], name=name))[6]
        np.testing.assert_allclose(cold, arm.pose(q), atol=1e-12)


# ------------------------------------------------------------------------------------ there and back

CHAIN: Values = {
    **SOFT,
    "joint-friction": {"friction_nm": np.array([60.0, 60, 50, 12, 8, 5]), "lag": np.ones(6), "held": np.full(6, 0.8)},
    "joint-coupling": {"coupling": np.r_[0, 0, -0.4, np.zeros(11), 0.3]},
    "posture-stiffness": {
        "softer": np.full(6, 0.3),
        "stiffest_rad": np.linspace(-1, 1, 6),
        "cos2": np.full(6, 0.1),
        "sin2": np.full(6, -0.1),
        "cos3": np.full(6, 0.05),
        "sin3": np.full(6, 0.04),
    },
    "gravity-compensator": {
        "moment_nm": np.array([2e4]),
        "angle_rad": np.array([0.3]),
        "free_length": np.array([0.5]),
        "eccentricity": np.array([0.6]),
    },
    "payload": {"mass_kg": np.array([20.0]), "com_m": np.array([0.1, 0.0, 0.2])},
    "base-compliance": SPRING,
    "link-compliance": {**{f"r{a}_rad_per_nm": np.full(6, 8e-8) for a in "xyz"}, "at": np.full(6, 0.4)},
    "thermal-drift": {"expansion_per_k": np.full(7, 1.2e-5), "zero_rad_per_k": np.full(6, 2e-6)},
}


@pytest.mark.parametrize("calibrated_out", [False, True])
@pytest.mark.parametrize("only", [*(e for e in CHAIN if e != "joint-stiffness"), "all"])
def test_command_then_forward_is_the_wanted_pose(only: str, calibrated_out: bool) -> None:
    names = list(CHAIN) if only == "all" else ["joint-stiffness", only]
    arm, warm = arms.robot(), 11.0
    model = Predictor(
        arm,
        [BY_NAME[e] for e in names],
        CHAIN,
        arms.tool(),
        gravity=arms.GRAVITY,
        calibrated_out=calibrated_out,
        temperature=warm,
    )
    q, w = arms.postures(arm, 25, 39), arms.wrenches(25, 1500.0, 39)
    half = CHAIN["joint-friction"]["friction_nm"]
    m = model.statics.n_state
    state = np.random.default_rng(39).uniform(-1, 1, (25, m)) * np.resize(half, m)
    wanted = model.nominal(q)
    command = model.command(wanted, w, state, q)
    assert command.converged.all()
    got = model.forward(command.q, w, state)
    np.testing.assert_allclose(got.position, wanted.origin, atol=1e-9)
    np.testing.assert_allclose(got.rotation, wanted.rotation, atol=1e-9)
    plain = arms.predictor(calibrated_out=calibrated_out).forward(command.q, w, np.zeros(0))
    assert np.linalg.norm(plain.position - got.position, axis=1).max() > 3e-5


@pytest.mark.parametrize("calibrated_out", [False, True])
def test_the_whole_catalogue_at_neutral_values_changes_nothing(calibrated_out: bool) -> None:
    arm = arms.robot()
    every = [e for e in BUILT_IN if e.scope != "instruments"]
    values = {e.name: e.neutral(6) for e in every} | SOFT
    values["kinematic-offset"] = BY_NAME["kinematic-offset"].neutral(6)
    options = {"gravity": arms.GRAVITY, "calibrated_out": calibrated_out, "temperature": 25.0}
    whole = Predictor(arm, every, values, arms.tool(), **options)  # type: ignore[arg-type]
    plain = Predictor(arm, [BY_NAME["joint-stiffness"]], SOFT, arms.tool(), **options)  # type: ignore[arg-type]
    q, w = arms.postures(arm, 10, 40), arms.wrenches(10, 2000.0, 40)
    state = np.zeros((10, whole.statics.n_state))
    directions = slice(0, 6)  # of preload-softening, the first that remembers: any of them is neutral
    state[:, directions] = np.random.default_rng(40).choice([-1.0, 1.0], (10, 6))
    got, expected = whole.forward(q, w, state), plain.forward(q, w, np.zeros(0))
    np.testing.assert_allclose(got.position, expected.position, atol=1e-12)
    np.testing.assert_allclose(got.rotation, expected.rotation, atol=1e-12)
    np.testing.assert_allclose(got.torque, expected.torque, atol=1e-7)
    assert whole.statics.n_x == 6 + 7 * 6 and whole.statics.n_state == 36
