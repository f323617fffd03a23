"""From data sheets: reducer tables of robot files, and the model that comes of them, by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy import integrate

from stiffness.effects.joint_hardening import values_of_pieces
from stiffness.errors import RobotError
from stiffness.model.datasheet import SOFTEST, datasheet_model, gap, share
from stiffness.model.model import load_model, save_model
from stiffness.robot.load import load_robot
from stiffness.robot.reducer import Reducer
from tests.stiffness.robot.test_robot_toml import KR500_MODIFIED, text

ARCMIN = np.pi / 10800
RV = (
    "rigidity_nm_per_arcmin = [980.0]\nlost_motion_arcmin = 1.0\nlost_motion_torque_nm = 96.0\ngear_ratio = 171.0\n"
    'source = "a sheet"\n'
)
EITHER = "joints.1.reducer: give either rigidity_nm_per_arcmin or rigidity_nm_per_rad"
STRAIN_WAVE = 'rigidity_nm_per_rad = [2.0e4, 3.0e4, 4.0e4]\nbreaks_nm = [30.0, 120.0]\nsource = "another sheet"\n'
BARE = 'rigidity_nm_per_arcmin = [100.0]\nsource = "a third sheet"\n'


def robot_text(*reducers: str) -> str:
    """The arm of test_robot_toml with reducer tables for its first joints."""
    head, *joints = text(KR500_MODIFIED, "modified").split("[[joints]]\n")
    tables = [f"[joints.reducer]\n{r}" if r else "" for r in (*reducers, *[""] * 6)][:6]
    return "[[joints]]\n".join([head, *(j.rstrip("\n") + "\n" + t + "\n" for j, t in zip(joints, tables, strict=True))])


def written(folder: Path, content: str) -> str:
    path = folder / "arm.toml"
    path.write_text(content)
    return str(path)


def reducer(*rigidity: float, breaks: tuple[float, ...] = (), **kwargs: float) -> Reducer:
    return Reducer(rigidity, "test", breaks, **kwargs)


def test_reducers_of_a_robot_file_in_si(tmp_path: Path) -> None:
    robot = load_robot(written(tmp_path, robot_text(RV, "", STRAIN_WAVE)))
    assert robot.reducers is not None and len(robot.reducers) == 6
    first, second, third, *rest = robot.reducers
    assert first is not None and third is not None and second is None and rest == [None] * 3
    np.testing.assert_allclose(first.rigidity, [980 * 10800 / np.pi])
    np.testing.assert_allclose([first.lost_motion, first.lost_motion_torque, first.gear_ratio], [ARCMIN, 96.0, 171.0])
    assert first.backlash is None and third.rigidity == (2e4, 3e4, 4e4) and third.breaks == (30.0, 120.0)
    assert "reducer of joint 3: another sheet" in robot.sources


def test_a_robot_without_reducers_has_none(tmp_path: Path) -> None:
    assert load_robot(written(tmp_path, robot_text())).reducers is None
    assert load_robot("ur10").reducers is None


@pytest.mark.parametrize(
    ("change", "to", "message"),
    [
        ("gear_ratio = 171.0", "ratio = 171.0", "unknown key joints.1.reducer.ratio"),
        ("gear_ratio = 171.0", "gear_ratio = 0.5", "joints.1.reducer.gear_ratio = 0.5"),
        ('source = "a sheet"\n', "", "key joints.1.reducer.source is missing"),
        ("rigidity_nm_per_arcmin = [980.0]\n", "", EITHER),
        ("[980.0]", "[980.0]\nrigidity_nm_per_rad = [3.0e6]", EITHER),
        ("[980.0]", "[]", "joints.1.reducer.rigidity_nm_per_arcmin"),
        ("[980.0]", "980.0", r"joints.1.reducer.rigidity_nm_per_arcmin = 980.0"),
        ("[980.0]", "[-980.0]", r"rigidity_nm_per_arcmin.1 = -980.0"),
        ("[980.0]", "[3.37e6]", r"arcmin = \[3370000.0\]: more than 20000 N\*m/arcmin: this looks like N\*m/rad"),
        ("[980.0]", "[500.0, 980.0]", "breaks_nm = \\[\\]: expected 1, one less"),
        ("[980.0]", "[980.0]\nbreaks_nm = [5.0]", "breaks_nm = \\[5.0\\]: expected 0, one less"),
        ("[980.0]", "[500.0, 980.0]\nbreaks_nm = [-5.0]", r"breaks_nm.1 = -5.0"),
        ("[980.0]", "[1.0, 2.0, 3.0]\nbreaks_nm = [9.0, 9.0]", r"breaks_nm = \[9.0, 9.0\]: expected rising torques"),
        ("[980.0]", "[980.0, 500.0]\nbreaks_nm = [9.0]", "rigidity falls from one piece to the next"),
        ("lost_motion_arcmin = 1.0\n", "", "lost_motion_torque_nm is given without lost_motion_arcmin"),
        ("lost_motion_arcmin = 1.0", "lost_motion_arcmin = 61.0", "joints.1.reducer.lost_motion_arcmin = 61.0"),
        ("lost_motion_arcmin = 1.0", "backlash_arcmin = -1.0", "joints.1.reducer.backlash_arcmin = -1.0"),
    ],
)  # fmt: skip
def test_a_wrong_reducer_is_refused(tmp_path: Path, change: str, to: str, message: str) -> None:
    assert RV.count(change) == 1
    with pytest.raises(RobotError, match=message) as caught:
        load_robot(written(tmp_path, robot_text(RV.replace(change, to))))
    assert "arm.toml" in str(caught.value)


def test_windup_goes_along_the_pieces() -> None:
    """K 2e4 to 30 N*m, 3e4 to 120, 4e4 beyond: 1.5 mrad, then 1.5 + 3, then 1/4e4 per N*m."""
    r = reducer(2e4, 3e4, 4e4, breaks=(30.0, 120.0))
    np.testing.assert_allclose([r.windup(t) for t in (0, 15, 30, 120, 160)], np.array([0, 0.75, 1.5, 4.5, 5.5]) * 1e-3)
    np.testing.assert_allclose(reducer(1e5).windup(250.0), 2.5e-3)


def cut(torque: float, p: dict[str, float]) -> float:
    """rad of the sharp law: each part grows up to its knee."""
    first, second = p["knee_nm"], p["knee_nm"] * p["knee_ratio"]
    return p["windup_rad"] * min(torque / first, 1) + p["further_rad"] * min(torque / second, 1)


def test_hardening_is_the_three_pieces() -> None:
    """a = 30 (1/2e4 - 1/3e4) = 0.5 mrad, b = 120 (1/3e4 - 1/4e4) = 1 mrad."""
    r = reducer(2e4, 3e4, 4e4, breaks=(30.0, 120.0))
    p = values_of_pieces(r.rigidity, r.breaks)
    expected = {"windup_rad": 5e-4, "knee_nm": 30, "further_rad": 1e-3, "knee_ratio": 4, "sharpness": 1}
    assert p == pytest.approx(expected)
    for torque in (1e-3, 20.0, 50.0, 110.0, 300.0, 1e5):
        np.testing.assert_allclose(torque / 4e4 + cut(torque, p), r.windup(torque), rtol=1e-9)


def test_of_four_pieces_both_ends_are_met() -> None:
    r = reducer(2e4, 3e4, 3.5e4, 4e4, breaks=(30.0, 70.0, 120.0))
    p = values_of_pieces(r.rigidity, r.breaks)
    assert p["knee_nm"] == 30 and p["knee_ratio"] == pytest.approx(4) and p["windup_rad"] > 0 and p["further_rad"] > 0
    for torque in (1e-3, 29.0, 121.0, 1e5):
        np.testing.assert_allclose(torque / 4e4 + cut(torque, p), r.windup(torque), rtol=1e-9)


def test_two_pieces_have_their_break_as_the_knee() -> None:
    p = values_of_pieces((2e4, 5e4), (40.0,))
    np.testing.assert_allclose([p["windup_rad"], p["knee_nm"]], [40 * (1 / 2e4 - 1 / 5e4), 40.0])
    assert p["further_rad"] == 0 and p["sharpness"] == 1
    for single in (values_of_pieces((3e4,), ()), values_of_pieces((3e4, 3e4), (9.0,))):
        assert single["windup_rad"] == single["further_rad"] == single["sharpness"] == 0


def test_gap_is_half_of_the_smaller_bound() -> None:
    """Lost motion 1 arcmin at 96 N*m on 980 N*m/arcmin: 2 * 96 / 980 = 0.196 arcmin of it is elastic."""
    sheet = {"lost_motion": ARCMIN, "lost_motion_torque": 96.0}
    k = 980 / ARCMIN
    np.testing.assert_allclose(gap(reducer(k, **sheet)), [(1 - 192 / 980) / 2 * ARCMIN, ARCMIN / 2])
    np.testing.assert_allclose(gap(reducer(k, **sheet, backlash=0.5 * ARCMIN)), [0.25 * ARCMIN, 0.25 * ARCMIN])
    np.testing.assert_allclose(gap(reducer(k, lost_motion=ARCMIN)), [0.5 * ARCMIN, 0.5 * ARCMIN])
    np.testing.assert_allclose(gap(reducer(k / 10, **sheet)), [0, ARCMIN / 2])
    assert gap(reducer(k)) is None


def test_share_is_log_uniform() -> None:
    """Against numerical integration of p(f) = 1 / (f ln 10) over 0.1 ... 1."""
    mean, spread = share()
    density = [integrate.quad(lambda f, m=m: f**m / (f * np.log(1 / SOFTEST)), SOFTEST, 1)[0] for m in range(3)]
    np.testing.assert_allclose(density[0], 1)
    np.testing.assert_allclose([mean, spread], [density[1], np.sqrt(density[2] - density[1] ** 2)])
    np.testing.assert_allclose([mean, spread], [0.3909, 0.2494], atol=1e-4)


def test_the_band_holds_the_published_comparison() -> None:
    """67 N*m/arcmin (4020 N*m/deg) and the six joints that were measured on the same arm, N*m/deg: within 1.1 sd."""
    joints = np.array([1213.5, 1219.6, 1019.1, 1130.0, 986.66, 505.32]) / 4020
    mean, spread = share()
    assert joints.min() > SOFTEST and np.abs((joints - mean) / spread).max() < 1.1


def test_model_by_hand(tmp_path: Path) -> None:
    robot = load_robot(written(tmp_path, robot_text(RV, RV, STRAIN_WAVE, BARE, BARE, BARE)))
    model = datasheet_model(robot, "arm.toml")
    rigidity = np.array([980 / ARCMIN, 980 / ARCMIN, 4e4, *[100 / ARCMIN] * 3])
    np.testing.assert_allclose(model.values["joint-stiffness"]["k_nm_per_rad"], 0.39087 * rigidity, rtol=1e-4)
    np.testing.assert_allclose(model.sd["joint-stiffness"]["k_nm_per_rad"], 0.24940 * rigidity, rtol=1e-4)
    np.testing.assert_allclose(model.values["joint-hardening"]["windup_rad"], [0, 0, 5e-4, 0, 0, 0], atol=1e-12)
    np.testing.assert_allclose(model.values["joint-hardening"]["further_rad"], [0, 0, 1e-3, 0, 0, 0], atol=1e-12)
    np.testing.assert_allclose(model.sd["joint-hardening"]["windup_rad"][2:4], [2.5e-4, 5e-5])
    np.testing.assert_allclose(model.sd["joint-hardening"]["further_rad"][2:4], [5e-4, 0])
    np.testing.assert_allclose(model.values["joint-hardening"]["knee_nm"][2], 30)
    half = (1 - 192 / 980) / 2 * ARCMIN
    np.testing.assert_allclose(model.values["backlash"]["gap_rad"], [half, half, 0, 0, 0, 0])
    np.testing.assert_allclose(model.sd["backlash"]["gap_rad"], np.array([0.5, 0.5, 1, 1, 1, 1]) * ARCMIN)
    assert model.provenance["kind"] == "assumption" and model.provenance["gap_not_given"] == [
        f"joint-{k}" for k in (3, 4, 5, 6)
    ]
    assert "a sheet; another sheet; a third sheet" in model.provenance["source"] and not model.identified
    save_model(model, tmp_path / "model.toml")
    again = load_model(tmp_path / "model.toml")
    assert {e: {k: v.tolist() for k, v in p.items()} for e, p in again.values.items()} == {
        e: {k: v.tolist() for k, v in p.items()} for e, p in model.values.items()
    }
    assert dict(again.provenance) == dict(model.provenance)


def test_a_sheet_of_rigidities_alone_has_no_other_effect(tmp_path: Path) -> None:
    model = datasheet_model(load_robot(written(tmp_path, robot_text(*[BARE] * 6))), "arm.toml")
    assert list(model.values) == ["joint-stiffness"] and "gap_not_given" in model.provenance


def test_joints_without_data_are_named(tmp_path: Path) -> None:
    robot = load_robot(written(tmp_path, robot_text(RV, "", BARE, BARE, BARE)))
    with pytest.raises(RobotError, match="robot arm: no reducer data for joint-2, joint-6: give each a"):
        datasheet_model(robot, "arm.toml")
    with pytest.raises(RobotError, match=r"robot kuka-kr500: no reducer data for .*6: give"):
        datasheet_model(load_robot("kuka-kr500"), "kuka-kr500")
