"""The clamping method: lines, gap and friction by hand, an independent statement of why it works, refusals."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from scipy import stats

from stiffness.errors import StiffnessError
from stiffness.model.clamped import JointFit, clamped_model, fit_clamped
from stiffness.model.clamped_readings import ClampedError, read_clamped
from stiffness.model.model import load_model, save_model
from stiffness.robot.load import load_robot
from tests.stiffness import arms
from tests.stiffness.model.test_datasheet import RV, robot_text

Floats = npt.NDArray[np.float64]
HEADER = "joint,motor_angle_deg,motor_torque_nm,gear_ratio,branch,repeat"
K, GAP, FRICTION, RATIO = 1.5e6, 3e-4, 40.0, 150.0
STEPS = np.array([200.0, 800.0, 1400.0, 2000.0])


def cycle(
    k: float = K,
    gap: float = GAP,
    friction: float = FRICTION,
    steps: Floats = STEPS,
    noise: Callable[[], float] = lambda: 0.0,
    sides: Sequence[int] = (1, -1),
    branches: Sequence[str] = ("loading", "unloading"),
) -> list[tuple[float, float, str]]:
    """A load cycle at the joint: (angle rad, torque N*m of the motor, branch). The spring sees ``steps``, the motor
    friction on top while loading and less by it while unloading."""
    rows = []
    for side in sides:
        for branch in branches:
            for spring in steps if branch == "loading" else steps[::-1]:
                held = friction if branch == "loading" else -friction
                rows.append((side * (spring / k + gap / 2), side * (spring + held) + noise(), branch))
    return rows


def lines(*cycles: list[tuple[float, float, str]], joint: int = 1) -> list[str]:
    """Rows of the file, motor side, deg."""
    return [
        f"{joint},{np.degrees(angle) * RATIO:.12f},{torque / RATIO:.12f},{RATIO:g},{branch},{k + 1}"
        for k, rows in enumerate(cycles)
        for angle, torque, branch in rows
    ]


def written(folder: Path, rows: Sequence[str], header: str = HEADER) -> Path:
    path = folder / "readings.csv"
    path.write_text("\n".join([header, *rows]) + "\n")
    return path


def fitted(
    folder: Path, rows: Sequence[str], header: str = HEADER, above: float = 0.25, scale_sd: float = 0.0
) -> tuple[JointFit, ...]:
    return fit_clamped(read_clamped(written(folder, rows, header), arms.robot()), above=above, scale_sd=scale_sd)


def test_readings_come_to_the_output_side(tmp_path: Path) -> None:
    """150 turns: 3 deg and 4 N*m at the motor are 0.02 deg and 600 N*m at the joint."""
    got = read_clamped(written(tmp_path, ["2,3.0,4.0,150,loading,7"]), arms.robot())
    np.testing.assert_allclose([got.angle[0], got.torque[0]], [np.radians(0.02), 600.0])
    assert (got.joint[0], got.repeat[0], got.loading[0], got.line[0]) == (1, 7, True, 2)


@pytest.mark.parametrize(
    ("header", "row"),
    [
        ("joint,motor_angle_rad,motor_torque_nm,gear_ratio,branch", "2,0.052359877559829886,4.0,150,loading"),
        ("branch,joint_torque_nm,joint_angle_deg,joint", "loading,600,0.02,joint-2"),
        ("joint,joint_angle_rad,motor_torque_nm,gear_ratio,branch", "2,3.490658503988659e-4,4.0,150,loading"),
    ],
)
def test_either_side_and_unit(tmp_path: Path, header: str, row: str) -> None:
    got = read_clamped(written(tmp_path, [row], header), arms.robot())
    np.testing.assert_allclose([got.angle[0], got.torque[0]], [np.radians(0.02), 600.0], rtol=1e-12)
    assert (got.joint[0], got.repeat[0]) == (1, 1)


def test_gear_ratio_of_the_robot_file(tmp_path: Path) -> None:
    arm = tmp_path / "arm.toml"
    arm.write_text(robot_text(RV))
    header = "joint,motor_angle_deg,motor_torque_nm,branch"
    got = read_clamped(written(tmp_path, ["1,1.71,2.0,loading"], header), load_robot(str(arm)))
    np.testing.assert_allclose([got.angle[0], got.torque[0]], [np.radians(0.01), 342.0])
    with pytest.raises(StiffnessError, match=r"row 3, column joint = '2': .* need a column gear_ratio"):
        read_clamped(written(tmp_path, ["1,1.71,2.0,loading", "2,1.71,2.0,loading"], header), load_robot(str(arm)))


def test_stiffness_gap_and_hysteresis_by_hand(tmp_path: Path) -> None:
    """Branches without noise: friction shifts them, and leaves slope and gap alone; it widens the loop by 2 f / K."""
    (fit,) = fitted(tmp_path, lines(cycle()))
    np.testing.assert_allclose([fit.stiffness, fit.unloading], K, rtol=1e-9)
    np.testing.assert_allclose(fit.gap, GAP, rtol=1e-8)
    np.testing.assert_allclose(fit.hysteresis, GAP + 2 * FRICTION / K, rtol=1e-8)
    np.testing.assert_allclose(fit.largest, 2040.0)
    assert fit.sd < 1e-6 * K and fit.misfit < 1e-4 and not fit.friction_in_gap
    assert (fit.used, fit.left_out, fit.joint) == (12, 4, 0)  # 240 and 160 of 2040 and 1960 are below a quarter


def test_without_unloading_friction_stays_in_the_gap_and_is_said(tmp_path: Path) -> None:
    (fit,) = fitted(tmp_path, lines(cycle(branches=("loading",))))
    np.testing.assert_allclose(fit.gap, GAP - 2 * FRICTION / K, rtol=1e-8)
    assert fit.friction_in_gap and fit.unloading is None and fit.hysteresis is None


def test_one_side_has_no_gap(tmp_path: Path) -> None:
    (fit,) = fitted(tmp_path, lines(cycle(sides=(-1,), steps=np.linspace(600, 2000, 6))))
    np.testing.assert_allclose(fit.stiffness, K, rtol=1e-9)
    assert fit.gap is None and fit.gap_sd is None and fit.hysteresis is None and not fit.friction_in_gap


def test_friction_in_proportion_to_the_load_parts_the_slopes(tmp_path: Path) -> None:
    """10 % of the torque: loading looks 10 % stiffer, unloading 10 % softer; both are told."""
    rows = [
        (angle, torque * (1.1 if branch == "loading" else 0.9), branch) for angle, torque, branch in cycle(friction=0.0)
    ]
    (fit,) = fitted(tmp_path, lines(rows))
    np.testing.assert_allclose([fit.stiffness, fit.unloading], [1.1 * K, 0.9 * K], rtol=1e-9)
    np.testing.assert_allclose(fit.gap, GAP, rtol=1e-8)


def test_a_soft_start_is_left_out(tmp_path: Path) -> None:
    """Half the stiffness below 500 N*m: the large-torque slope is K; with everything it is less."""
    steps = np.array([100.0, 300.0, 500.0, 1000.0, 1500.0, 2000.0])
    rows = [
        (t / (K / 2) if t <= 500 else 500 / (K / 2) + (t - 500) / K, t, "loading") for t in steps
    ]  # fmt: skip
    cycles = [rows, rows]
    np.testing.assert_allclose(fitted(tmp_path, lines(*cycles))[0].stiffness, K, rtol=1e-9)
    assert fitted(tmp_path, lines(*cycles), above=0.0)[0].stiffness < 0.95 * K


def test_standard_deviation_of_one_line_is_that_of_linear_regression(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    torque = np.linspace(600, 2000, 9)
    rows = [(t / K, t + rng.normal(0, 20.0), "loading") for t in torque]
    (fit,) = fitted(tmp_path, lines(rows))
    expected = stats.linregress([r[0] for r in rows], [r[1] for r in rows])
    np.testing.assert_allclose([fit.stiffness, fit.sd], [expected.slope, expected.stderr], rtol=1e-8)


def test_standard_deviations_hold_the_truth(tmp_path: Path) -> None:
    """400 simulated files of three cycles: stiffness and gap in units of their sd have about unit spread."""
    rng = np.random.default_rng(2)
    off = []
    for _ in range(400):
        rows = lines(*(cycle(noise=lambda: rng.normal(0, 15.0), steps=np.linspace(200, 2000, 7)) for _ in range(3)))
        (fit,) = fitted(tmp_path, rows)
        assert fit.gap is not None and fit.gap_sd is not None
        off.append([(fit.stiffness - K) / fit.sd, (fit.gap - GAP) / fit.gap_sd])
    spread, mean = np.std(off, axis=0), np.mean(off, axis=0)
    assert np.all((spread > 0.75) & (spread < 1.1)), spread  # below 1: the larger of two estimates is taken
    assert np.all(np.abs(mean) < 0.15), mean


def test_cycles_that_differ_widen_the_standard_deviation(tmp_path: Path) -> None:
    """Slopes 0.9, 1, 1.1 K: the mean is uncertain by 0.1 K / sqrt(3), however clean each line is."""
    rows = [[(t / (f * K), t, "loading") for t in np.linspace(600, 2000, 9)] for f in (0.9, 1.0, 1.1)]
    (fit,) = fitted(tmp_path, lines(*rows))
    np.testing.assert_allclose(fit.sd, 0.1 * K / np.sqrt(3), rtol=1e-6)


def test_the_scale_of_the_torque_is_in_the_standard_deviation(tmp_path: Path) -> None:
    """A torque constant that is 5 % off is a stiffness that is 5 % off, and leaves the gap alone."""
    (fit,) = fitted(tmp_path, lines(*(cycle(k=f * K) for f in (0.9, 1.0, 1.1))), scale_sd=0.05)
    (without,) = fitted(tmp_path, lines(*(cycle(k=f * K) for f in (0.9, 1.0, 1.1))))
    np.testing.assert_allclose(fit.sd, np.hypot(without.sd, 0.05 * fit.stiffness), rtol=1e-12)
    assert fit.gap_sd == without.gap_sd and without.sd > 0.03 * K
    wrong = [(angle, 1.05 * torque, branch) for angle, torque, branch in cycle()]
    (off,) = fitted(tmp_path, lines(wrong))
    np.testing.assert_allclose([off.stiffness, off.gap], [1.05 * K, GAP], rtol=1e-7)
    with pytest.raises(ClampedError, match="--torque-scale-sd 5: expected a share"):
        fitted(tmp_path, lines(cycle()), scale_sd=5.0)


def test_several_joints_and_the_model(tmp_path: Path) -> None:
    """Joint 3 from one side only: no gap known; the others are not identified. Survives the file."""
    rows = [*lines(cycle()), *lines(cycle(k=5e5, sides=(1,), steps=np.linspace(300, 1000, 8)), joint=3)]
    fits = fitted(tmp_path, rows)
    model = clamped_model(arms.robot(), arms.NAMES[0], fits, {"source": "readings.csv"})
    np.testing.assert_allclose(model.values["joint-stiffness"]["k_nm_per_rad"], [K, 1e6, 5e5, 1e6, 1e6, 1e6], rtol=1e-8)
    assert model.identified["joint-stiffness"].tolist() == [True, False, True, False, False, False]
    np.testing.assert_allclose(model.values["backlash"]["gap_rad"], [GAP, 0, 0, 0, 0, 0], rtol=1e-8)
    np.testing.assert_allclose(model.sd["backlash"]["gap_rad"][1:], np.pi / 10800)
    assert model.provenance["kind"] == "static" and model.provenance["method"] == "clamped"
    save_model(model, tmp_path / "model.toml")
    again = load_model(tmp_path / "model.toml")
    for effect in ("joint-stiffness", "backlash"):
        for name, values in model.values[effect].items():
            assert again.values[effect][name].tolist() == values.tolist()
    assert again.identified["joint-stiffness"].tolist() == model.identified["joint-stiffness"].tolist()
    assert dict(again.provenance) == dict(model.provenance)


def test_a_negative_gap_is_none_in_the_model(tmp_path: Path) -> None:
    fits = fitted(tmp_path, lines(cycle(gap=-1e-5)))
    np.testing.assert_allclose(fits[0].gap, -1e-5, rtol=1e-6)
    assert clamped_model(arms.robot(), "r", fits, {}).values["backlash"]["gap_rad"][0] == 0.0


def test_no_other_joint_enters_behind_a_rigid_clamp() -> None:
    """Why the method works: six springs, a motor that turns by phi, and a TCP that a spring of 1e12 holds. The
    torque in that joint is K phi, in the others nothing, whatever their stiffness."""
    arm = arms.robot()
    q = arms.postures(arm, 1, 3)[0]
    jacobian = arm.jacobian(q)
    for joint in range(6):
        turned = np.zeros(6)
        turned[joint] = 1e-3
        stiffness = np.diag(arms.STIFFNESS)
        links = np.linalg.solve(stiffness + jacobian.T @ (1e12 * np.eye(6)) @ jacobian, stiffness @ turned)
        expected = np.zeros(6)
        expected[joint] = arms.STIFFNESS[joint] * 1e-3
        np.testing.assert_allclose(stiffness @ (turned - links), expected, atol=1e-3 * expected[joint])


GOOD = lines(cycle(), cycle())
TURNED = [f"{joint},{-float(angle)},{rest}" for joint, angle, rest in (row.split(",", 2) for row in GOOD)]
MOTOR = "joint,motor_angle_deg,motor_torque_nm"
JOINT = "joint,joint_angle_deg,joint_torque_nm"


def changed(row: int, column: int, to: str) -> list[str]:
    rows = list(GOOD)
    cells = rows[row].split(",")
    cells[column] = to
    rows[row] = ",".join(cells)
    return rows


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        (changed(4, 0, "7"), r"row 6, column joint = '7': no joint of abb-irb6600-175-255: expected 1 \.\.\. 6"),
        (changed(4, 0, ""), "row 6, column joint = '': no joint"),
        (changed(3, 1, "3,5"), "row 5: 7 cells, expected 6 as in the header; are decimals written with a comma"),
        (changed(3, 1, "x"), "row 5, column motor_angle_deg = 'x': not a number"),
        (changed(3, 1, "nan"), "row 5, column motor_angle_deg = 'nan': not a finite number"),
        (changed(3, 2, ""), "row 5, column motor_torque_nm = '': not a number; the cell is empty"),
        (changed(3, 1, "600"), r"row 5, column motor_angle_deg = '600': more than 2.9 deg at the joint"),
        (changed(5, 3, "0"), "row 7, column gear_ratio = '0': expected turns of the motor per turn of the joint"),
        (changed(5, 3, "151"), "row 7, column gear_ratio = '151': another ratio than in rows of this joint above"),
        (changed(2, 4, "up"), "row 4, column branch = 'up': expected loading or unloading"),
        (changed(2, 5, "1.5"), "row 4, column repeat = '1.5': expected an integer"),
        ([], "no row below the header"),
        (lines(cycle(sides=(1,), steps=STEPS[:3])), "joint 1: 2 readings on 1 loading branch have .* expected 4 more"),
        ([r for r in GOOD if "unloading" in r], "joint 1: 0 readings on 0 loading branches"),
        ([*GOOD, GOOD[3][:-1] + "3"], "row 34: the loading branch of repeat 3 has one angle only"),
        (TURNED, "joint 1: the torque falls as the angle grows"),
        (lines(cycle(k=2e9), cycle(k=2e9)), "joint 1: 2e[+]09 N[*]m/rad is outside 1000 ... 1e[+]09"),
    ],
)  # fmt: skip
def test_refused(tmp_path: Path, rows: list[str], message: str) -> None:
    with pytest.raises(StiffnessError, match=message) as caught:
        fitted(tmp_path, rows)
    assert "readings.csv" in str(caught.value)


@pytest.mark.parametrize(
    ("header", "message"),
    [
        (HEADER.replace("joint,", "axis,"), "row 1: unknown column axis"),
        (HEADER.replace("repeat", "repeet"), "unknown column repeet; did you mean repeat?"),
        (HEADER.replace("branch", "gear"), "unknown column gear"),
        (f"{MOTOR},joint_angle_deg,branch", "expected one .*; there are motor_angle_deg and joint_angle_deg"),
        (f"{MOTOR},gear_ratio,branch,q1_deg", "column q2_deg, q3_deg, q4_deg, q5_deg, q6_deg missing beside q1_deg"),
        ("joint,motor_angle_deg,gear_ratio,branch", "expected one column of motor_torque_nm, .*; there is none"),
        (f"{MOTOR},gear_ratio,repeat", "column branch is missing"),
        (f"{JOINT},gear_ratio,branch", "column gear_ratio, but angle and torque are at the joint"),
        (f"{MOTOR},branch", "column joint = '1': motor_angle_deg and motor_torque_nm need a column gear_ratio"),
        ("joint;motor_angle_deg", "separated by semicolons"),
        ("joint,joint", "stands there twice"),
    ],
)  # fmt: skip
def test_a_wrong_header_is_refused(tmp_path: Path, header: str, message: str) -> None:
    cells = {"joint": "1", "branch": "loading"}
    row = ",".join(cells.get(name, "0.01") for name in header.split(","))
    with pytest.raises(StiffnessError, match=message):
        read_clamped(written(tmp_path, [row], header), arms.robot())


def test_postures_in_which_the_clamp_holds_nothing_are_refused(tmp_path: Path) -> None:
    """A stretched wrist leaves joints 4 and 6 free to turn against each other."""
    header = "joint,joint_angle_deg,joint_torque_nm,branch," + ",".join(f"q{k}_deg" for k in range(1, 7))
    good, singular, beyond = "0,20,-10,30,40,0", "0,20,-10,30,0,0", "0,20,-10,30,140,0"
    assert len(read_clamped(written(tmp_path, [f"1,0.01,5,loading,{good}"], header), arms.robot()).joint) == 1
    for posture, message in ((singular, "row 3, column q1_deg = '0': the arm stands near a singularity"),
                             (beyond, "row 3, column q5_deg = '140': beyond the limits")):  # fmt: skip
        rows = [f"1,0.01,5,loading,{p}" for p in (good, posture)]
        with pytest.raises(StiffnessError, match=message):
            read_clamped(written(tmp_path, rows, header), arms.robot())


def test_a_missing_file_and_a_wrong_share(tmp_path: Path) -> None:
    with pytest.raises(ClampedError, match=r"none.csv: there is no such file"):
        read_clamped(tmp_path / "none.csv", arms.robot())
    with pytest.raises(ClampedError, match="--above 1: expected a share"):
        fitted(tmp_path, GOOD, above=1.0)
