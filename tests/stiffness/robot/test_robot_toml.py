"""Robot TOML files: both conventions, placements, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffness.errors import RobotError
from stiffness.robot.load import load_robot

ROW = "d = {d}\na = {a}\nalpha = {alpha}\noffset = {offset}\nsign = {sign}\nlimits = [-180.0, 180.0]\n"


def text(
    rows: list[tuple[float, ...]], convention: str = "classic", extra: str = "", name: str = "arm"
) -> str:
    head = (
        f'schema = "robot/1"\nname = "{name}"\nconvention = "{convention}"\nsources = ["a test"]\n{extra}\n'
    )
    keys = ("d", "a", "alpha", "offset", "sign")
    return head + "".join(
        "\n[[joints]]\n" + ROW.format(**dict(zip(keys, (*row[:4], int(row[4])), strict=True))) for row in rows
    )


# KUKA KR 500 R2830 in modified rows (public coursework): d, a, alpha, offset, sign.
KR500_MODIFIED = [
    (1045.0, 0.0, 0.0, 0.0, -1), (0.0, 500.0, -90.0, 0.0, 1), (0.0, 1300.0, 0.0, -90.0, 1),
    (1025.0, -55.0, -90.0, 0.0, -1), (0.0, 0.0, 90.0, 0.0, 1), (290.0, 0.0, -90.0, 180.0, -1),
]  # fmt: skip


def write(folder: Path, content: str, name: str = "arm") -> str:
    path = folder / f"{name}.toml"
    path.write_text(content)
    return str(path)


def test_modified_rows_are_the_same_robot_as_classic_rows(tmp_path: Path) -> None:
    """Two independent descriptions of the KR 500, one in each convention."""
    modified = load_robot(write(tmp_path, text(KR500_MODIFIED, "modified")))
    builtin = load_robot("kuka-kr500")
    for q in np.random.default_rng(0).uniform(-3, 3, (50, 6)):
        np.testing.assert_allclose(modified.pose(q), builtin.pose(q), atol=1e-12)


def test_base_and_flange_placements(tmp_path: Path) -> None:
    """rpy in deg, R = Rz Ry Rx; here a quarter turn about z, and one about x."""
    extra = "[base]\nxyz = [100.0, 200.0, 300.0]\nrpy = [0.0, 0.0, 90.0]\n"
    extra += "[flange]\nxyz = [0.0, 0.0, 50.0]\nrpy = [90.0, 0.0, 0.0]"
    plain = load_robot(write(tmp_path, text(KR500_MODIFIED, "modified"))).pose([0.1, -1, 1, 0.4, 0.5, 0.6])
    placed = load_robot(write(tmp_path, text(KR500_MODIFIED, "modified", extra))).pose(
        [0.1, -1, 1, 0.4, 0.5, 0.6]
    )
    base = np.array([[0, -1, 0, 0.1], [1, 0, 0, 0.2], [0, 0, 1, 0.3], [0, 0, 0, 1]])
    flange = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0.05], [0, 0, 0, 1]])
    np.testing.assert_allclose(placed, base @ plain @ flange, atol=1e-12)


def test_masses_are_optional_and_said_to_be_missing(tmp_path: Path) -> None:
    robot = load_robot(write(tmp_path, text(KR500_MODIFIED, "modified")))
    assert robot.mass is None
    assert np.isnan(robot.velocity).all()
    with pytest.raises(RobotError, match=r"no gravity torque without masses: .*arm.toml gives no masses"):
        robot.gravity_torque(np.zeros(6))


def test_relative_path_starts_from_the_folder(tmp_path: Path) -> None:
    write(tmp_path, text(KR500_MODIFIED, "modified"))
    assert load_robot("arm.toml", folder=tmp_path).name == "arm"


GOOD = text(KR500_MODIFIED, "modified")


@pytest.mark.parametrize(
    ("change", "to", "message"),
    [
        ('schema = "robot/1"', 'schema = "robot/2"', "schema = 'robot/2'"),
        ('schema = "robot/1"\n', "", "key schema is missing"),
        ('sources = ["a test"]', 'sources = ["a test"]\ncolour = "orange"', "unknown key colour"),
        ("d = 1045.0", "d = 1045.0\nmas = 5.0", "unknown key joints.1.mas"),
        ("d = 1045.0\n", "", "key joints.1.d is missing"),
        ("d = 1045.0", 'd = "1045"', "joints.1.d = '1045'"),
        ("d = 1045.0", "d = nan", "joints.1.d = nan"),
        ("d = 1045.0", "d = 1.0e9", r"joints.1.d = 1000000000.0"),
        ("alpha = 0.0", "alpha = 900.0", "joints.1.alpha = 900.0"),
        ("sign = -1", "sign = 2", "joints.1.sign = 2"),
        ("limits = [-180.0, 180.0]", "limits = [180.0, -180.0]", r"joints.1.limits = \[180.0, -180.0\]"),
        ("limits = [-180.0, 180.0]", "limits = [-180.0]", r"joints.1.limits = \[-180.0\]: there is 1, expected 2"),
        ("limits = [-180.0, 180.0]", "limits = [-180.0, 180.0]\nspeed = 0.0", "joints.1.speed = 0.0"),
        ("limits = [-180.0, 180.0]", "limits = [-180.0, 180.0]\nmass = -3.0", "joints.1.mass = -3.0"),
        ('convention = "modified"', 'convention = "craig"', "convention = 'craig'"),
        ('name = "arm"', 'name = "leg"', "name = 'leg', expected the name of the file, 'arm'"),
        ('name = "arm"', 'name = "arm', "is not TOML"),
    ],
)
def test_refused(tmp_path: Path, change: str, to: str, message: str) -> None:
    assert change in GOOD
    path = write(tmp_path, GOOD.replace(change, to, 1))
    with pytest.raises(RobotError, match=message) as caught:
        load_robot(path)
    assert "arm.toml" in str(caught.value)


def test_masses_of_some_joints_only_are_refused(tmp_path: Path) -> None:
    mass = "limits = [-180.0, 180.0]\nmass = 3.0\ncom = [0.0, 0.0, 1.0]"
    path = write(tmp_path, GOOD.replace("limits = [-180.0, 180.0]", mass, 2))
    with pytest.raises(RobotError, match=r"not for \[3, 4, 5, 6\]"):
        load_robot(path)
    path = write(tmp_path, GOOD.replace("limits = [-180.0, 180.0]", "limits = [-180.0, 180.0]\nmass = 3.0"))
    with pytest.raises(RobotError, match="both mass and com"):
        load_robot(path)


def test_five_joints_are_refused(tmp_path: Path) -> None:
    with pytest.raises(RobotError, match="5 joints between base and flange, expected 6"):
        load_robot(write(tmp_path, text(KR500_MODIFIED[:5], "modified")))


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(RobotError, match=r"nowhere.toml: there is no such file"):
        load_robot("nowhere.toml", folder=tmp_path)
