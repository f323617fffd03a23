"""URDF files: those beside the checkout against Pinocchio's own reader, small ones with one thing wrong."""

from __future__ import annotations

from pathlib import Path

import casadi as ca
import numpy as np
import pinocchio as pin
import pytest

from stiffness.errors import RobotError
from stiffness.numerics.kernel import Kernel
from stiffness.robot.load import load_robot
from stiffness.robot.robot import Robot

URDFS = (
    "abb_irb6600_225_255", "abb_irb6640_185_280", "fanuc_official_crx10ia_l", "fanuc_official_m710ic_50",
    "kuka_kr120r2500pro", "kuka_kr210_r2700_2", "motoman_mh50", "staubli_rx160", "ur10_robot",
)  # fmt: skip


class Reference:
    """Pinocchio's own reading of a file; joints outside the chain stand at zero."""

    def __init__(self, path: Path, robot: Robot) -> None:
        self.model = pin.buildModelFromUrdf(str(path))
        self.data = self.model.createData()
        self.robot = robot
        self.joints = [self.model.joints[self.model.getJointId(name)] for name in robot.joint_names]

    def full(self, q: np.ndarray) -> np.ndarray:
        x = pin.neutral(self.model)
        for joint, angle in zip(self.joints, q, strict=True):
            x[joint.idx_q] = angle
        return x

    def pose(self, q: np.ndarray) -> np.ndarray:
        pin.framesForwardKinematics(self.model, self.data, self.full(q))
        base, tip = (self.data.oMf[self.model.getFrameId(f)] for f in (self.robot.base, self.robot.tip))
        return np.array((base.inverse() * tip).homogeneous)


@pytest.fixture(params=URDFS)
def pair(request: pytest.FixtureRequest, shared: Path) -> tuple[Robot, Reference]:
    path = shared / "data/robots" / f"{request.param}.urdf"
    robot = load_robot(str(path))
    return robot, Reference(path, robot)


def test_every_urdf_is_listed(shared: Path) -> None:
    assert {p.stem for p in (shared / "data/robots").glob("*.urdf")} == set(URDFS)


def test_casadi_and_robot_equal_pinocchio(pair: tuple[Robot, Reference]) -> None:
    robot, reference = pair
    q = np.random.default_rng(7).uniform(-np.pi, np.pi, (1000, 6))
    x = ca.SX.sym("q", 6)
    rotation, origin = robot.flange_symbolic(x)
    r, p = Kernel(ca.Function("f", [x], [ca.densify(ca.vec(rotation.T)), ca.densify(origin)])).run(q)
    for k, row in enumerate(q):
        pose = reference.pose(row)
        assert np.abs(p[k] - pose[:3, 3]).max() < 1e-12
        assert np.abs(r[k].reshape(3, 3) - pose[:3, :3]).max() < 1e-12
        assert np.abs(robot.pose(row) - pose).max() < 1e-12


def test_jacobian_and_gravity_equal_pinocchio(pair: tuple[Robot, Reference]) -> None:
    """On a base that stands in the root; in the root's field otherwise turned into the base."""
    robot, reference = pair
    model, data = reference.model, reference.data
    columns = [j.idx_v for j in reference.joints]
    for q in np.random.default_rng(8).uniform(-np.pi, np.pi, (20, 6)):
        full = reference.full(q)
        pin.framesForwardKinematics(model, data, full)
        turn = data.oMf[model.getFrameId(robot.base)].rotation
        aligned = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        jacobian = pin.computeFrameJacobian(model, data, full, model.getFrameId(robot.tip), aligned)[
            :, columns
        ]
        np.testing.assert_allclose(robot.jacobian(q)[:3], turn.T @ jacobian[:3], atol=1e-12)
        np.testing.assert_allclose(robot.jacobian(q)[3:], turn.T @ jacobian[3:], atol=1e-12)
        if robot.mass is not None:
            model.gravity.linear = np.array([1.0, -2.0, -9.0])
            expected = -pin.computeGeneralizedGravity(model, data, full)[columns]
            got = robot.gravity_torque(q, turn.T @ np.array([1.0, -2.0, -9.0]))
            np.testing.assert_allclose(got, expected, atol=1e-9 * max(1, np.abs(expected).max()))


def test_what_is_said_of_the_masses(shared: Path) -> None:
    problems = {n: load_robot(str(shared / f"data/robots/{n}.urdf")).mass_problem for n in URDFS}
    assert "every link weighs 2 kg: a placeholder" in problems["kuka_kr120r2500pro"]
    for name in ("abb_irb6600_225_255", "abb_irb6640_185_280", "motoman_mh50"):
        assert problems[name].endswith("gives no masses")
    for name in ("kuka_kr210_r2700_2", "ur10_robot", "fanuc_official_m710ic_50", "fanuc_official_crx10ia_l"):
        assert problems[name] == ""


def test_frames_limits_and_speeds(shared: Path) -> None:
    robot = load_robot(str(shared / "data/robots/abb_irb6600_225_255.urdf"))
    assert (robot.name, robot.base, robot.tip) == ("abb_irb6600_225_255", "base", "link_6")
    np.testing.assert_allclose(np.degrees(robot.lower), [-180, -65, -180, -300, -120, -300], atol=1e-5)
    np.testing.assert_allclose(np.degrees(robot.upper), [180, 80, 60, 300, 120, 300], atol=1e-5)
    np.testing.assert_allclose(np.degrees(robot.velocity), [100, 90, 90, 150, 120, 190], atol=1e-5)
    fanuc = load_robot(str(shared / "data/robots/fanuc_official_crx10ia_l.urdf"))
    assert (fanuc.base, fanuc.tip) == ("world", "J6_link")


# --- small files with one thing wrong

AXES = ("0 0 1", "0 1 0", "0 1 0", "1 0 0", "0 1 0", "1 0 0")
ORIGINS = ("0 0 0.5", "0.3 0 0", "0 0 1", "0.2 0 0.1", "0.9 0 0", "0.1 0 0")


def joint(name: str, parent: str, child: str, **kw: str) -> str:
    kind, limit = kw.get("kind", "revolute"), kw.get("limit", '<limit lower="-2" upper="2" velocity="1"/>')
    origin, axis = kw.get("origin", "0 0 0"), kw.get("axis", "0 0 1")
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{origin}" rpy="0 0 0"/><axis xyz="{axis}"/>{limit}{kw.get("more", "")}</joint>'
    )


def link(name: str, mass: float | None = None, com: str = "0 0 0") -> str:
    body = "" if mass is None else f'<inertial><mass value="{mass}"/><origin xyz="{com}"/></inertial>'
    return f'<link name="{name}">{body}</link>'


def arm(tmp_path: Path, *, more: str = "", masses: bool = True, change: tuple[str, str] | None = None) -> str:
    parts = [link("root", 50.0)]
    for k in range(6):
        parts.append(link(f"l{k + 1}", 20.0 - k if masses else None, "0.1 0 0.05"))
        parent = f"l{k}" if k else "root"
        parts.append(joint(f"j{k + 1}", parent, f"l{k + 1}", origin=ORIGINS[k], axis=AXES[k]))
    content = f'<robot name="small">{"".join(parts)}{more}</robot>'
    if change is not None:
        assert change[0] in content
        content = content.replace(*change)
    path = tmp_path / "small.urdf"
    path.write_text(content)
    return str(path)


def test_the_small_arm_is_good(tmp_path: Path) -> None:
    robot = load_robot(arm(tmp_path))
    assert (robot.base, robot.tip, robot.mass_problem) == ("root", "l6", "")
    np.testing.assert_allclose(robot.mass, [20, 19, 18, 17, 16, 15])
    np.testing.assert_allclose(robot.pose(np.zeros(6))[:3, 3], [1.5, 0, 1.6])


def test_fixed_tail_moves_the_tip_and_its_weight_counts(tmp_path: Path) -> None:
    """15 kg at (0.1, 0, 0.05) and 5 kg at (0.5, 0, 0) m of link 6: together at (0.2, 0, 0.0375) m."""
    tail = link("tool", 5.0, "0 0 0") + joint("weld", "l6", "tool", kind="fixed", origin="0.5 0 0", limit="")
    path = arm(tmp_path, more=tail)
    for tip, shift in ((None, 0.0), ("tool", 0.5)):
        robot = load_robot(path, tip=tip)
        assert robot.mass is not None
        assert robot.com is not None
        assert robot.mass[5] == pytest.approx(20)
        np.testing.assert_allclose(robot.com[5], [0.2 - shift, 0, 0.0375], atol=1e-12)
    assert load_robot(path, tip="tool").pose(np.zeros(6))[0, 3] == pytest.approx(2.0)


def test_a_link_named_base_is_the_base(tmp_path: Path) -> None:
    more = link("base") + joint("to_base", "root", "base", kind="fixed", origin="0 0 0.25", limit="")
    path = arm(tmp_path, more=more)
    assert load_robot(path).pose(np.zeros(6))[2, 3] == pytest.approx(1.35)
    assert load_robot(path, base="root").pose(np.zeros(6))[2, 3] == pytest.approx(1.6)


def test_weight_on_a_mimic_branch_is_not_lumped(tmp_path: Path) -> None:
    mimic = '<mimic joint="j2" multiplier="-0.2"/>'
    branch = joint("rod", "l1", "cylinder", kind="continuous", limit="", more=mimic)
    robot = load_robot(arm(tmp_path, more=link("cylinder", 30.0) + branch))
    assert robot.tip == "l6"
    assert robot.mass is None
    assert "30 kg hang on joint 'rod', which is not in the chain" in robot.mass_problem
    light = load_robot(arm(tmp_path, more=link("cylinder") + branch))
    assert light.mass_problem == ""


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (('<mass value="18.0"/>', '<mass value="0.0"/>'), "link 'l3' has no mass"),
        (('<mass value="18.0"/>', '<mass value="-1.0"/>'), "link 'l3' has the mass -1 kg"),
        (('"18.0"/><origin xyz="0.1 0 0.05"/>', '"18.0"/><origin xyz="80 0 4"/>'), "80.1 m from"),
    ],
)  # fmt: skip
def test_absurd_masses_are_not_used(tmp_path: Path, change: tuple[str, str], problem: str) -> None:
    robot = load_robot(arm(tmp_path, change=change))
    assert robot.mass is None
    assert problem in robot.mass_problem
    with pytest.raises(RobotError, match="no gravity torque without masses"):
        robot.gravity_torque(np.zeros(6))


def test_no_masses(tmp_path: Path) -> None:
    assert load_robot(arm(tmp_path, masses=False)).mass_problem == "small.urdf: gives no masses"


def test_continuous_joint_has_no_limits(tmp_path: Path) -> None:
    robot = load_robot(arm(tmp_path, change=('name="j6" type="revolute"', 'name="j6" type="continuous"')))
    assert (robot.lower[5], robot.upper[5]) == (-np.inf, np.inf)
    assert robot.upper[4] == 2.0


LIMIT_2 = ('<axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="1"/>', '<axis xyz="0 1 0"/>')


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("</robot>", ""), "is not XML"),
        (('<robot name="small">', '<model name="small">'), "is not XML"),
        (('name="j3" type="revolute"', 'name="j3" type="prismatic"'), "joint 'j3' of the chain is prismatic"),
        (('name="j3" type="revolute"', 'name="j3" type="hinge"'), "joint 'j3' has the type 'hinge'"),
        (('name="j3" type="revolute"', 'name="j3" type="fixed"'), "5 joints between root and l6, expected 6"),
        (LIMIT_2, "joint 'j2' is revolute and has no <limit"),
        (('lower="-2"', 'lower="3"'), "has the limits 3.0 .. 2.0 rad"),
        (('lower="-2"', 'lower="nan"'), "'nan' is not 1 finite number"),
        (('<axis xyz="1 0 0"/>', '<axis xyz="0 0 0"/>'), "has the axis 0 0 0"),
        (('xyz="0 0 0.5"', 'xyz="0 0.5"'), "'0 0.5' is not 3 finite numbers"),
        (('<parent link="l2"/>', ""), "joint 'j3' has no <parent>"),
        (('<parent link="l2"/>', '<parent link="l9"/>'), "names the link 'l9', which does not exist"),
        (('<parent link="l2"/>', '<parent link="root"/>'), "set tip|joints between root"),
        (('<parent link="root"/>', '<parent link="l6"/>'), "expected one root link|loop"),
        (('name="j2"', 'name="j1"'), "two joints are named 'j1'"),
        (('<link name="l2">', '<link name="l1">'), "two links are named 'l1'"),
    ],
)
def test_refused(tmp_path: Path, change: tuple[str, str], message: str) -> None:
    with pytest.raises(RobotError, match=message) as caught:
        load_robot(arm(tmp_path, change=change))
    assert "small" in str(caught.value)


def test_coupled_joint_in_the_chain_is_refused(tmp_path: Path) -> None:
    end = '<axis xyz="1 0 0"/><limit lower="-2" upper="2" velocity="1"/>'
    path = arm(tmp_path, change=(end, end + '<mimic joint="j2"/>'))
    with pytest.raises(RobotError, match="joint 'j4' of the chain mimics 'j2'"):
        load_robot(path, tip="l6")


def test_two_equal_chains_ask_for_a_tip(tmp_path: Path) -> None:
    path = arm(tmp_path, more=link("finger") + joint("grip", "l5", "finger"))
    with pytest.raises(RobotError, match="set tip to one of l6, finger"):
        load_robot(path)
    robot = load_robot(path, tip="l6")
    assert (robot.tip, robot.mass_problem) == ("l6", "")


def test_frames_that_do_not_serve(tmp_path: Path) -> None:
    path = arm(tmp_path)
    with pytest.raises(RobotError, match="tip = 'tool0' is no link; there are: root, l1"):
        load_robot(path, tip="tool0")
    with pytest.raises(RobotError, match="4 joints between l2 and l6"):
        load_robot(path, base="l2")
    side = arm(tmp_path, more=link("finger") + joint("grip", "l5", "finger"))
    with pytest.raises(RobotError, match="base 'finger' moves with joint 'grip'"):
        load_robot(side, base="finger", tip="l6")


def test_not_a_urdf(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    with pytest.raises(RobotError, match="there is no such file"):
        load_robot(str(path))
    path.write_text('<?xml version="1.0"?><robot name="x"></robot>')
    with pytest.raises(RobotError, match="has no <link>"):
        load_robot(str(path))
    path.write_text("<sdf/>")
    with pytest.raises(RobotError, match="the root element is <sdf>"):
        load_robot(str(path))
