"""What an effect that was learned over part of a joint's range leaves open along a path."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from compensator.solve.uncertainty import error_band
from compensator.solve.unlearned_angles import AngleUncertainty, levers
from compensator.tasks.compensate import compensate_file, preview_file
from stiffness.effects import BY_NAME
from stiffness.effects.joint_angle_error import KNOTS, SPREAD
from stiffness.robot.load import load_robot
from tests.compensator.small_job import ABB, STIFFNESS, files

Floats = npt.NDArray[np.float64]
NAME = "joint-angle-error"
DEGREES = -180 + 3 * np.arange(KNOTS)
SD = 2e-5


def tables(gaps: dict[int, tuple[float, float]]) -> dict[str, dict[str, Floats]]:
    """Learned everywhere to 0.02 mrad, but for joints (from 1) between two angles in deg, where a knot is zero."""
    values, sd = np.full((6, KNOTS), 3e-4), np.full((6, KNOTS), SD)
    for joint, (low, high) in gaps.items():
        inside = (low <= DEGREES) & (high >= DEGREES)
        values[joint - 1, inside], sd[joint - 1, inside] = 0.0, 7e-4
    whole = BY_NAME[NAME].neutral(6) | {"error_rad": values.ravel()}
    return {"values": whole, "sd": {"error_rad": sd.ravel()}}


def unsure(gaps: dict[int, tuple[float, float]]) -> AngleUncertainty:
    given = tables(gaps)
    return AngleUncertainty(load_robot(ABB), [BY_NAME[NAME]], {NAME: given["values"]}, {NAME: given["sd"]})


def model(gaps: dict[int, tuple[float, float]]) -> dict[str, Any]:
    given = tables(gaps)
    own = {"error_rad": given["values"]["error_rad"].tolist(), "sd_error_rad": given["sd"]["error_rad"].tolist()}
    return {"effects": {"joint-stiffness": {"k_nm_per_rad": STIFFNESS}, NAME: own}}


def postures(**degrees: tuple[float, float]) -> Floats:
    """(61, 6) rad: joints q1 ... q6 that move from one angle to another in even steps."""
    q = np.tile(np.radians([10.0, 20.0, 15.0, 40.0, 50.0, 60.0]), (61, 1))
    for name, (low, high) in degrees.items():
        q[:, int(name[1]) - 1] = np.radians(np.linspace(low, high, 61))
    return q


def test_a_lever_is_the_jacobian_about_the_tcp() -> None:
    robot, rng = load_robot(ABB), np.random.default_rng(3)
    q, tcp = rng.uniform(-1.5, 1.5, (5, 6)), rng.uniform(-0.3, 0.3, (5, 3))
    for a, point, got in zip(q, tcp, levers(robot, q, tcp), strict=True):
        jacobian, arm = robot.jacobian(a), robot.pose(a)[:3, :3] @ point
        moved = jacobian[:3] + np.cross(jacobian[3:].T, arm).T
        np.testing.assert_allclose(got, np.linalg.norm(moved, axis=0), rtol=1e-9, atol=1e-12)


def test_standard_deviations_of_joints_add_as_squares_at_the_tcp() -> None:
    """Draws of the joints' errors, through Pinocchio's kinematics, scatter the TCP by as much."""
    robot, rng = load_robot(ABB), np.random.default_rng(4)
    here = unsure({3: (0, 30)})
    q, tcp = np.round(postures()[:1] / np.radians(3)) * np.radians(3), np.array([[0.03, -0.02, 0.24]])
    sd = np.full(6, SD)
    sd[2] = SPREAD
    np.testing.assert_allclose(here.angles(BY_NAME[NAME], q), sd[None], rtol=1e-6)

    def at(angles: Floats) -> Floats:
        pose = robot.pose(angles)
        return pose[:3, :3] @ tcp[0] + pose[:3, 3]

    off = np.array([at(q[0] + e) for e in rng.normal(size=(4000, 6)) * sd]) - at(q[0])
    expected = np.sqrt(np.mean(np.sum(off**2, axis=1)))
    assert here.at_tcp(q, tcp)[0] == pytest.approx(expected, rel=0.04) and expected > 2e-4


def test_angles_nobody_saw_are_named_by_joint_and_range() -> None:
    here, tcp = unsure({3: (-20, 10), 5: (60, 90)}), np.tile([0.0, 0.0, 0.2], (61, 1))
    q = postures(q3=(-30, 30), q5=(57, 27))
    (only,) = here.not_learned(q, tcp)
    assert (only.effect, only.joint) == (NAME, 3)
    # knots -18 ... 9: the value there is zero; a degree of the way to the next knot it is no more
    assert np.degrees([only.low, only.high]) == pytest.approx([-18.0, 9.0], abs=1.01)
    rows = (q[:, 2] >= only.low) & (q[:, 2] <= only.high)
    assert only.poses == rows.sum() and 27 <= only.poses <= 30
    lever = levers(load_robot(ABB), q, tcp)[:, 2]
    on_knots = rows & (np.abs(np.degrees(q[:, 2]) % 3) < 1e-6)
    assert only.sd == pytest.approx(SPREAD * lever[on_knots].max(), rel=1e-3) and only.sd > 4e-4
    assert str(only).startswith(f"{NAME} of joint 3 was not learned between {np.degrees(only.low):.1f} and ")
    assert str(only).endswith(f"the TCP is uncertain by {only.sd * 1e3:.2g} mm (one sd) more")


def test_two_gaps_of_one_joint_are_two() -> None:
    """Also where no pose stands between them: the table knows what lies there."""
    given = tables({2: (-60, -40)})
    table, sd = (given[k]["error_rad"].reshape(6, KNOTS) for k in ("values", "sd"))
    again = (DEGREES >= 40) & (DEGREES <= 60)
    table[1, again], sd[1, again] = 0.0, 7e-4
    here = AngleUncertainty(load_robot(ABB), [BY_NAME[NAME]], {NAME: given["values"]}, {NAME: given["sd"]})
    q = np.concatenate([postures(q2=(-55, -45)), postures(q2=(45, 50))])
    found = here.not_learned(q, np.zeros((122, 3)))
    assert [(f.joint, f.poses) for f in found] == [(2, 61), (2, 61)]
    np.testing.assert_allclose(np.degrees([[f.low, f.high] for f in found]), [[-55, -45], [45, 50]])
    over = here.not_learned(postures(q2=(-60, 60)), np.zeros((61, 3)))
    assert [f.joint for f in over] == [2, 2] and over[0].high < np.radians(-38) < np.radians(38) < over[1].low


def test_one_angle_and_full_turns() -> None:
    here, q = unsure({4: (30, 60)}), postures()
    (still,) = here.not_learned(q, np.zeros((61, 3)))
    assert (still.joint, still.poses, still.low) == (4, 61, still.high) and "at 40.0 deg:" in str(still)
    (turned,) = here.not_learned(q + np.radians([0, 0, 0, 360, 0, 0]), np.zeros((61, 3)))
    assert np.degrees(turned.low) == pytest.approx(400) and turned.sd == pytest.approx(still.sd)


def test_what_was_learned_badly_is_not_called_unlearned() -> None:
    """A value with a standard deviation as large as the spread still acts; what is next to zero does not."""
    given = tables({})
    given["sd"]["error_rad"][:] = SPREAD
    given["values"]["error_rad"][2 * KNOTS : 3 * KNOTS] = 1e-4
    loose = AngleUncertainty(load_robot(ABB), [BY_NAME[NAME]], {NAME: given["values"]}, {NAME: given["sd"]})
    assert loose.not_learned(postures(q3=(-30, 30)), np.zeros((61, 3))) == []
    given["values"]["error_rad"][2 * KNOTS : 3 * KNOTS] = 1e-22  # what rounding makes of a knot nobody saw
    rounded = AngleUncertainty(load_robot(ABB), [BY_NAME[NAME]], {NAME: given["values"]}, {NAME: given["sd"]})
    (only,) = rounded.not_learned(postures(q3=(-30, 30)), np.zeros((61, 3)))
    assert (only.joint, only.poses) == (3, 61)


def test_nothing_to_say_of_other_effects() -> None:
    none = AngleUncertainty(load_robot(ABB), [BY_NAME["joint-stiffness"]], {"joint-stiffness": {}}, {})
    tcp = np.zeros((61, 3))
    assert none.not_learned(postures(), tcp) == [] and not none.at_tcp(postures(), tcp).any()


def test_the_summary_of_compensate_and_preview_says_so(tmp_path: Path) -> None:
    job = files(tmp_path, model=model({1: (-180, 177)}))
    done = compensate_file(job.toolpath, job.cell, job.out / "a.csv", json=job.out / "a.json")
    shown = preview_file(job.toolpath, job.cell, json=job.out / "p.json")
    cut = done.result.cutting
    for report, name, q in ((done.report, "a", done.result.command.q), (shown.report, "p", shown.result.path.q)):
        assert json.loads((job.out / f"{name}.json").read_text()) == report
        (only,) = report["not_learned"]
        angle = np.degrees(q[cut, 0])
        assert list(only) == ["effect", "joint", "from_deg", "to_deg", "poses", "share_of_poses", "sd_mm"]
        assert only["share_of_poses"] == 1.0
        assert (only["effect"], only["joint"], only["poses"]) == (NAME, 1, report["n_cut"])
        assert [only["from_deg"], only["to_deg"]] == pytest.approx([angle.min(), angle.max()])
        # joint 1 of a standing arm turns the TCP about the vertical
        away = np.linalg.norm(done.result.path.tcp.origin[cut, :2], axis=1)
        assert SPREAD * away.max() * 0.7e3 < only["sd_mm"] < SPREAD * away.max() * 1.01e3
        assert report["left_open_mm"]["max"] == pytest.approx(only["sd_mm"], rel=0.02)
        said = [n for n in report["notes"] if n.startswith(f"{NAME} of joint 1 was not learned")]
        assert len(said) == 1 and f"{only['from_deg']:.1f} and {only['to_deg']:.1f} deg" in said[0]


def test_a_table_learned_everywhere_leaves_its_noise_open(tmp_path: Path) -> None:
    job = files(tmp_path, model=model({}))
    report = preview_file(job.toolpath, job.cell).report
    assert report["not_learned"] == [] and not [n for n in report["notes"] if "not learned" in n]
    assert 0.02 < report["left_open_mm"]["mean"] <= report["left_open_mm"]["max"] < 0.2
    plain = preview_file(files(tmp_path).toolpath, job.cell).report
    assert plain["not_learned"] == [] and plain["left_open_mm"] == {"mean": 0.0, "p95": 0.0, "max": 0.0}


def test_the_band_holds_what_tables_leave_open(tmp_path: Path) -> None:
    """By joint: its standard deviation times the velocity of the TCP, of Pinocchio, along the error."""
    job = files(tmp_path, {}, model({}))
    result = preview_file(job.toolpath, job.cell).result
    band, rows = error_band(result), np.flatnonzero(result.cutting)
    assert band is not None and len(rows) <= 400  # all cutting poses are looked at
    robot, q = load_robot(ABB), result.path.q[rows]
    along = result.error_before[rows] / np.linalg.norm(result.error_before[rows], axis=1)[:, None]
    sd = unsure({}).angles(BY_NAME[NAME], q)
    expected = []
    for a, tip, way, own in zip(q, result.path.tcp.origin[rows], along, sd, strict=True):
        jacobian = robot.jacobian(a)
        moved = jacobian[:3] + np.cross(jacobian[3:].T, tip - robot.pose(a)[:3, 3]).T
        expected.append(own * (way @ moved))
    found = band.shift[NAME][:, : len(rows)].T
    assert np.abs(found).max() > 1e-5
    np.testing.assert_allclose(found, expected, atol=0.01 * np.abs(found).max())
