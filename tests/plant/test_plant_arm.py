"""The plant's own kinematics and gravity against Pinocchio and hand formulas."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from . import Arm, Scene, Tool, small_arms
from .geometry import between, placement, pose_error, rigid_inverse, rotation_vector, turn

UNDER_TEST = {"stiffness", "compensator", "toolpaths"}


def test_shares_nothing_with_the_packages_under_test() -> None:
    files = sorted(Path(__file__).parent.glob("*.py"))
    assert len(files) > 6
    for file in files:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and node.level == 0:
                names = [node.module or ""]
            if isinstance(node, ast.ImportFrom):
                assert node.level < 2, f"{file.name} imports from outside the plant"
            assert not UNDER_TEST & {name.split(".")[0] for name in names}, file.name
    for file in files:
        if not file.name.startswith("test_"):
            text = file.read_text(encoding="utf-8")
            assert "import_module" not in text and "__import__" not in text, file.name


def test_rpy_turns_about_fixed_axes() -> None:
    # yaw 90 after roll 90: z -> -y (roll) -> x (yaw)
    R = placement(rpy=(np.pi / 2, 0, np.pi / 2))[:3, :3]
    np.testing.assert_allclose(R @ [0, 0, 1], [1, 0, 0], atol=1e-15)
    R = pin.rpy.rpyToMatrix(0.3, -0.8, 2.1)
    np.testing.assert_allclose(placement(rpy=(0.3, -0.8, 2.1))[:3, :3], R, atol=1e-15)


def test_halfway_pose_is_half_the_turn() -> None:
    rng = np.random.default_rng(3)
    start = placement(rng.normal(size=3), rng.uniform(-1, 1, 3))
    v = np.array([0.4, -1.1, 0.9])
    end = start @ np.block([[turn(v), np.ones((3, 1))], [np.zeros((1, 3)), np.ones((1, 1))]])
    half = between(start, end, 0.5)
    np.testing.assert_allclose(rotation_vector(start[:3, :3].T @ half[:3, :3]), v / 2, atol=1e-14)
    np.testing.assert_allclose(half[:3, 3], (start[:3, 3] + end[:3, 3]) / 2, atol=1e-15)
    distance, angle = pose_error(end, start)
    assert distance == pytest.approx(np.sqrt(3), abs=1e-14)
    assert angle == pytest.approx(np.linalg.norm(v), abs=1e-14)


def compare_with_pinocchio(path: Path, base: str | None, tip: str | None, frames: tuple[str, str]) -> None:
    """TCP pose, Jacobian and gravity torque at random postures; frames = (base, tip) for Pinocchio."""
    tool = Tool((0.1, -0.05, 0.3), (0.2, -0.4, 1.0))
    arm = Arm.load(path, base=base, tip=tip, tool=tool)
    model = pin.buildModelFromUrdf(str(path))
    data = model.createData()
    columns = [model.joints[model.getJointId(name)].idx_v for name in arm.joint_names]
    scene = Scene(arm, gravity=arm.mass is not None)
    rng = np.random.default_rng(11)
    heaviest = 0.0
    for _ in range(25):
        q = rng.uniform(np.maximum(arm.lower, -6), np.minimum(arm.upper, 6))
        full = pin.neutral(model)
        for name, angle in zip(arm.joint_names, q, strict=True):
            joint = model.joints[model.getJointId(name)]
            turning = joint.nq == 2  # continuous joints are stored as cosine and sine
            full[joint.idx_q : joint.idx_q + joint.nq] = [np.cos(angle), np.sin(angle)] if turning else angle
        pin.computeJointJacobians(model, data, full)
        pin.updateFramePlacements(model, data)
        T_base, T_tip = (data.oMf[model.getFrameId(f)].homogeneous for f in frames)
        scene.move(q)
        tcp = rigid_inverse(T_base) @ T_tip @ tool.pose
        np.testing.assert_allclose(scene.tcp(), tcp, atol=1e-13)
        full_J = pin.getFrameJacobian(model, data, model.getFrameId(frames[1]), pin.LOCAL_WORLD_ALIGNED)
        J = full_J[:, columns]
        lever = T_tip[:3, :3] @ tool.xyz
        J[:3] += np.cross(J[3:].T, lever).T
        J = np.kron(np.eye(2), T_base[:3, :3].T) @ J
        np.testing.assert_allclose(scene.jacobian(), J, atol=1e-12)
        if arm.mass is not None:
            model.gravity.linear = T_base[:3, :3] @ [0, 0, -9.80665]
            expected = -pin.computeGeneralizedGravity(model, data, full)[columns]
            np.testing.assert_allclose(scene.forces(()), expected, atol=1e-9)
            heaviest = max(heaviest, float(np.max(np.abs(expected))))
    assert heaviest > 1 or arm.mass is None


@pytest.mark.parametrize(
    ("base", "tip"), [(None, None), (None, "tool0"), ("pedestal", "tool0"), ("world", None)]
)
def test_own_urdf_equals_pinocchio(tmp_path: Path, base: str | None, tip: str | None) -> None:
    path = tmp_path / "own.urdf"
    path.write_text(small_arms.URDF)
    arm = Arm.load(path, base=base, tip=tip)
    assert arm.joint_names == ("shoulder", "elbow")
    np.testing.assert_allclose(arm.lower, [-2.0, -np.inf])
    assert arm.mass is not None
    np.testing.assert_allclose(arm.mass, [25.0, 3.0])  # the motor is bolted to the arm
    compare_with_pinocchio(path, base, tip, (base or "base", tip or "hand"))


@pytest.mark.parametrize(
    ("file", "base", "tip", "last"),
    [
        ("ur10_robot", "base", "tool0", ""),
        ("kuka_kr210_r2700_2", "base", "tool0", ""),
        ("abb_irb6640_185_280", "base", "tool0", ""),
        ("fanuc_official_crx10ia_l", "world", "flange", ""),
        ("staubli_rx160", "base", None, "link_6"),
        ("motoman_mh50", "base", "tool0", ""),
    ],
)
def test_real_urdf_equals_pinocchio(shared: Path, file: str, base: str, tip: str | None, last: str) -> None:
    path = shared / "data" / "robots" / f"{file}.urdf"
    if not path.exists():
        pytest.skip(f"{file}.urdf is not beside the checkout")
    compare_with_pinocchio(path, None, tip, (base, tip or last))


DH = """
schema = "robot/1"
name = "own"
convention = "{convention}"
sources = ["made up"]
base = {{ xyz = [100.0, 0.0, 50.0], rpy = [0.0, 0.0, 90.0] }}
flange = {{ xyz = [0.0, 0.0, 70.0], rpy = [0.0, 90.0, 0.0] }}
[[joints]]
d = 300.0
a = 200.0
alpha = -90.0
offset = 30.0
limits = [-170.0, 160.0]
mass = 12.0
com = [-50.0, 10.0, 20.0]
[[joints]]
d = -40.0
a = 500.0
alpha = 60.0
offset = -90.0
sign = -1
limits = [-90.0, 95.0]
mass = 4.0
com = [10.0, 0.0, 30.0]
"""


def dh(theta: float, d: float, a: float, alpha: float) -> np.ndarray:
    """Classic row, written out (Siciliano et al., Robotics, 2.52)."""
    ct, st, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
    return np.array(
        [[ct, -st * ca, st * sa, a * ct], [st, ct * ca, -ct * sa, a * st], [0, sa, ca, d], [0, 0, 0, 1]]
    )


def craig(alpha: float, a: float, theta: float, d: float) -> np.ndarray:
    """Modified row, written out (Craig, Introduction to Robotics, 3.6)."""
    ct, st, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
    return np.array(
        [[ct, -st, 0, a], [st * ca, ct * ca, -sa, -sa * d], [st * sa, ct * sa, ca, ca * d], [0, 0, 0, 1]]
    )


@pytest.mark.parametrize("convention", ["classic", "modified"])
def test_toml_rows_written_out(tmp_path: Path, convention: str) -> None:
    path = tmp_path / "own.toml"
    path.write_text(DH.format(convention=convention))
    arm = Arm.load(path, tool=Tool((0.1, 0.2, 0.3)))
    base = np.array([[0, -1, 0, 0.1], [1, 0, 0, 0], [0, 0, 1, 0.05], [0, 0, 0, 1]])
    tail = np.array([[0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 0.07], [0, 0, 0, 1]])
    np.testing.assert_allclose(arm.lower, np.radians([-170, -90]))
    np.testing.assert_allclose(arm.upper, np.radians([160, 95]))
    scene = Scene(arm)
    for q1, q2 in np.random.default_rng(2).uniform(-1.5, 1.5, (10, 2)):
        theta = [q1 + np.pi / 6, -q2 - np.pi / 2]
        if convention == "classic":
            rows = [dh(theta[0], 0.3, 0.2, -np.pi / 2), dh(theta[1], -0.04, 0.5, np.pi / 3)]
        else:
            rows = [craig(-np.pi / 2, 0.2, theta[0], 0.3), craig(np.pi / 3, 0.5, theta[1], -0.04)]
        scene.move(np.array([q1, q2]))
        np.testing.assert_allclose(scene.link(1), base @ rows[0], atol=1e-14)
        flange = base @ rows[0] @ rows[1] @ tail
        np.testing.assert_allclose(scene.link(2), flange, atol=1e-14)
        np.testing.assert_allclose(scene.tcp()[:3, 3], (flange @ [0.1, 0.2, 0.3, 1])[:3], atol=1e-14)
        height = [base @ rows[0] @ [-0.05, 0.01, 0.02, 1], flange @ [0.01, 0, 0.03, 1]]
        energy = 9.80665 * (12 * height[0][2] + 4 * height[1][2])
        assert scene.potential() == pytest.approx(energy, abs=1e-9)


def test_toml_with_unknown_words_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text(DH.format(convention="classic") + "\ngears = 3\n")
    with pytest.raises(ValueError, match="gears"):
        Arm.load(path)


ROBOTS = Path(__file__).parents[2] / "stiffness" / "robot" / "data"


def test_every_robot_of_the_project_can_be_read() -> None:
    files = sorted(ROBOTS.glob("*.toml"))
    if not files:
        pytest.skip("no robot files beside the tests")
    for file in files:
        arm = Arm.load(file, tool=Tool((0, 0, 0.2), mass=10.0))
        scene = Scene(arm, gravity=arm.mass is not None)
        q = (0.4 * arm.lower + 0.6 * arm.upper).clip(-1, 1)
        scene.move(q)
        # the Jacobian by differences: axes, signs and tool lever belong together
        for k in range(arm.n):
            h = 1e-6 * np.eye(arm.n)[k]
            scene.move(q + h)
            ahead = scene.tcp()
            scene.move(q - h)
            moved = (ahead - scene.tcp())[:3, 3] / 2e-6
            scene.move(q)
            np.testing.assert_allclose(scene.jacobian()[:3, k], moved, atol=1e-8)


def test_masses_unknown_is_said(tmp_path: Path) -> None:
    path = tmp_path / "light.urdf"
    path.write_text(small_arms.URDF.replace('<mass value="3"/>', '<mass value="0"/>'))
    arm = Arm.load(path)
    assert arm.mass is None
    with pytest.raises(ValueError, match="masses unknown"):
        Scene(arm)
    heavy = arm.with_masses([2.0, 1.0], [[0.1, 0.2, 0.3], [0.3, 0.2, 0.1]])
    assert np.max(np.abs(Scene(heavy).forces(()))) > 0.1


def test_mount_turns_gravity() -> None:
    # base rolled by 90 deg: the world's -z is the base's -y
    arm = small_arms.planar([1.0], mount_rpy=(np.pi / 2, 0, 0))
    np.testing.assert_allclose(arm.gravity, [0, -9.80665, 0], atol=1e-14)
    # pitched by 90 deg: the base's x points down
    arm = small_arms.planar([1.0], mount_rpy=(0, np.pi / 2, 0))
    np.testing.assert_allclose(arm.gravity, [9.80665, 0, 0], atol=1e-14)
