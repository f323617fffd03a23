"""Built-in robots: against Pinocchio, against published figures, against independent arithmetic."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from importlib.resources import files
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from stiffness.errors import RobotError
from stiffness.numerics.kernel import Kernel
from stiffness.robot.load import builtin_robots, load_robot
from stiffness.robot.robot import Robot

NAMES = ("abb-irb6600-175-255", "kuka-kr210-r2700", "kuka-kr240-class", "kuka-kr500", "ur10")
UPRIGHT = np.radians([0.0, -90, 90, 0, 0, 0])  # KUKA: lower arm up, forearm level


def random_postures(count: int, seed: int = 1) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-np.pi, np.pi, (count, 6))


def symbolic_poses(robot: Robot, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rotations and origins by the CasADi chain."""
    x = ca.SX.sym("q", 6)
    rotation, origin = robot.flange_symbolic(x)
    f = Kernel(ca.Function("f", [x], [ca.densify(ca.vec(rotation.T)), ca.densify(origin)]))
    r, p = f.run(q)
    return r.reshape(-1, 3, 3), p


def angles_between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """rad; exact for small angles, where arccos of the trace is not."""
    turn = a.swapaxes(1, 2) @ b
    return np.linalg.norm(turn - turn.swapaxes(1, 2), axis=(1, 2)) / np.sqrt(8)


def dh_links(name: str, q: np.ndarray) -> tuple[list[np.ndarray], list[tuple[float, np.ndarray]]]:
    """Link frames and (mass, com) straight from the file, each row multiplied out by hand."""
    table = tomllib.loads((files("stiffness") / "robot" / "data" / f"{name}.toml").read_text())
    frame, links, bodies = np.eye(4), [], []
    for row, angle in zip(table["joints"], q, strict=True):
        t = np.radians(row["offset"]) + row.get("sign", 1) * angle
        al, a, d = np.radians(row["alpha"]), row["a"] / 1e3, row["d"] / 1e3
        c, s, ca_, sa = np.cos(t), np.sin(t), np.cos(al), np.sin(al)
        step = [[c, -s * ca_, s * sa, a * c], [s, c * ca_, -c * sa, a * s], [0, sa, ca_, d], [0, 0, 0, 1]]
        frame = frame @ np.array(step)
        links.append(frame)
        bodies.append((row["mass"], np.array(row["com"]) / 1e3))
    return links, bodies


def test_the_list() -> None:
    assert builtin_robots() == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_casadi_equals_pinocchio(name: str) -> None:
    robot, q = load_robot(name), random_postures(1000)
    r, p = symbolic_poses(robot, q)
    poses = np.array([robot.pose(row) for row in q])
    assert np.abs(p - poses[:, :3, 3]).max() < 1e-12
    assert angles_between(r, poses[:, :3, :3]).max() < 1e-12


@pytest.mark.parametrize("name", NAMES)
def test_pose_is_the_product_of_the_rows(name: str) -> None:
    robot = load_robot(name)
    for q in random_postures(50, seed=2):
        np.testing.assert_allclose(robot.pose(q), dh_links(name, q)[0][-1], atol=1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_jacobian_is_the_derivative_of_the_pose(name: str) -> None:
    robot, h = load_robot(name), 1e-6
    for q in random_postures(10, seed=3):
        jacobian, here = robot.jacobian(q), robot.pose(q)
        for k in range(6):
            step = h * np.eye(6)[k]
            rate = (robot.pose(q + step) - robot.pose(q - step)) / (2 * h)
            np.testing.assert_allclose(jacobian[:3, k], rate[:3, 3], atol=1e-8)
            spin = rate[:3, :3] @ here[:3, :3].T
            np.testing.assert_allclose(jacobian[3:, k], [spin[2, 1], spin[0, 2], spin[1, 0]], atol=1e-8)


@pytest.mark.parametrize("name", NAMES)
def test_gravity_torque_is_what_the_weights_do(name: str) -> None:
    """Against the slope of the potential energy, in a tilted field, from the file alone."""
    robot, h, field = load_robot(name), 1e-5, np.array([1.7, -3.1, -8.9])

    def energy(q: np.ndarray) -> float:
        links, bodies = dh_links(name, q)
        return -sum(m * field @ (t[:3, :3] @ c + t[:3, 3]) for t, (m, c) in zip(links, bodies, strict=True))

    for q in random_postures(10, seed=4):
        slope = [(energy(q + h * e) - energy(q - h * e)) / (2 * h) for e in np.eye(6)]
        torque = robot.gravity_torque(q, field)
        np.testing.assert_allclose(torque, -np.array(slope), rtol=1e-6, atol=1e-5)
        assert np.abs(torque).max() > 1  # N*m: away from zero


def test_irb6600_home_points_forward() -> None:
    """x = 320 + 1142 + 200, z = 780 + 1075 + 200 mm; ABB's tool0: z forward, x down."""
    home = load_robot("abb-irb6600-175-255").pose(np.zeros(6))
    np.testing.assert_allclose(home[:3, 3], [1.662, 0, 2.055], atol=1e-12)
    np.testing.assert_allclose(home[:3, :3], [[0, 0, 1], [0, 1, 0], [-1, 0, 0]], atol=1e-12)


def test_irb6600_isolates_joints_as_table_2_says() -> None:
    """Joint 4 is tested at q4 = 90, q5 = -90, q6 = 90 deg by a force along -z: it must have a lever there."""
    robot = load_robot("abb-irb6600-175-255", tip="paper")
    torque = robot.jacobian(np.radians([0, 0, 0, 90, -90, 90])).T @ [0, 0, -197, 0, 0, 0]
    assert abs(torque[3]) == pytest.approx(197 * 0.380, rel=1e-9)


def test_irb6600_is_its_sister(shared: Path) -> None:
    """The ROS-Industrial 225/2.55 has the same arm, and ABB's tool0 at its end."""
    sister = load_robot(str(shared / "data/robots/abb_irb6600_225_255.urdf"), tip="tool0")
    robot = load_robot("abb-irb6600-175-255")
    for q in random_postures(50, seed=5):
        np.testing.assert_allclose(robot.pose(q), sister.pose(q), atol=1e-11)
    np.testing.assert_allclose(robot.lower, sister.lower, atol=1e-6)
    np.testing.assert_allclose(robot.upper, sister.upper, atol=1e-6)


def test_kuka_reference_poses() -> None:
    """Zero stretches the arm forward; upright has the flange z forward and x down. Figures in mm by hand."""
    stretched = {"kuka-kr210-r2700": (330 + 1150 + 1220 + 215, 645 + 115), "kuka-kr500": (3115, 990)}
    for name, (x, z) in stretched.items():
        zero = load_robot(name).pose(np.zeros(6))
        np.testing.assert_allclose(zero[:3, 3], [x / 1e3, 0, z / 1e3], atol=1e-12)
    upright = load_robot("kuka-kr210-r2700").pose(UPRIGHT)
    np.testing.assert_allclose(upright[:3, 3], [1.765, 0, 1.910], atol=1e-12)
    np.testing.assert_allclose(upright[:3, :3], [[0, 0, 1], [0, 1, 0], [-1, 0, 0]], atol=1e-12)


def test_kuka_angles_count_as_kuka_counts() -> None:
    """A1 clockwise seen from above, A2 and A5 downwards; A3 downwards lowers the flange."""
    robot = load_robot("kuka-kr240-class")
    turned = robot.pose(np.radians([30.0, -90, 90, 0, 0, 0]))
    assert np.degrees(np.arctan2(turned[1, 3], turned[0, 3])) == pytest.approx(-30)
    for joint in (1, 2, 4):
        q = UPRIGHT.copy()
        q[joint] += 0.1
        assert robot.pose(q)[2, 3] < robot.pose(UPRIGHT)[2, 3] - 0.01


@pytest.mark.parametrize(
    ("name", "urdf"), [("kuka-kr210-r2700", "kuka_kr210_r2700_2"), ("ur10", "ur10_robot")]
)
def test_against_the_urdf_of_the_same_robot(name: str, urdf: str, shared: Path) -> None:
    robot, other = load_robot(name), load_robot(str(shared / f"data/robots/{urdf}.urdf"), tip="tool0")
    for q in random_postures(100, seed=6):
        np.testing.assert_allclose(robot.pose(q), other.pose(q), atol=1e-10)  # the URDF has 11 digits of pi
    if name.startswith("kuka"):
        np.testing.assert_allclose(robot.lower, other.lower, atol=1e-6)
        np.testing.assert_allclose(robot.upper, other.upper, atol=1e-6)
        np.testing.assert_allclose(robot.velocity, other.velocity, rtol=1e-3)


#: mm from the wrist centre (of the UR10 from axis 5) to the flange, and the reach: ABB's tool0 by ROS-Industrial and
#: the name of the arm; KUKA's drawings as kuka_robot_descriptions has them (215, 240) and as two models of the KR 500
#: R2830 have it (290); UR's table of DH parameters.
FLANGES = {
    "abb-irb6600-175-255": (200.0, 2550), "kuka-kr210-r2700": (215.0, 2701), "kuka-kr240-class": (240.0, 2701),
    "kuka-kr500": (290.0, 2826), "ur10": (92.2, 1300),
}  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_flange_and_reach_are_the_makers(name: str) -> None:
    """The reach is that of the wrist centre, and the chain gives it to half a per cent; UR counts otherwise."""
    robot = load_robot(name)
    flange, reach = FLANGES[name]
    last = robot.before[-1, :3, 3] + robot.before[-1, :3, :3] @ robot.after[-1, :3, 3]
    assert np.linalg.norm(last) * 1e3 == pytest.approx(flange, abs=1e-9)
    assert robot.reach == pytest.approx(reach / 1e3)
    if name != "ur10":
        lengths = [np.linalg.norm(robot.after[k, :3, 3] + robot.before[k + 1, :3, 3]) for k in (1, 2, 3)]
        ahead = np.linalg.norm(robot.after[0, :2, 3]) if name.startswith("abb") else abs(robot.after[0, 0, 3])
        assert ahead + lengths[0] + np.hypot(*lengths[1:]) == pytest.approx(reach / 1e3, rel=0.005)


def test_ur10_weighs_what_its_maker_says() -> None:
    """At zero the arm lies level along -x: levers of the five outer links about the shoulder, by hand."""
    robot = load_robot("ur10")
    far = 0.612 + 0.5723
    moment = 12.7 * (0.612 - 0.38) + 4.27 * (far - 0.24) + (2.0 + 2.0 + 0.365) * far
    assert robot.gravity_torque(np.zeros(6))[1] == pytest.approx(9.80665 * moment, rel=1e-3)
    assert robot.mass is not None
    assert robot.mass.sum() == pytest.approx(28.435)


def test_assumptions_are_told() -> None:
    assert any("1700 kg" in a for a in load_robot("abb-irb6600-175-255").assumptions)
    for name in NAMES:
        assert load_robot(name).sources


def test_arrays_are_read_only_and_repr_is_one_line() -> None:
    robot = load_robot("kuka-kr500")
    with pytest.raises(ValueError, match="read-only"):
        robot.before[0, 0, 0] = 2.0
    assert robot.mass is not None
    with pytest.raises(ValueError, match="read-only"):
        robot.mass[0] = 1.0
    assert repr(robot) == "Robot(kuka-kr500, 6 joints, base to flange, 1495 kg moving)"


def test_refusals() -> None:
    with pytest.raises(RobotError, match="abb-irb6600-175-255, kuka-kr210"):
        load_robot("kuka-kr999")
    with pytest.raises(RobotError, match=r"ur10 has no tip 'gripper'; it has flange"):
        load_robot("ur10", tip="gripper")
    assert load_robot("ur10", tip="tool0").tip == "flange"  # ROS's name of the one flange there is
    with pytest.raises(RobotError, match="6 finite joint angles"):
        load_robot("ur10").pose([0.0, 0, np.nan, 0, 0, 0])
    with pytest.raises(RobotError, match="6 finite joint angles"):
        load_robot("ur10").jacobian([0.0, 0, 0])


@pytest.mark.parametrize("part", ["before", "axis", "after"])
def test_same_kinematics(part: str) -> None:
    """The same arm read twice, or under another name; not one whose placement or axis differs by 1e-4."""
    robot = load_robot("ur10")
    assert robot.same_kinematics(replace(load_robot("ur10"), name="other", base="floor"))
    other = getattr(robot, part).copy()
    other[2].flat[-1] += 1e-4
    assert not robot.same_kinematics(replace(robot, **{part: other}))
    assert not robot.same_kinematics(load_robot("kuka-kr500"))
