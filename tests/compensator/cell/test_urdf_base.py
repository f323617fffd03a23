"""The frame of a URDF that positions are measured from: in a new cell, in its program, and in cells that name none."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import tomli_w
from click.testing import CliRunner

from compensator.cell.arm import load_arm
from compensator.cell.cell_file import load_cell
from compensator.cli import main
from compensator.errors import CellError, CompensatorError
from compensator.tasks.compensate import compensate_file, preview_file
from compensator.tasks.init import init_files
from stiffness.robot.load import load_robot
from tests.compensator.framed_arm import FRAMED, arm, fixed, urdf
from tests.compensator.small_job import MODEL, ROWS, Files, columns, files

# where the part lies on the display of the controller, mm and deg; mm from the root to the controller's base
ARMS = {
    "framed": ("900 -700 -65 0 0 30", np.linalg.norm([100.0, 200.0, 850.0])),
    "fanuc_official_m710ic_50": ("1200 -150 -65 0 0 30", 565.0),
}
POINTS = np.array([row[:3] for row in ROWS], dtype=float)


@pytest.fixture(params=ARMS)
def new_cell(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Files:
    """Written by `init` for the robot in its parameter, which is made rigid: commands are where the part is."""
    job = files(tmp_path)
    job.cell.unlink()
    (tmp_path / "model.toml").unlink()
    monkeypatch.chdir(tmp_path)
    name = request.param
    text = FRAMED
    if name != "framed":
        text = (request.getfixturevalue("shared") / "data" / "robots" / f"{name}.urdf").read_text()
    (tmp_path / f"{name}.urdf").write_text(text)
    part, away = ARMS[name]
    answers = ("--robot", f"{name}.urdf", "--tool", "30 -20 240 5", "--part", part, "--cam", "path.csv")
    done = CliRunner().invoke(main, ["init", *answers, "--stiffness", "unknown", "--controller", "fanuc"])
    assert done.exit_code == 0, done.output
    assert 'base = "wbase": the part is taken as measured from this frame of the URDF' in done.stderr
    assert f"seen from 'world', 'wbase' stands {away:.4g} mm away" in done.stderr
    model = tomllib.loads((tmp_path / "stiffness.toml").read_text())
    assert model["base"] == "wbase"
    model["effects"]["joint-stiffness"] = {"k_nm_per_rad": [1e12] * 6}
    (tmp_path / "stiffness.toml").write_text(tomli_w.dumps(model))
    return job


def homogeneous(xyz: np.ndarray, rpy: np.ndarray) -> np.ndarray:
    """mm and deg; Rz Ry Rx of roll, pitch, yaw, as Fanuc's W, P, R."""
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = pin.rpy.rpyToMatrix(*np.radians(rpy)), xyz
    return out


def positions(program: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A reading of a Fanuc program of its own: UFRAME, UTOOL (4, 4) and all positions (N, 4, 4), mm."""
    found = re.findall(r"PR\[9,\d\]=\(?(-?[\d.]+)\)? ;", program)
    frame, tool = (homogeneous(v[:3], v[3:]) for v in np.array(found, dtype=float).reshape(2, 6))
    number = r" *=\s*(-?[\d.]+)\s+(?:mm|deg)[,\s]*"
    rows = np.array(re.findall("".join(k + number for k in "XYZWPR"), program), dtype=float)
    return frame, tool, np.array([homogeneous(v[:3], v[3:]) for v in rows])


def in_world(robot: Path, frame: str, q: np.ndarray) -> np.ndarray:
    """(4, 4) mm, where Pinocchio's own reading of the URDF has a frame; the six joints of the arm in their order."""
    model = pin.buildModelFromUrdf(str(robot))
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    out = np.array(data.oMf[model.getFrameId(frame)].homogeneous)
    out[:3, 3] *= 1e3
    return out


def test_the_tcp_reaches_the_part_in_the_world(new_cell: Files) -> None:
    """Program, joints and display agree: the controller's base times its numbers is where the joints bring the tool."""
    cell = tomllib.loads(new_cell.cell.read_text())
    robot, part = new_cell.folder / cell["robot"], np.array(ARMS[Path(cell["robot"]).stem][0].split(), dtype=float)
    assert cell["base"] == "wbase" and cell["tip"] == "fanuc_flange"
    done = compensate_file(new_cell.toolpath, new_cell.cell, new_cell.out / "a.ls")
    assert not [f for f in done.findings if "measured from" in f.what]
    compensate_file(new_cell.toolpath, new_cell.cell, new_cell.out / "a.csv")
    frame, tool, targets = positions((new_cell.out / "a.ls").read_text())
    angles = np.radians(columns(new_cell.out / "a.csv", *(f"q{k}_deg" for k in range(1, 7))))
    nominal = columns(new_cell.out / "a.csv", "nominal_x_mm", "nominal_y_mm", "nominal_z_mm")
    assert len(targets) == len(angles) > 10
    base = in_world(robot, "wbase", np.zeros(6))
    lies = base @ homogeneous(part[:3], part[3:])  # the display is in the controller's base
    corners = 0
    for target, q, point in zip(targets, angles, nominal, strict=True):
        told = base @ frame @ target
        reached = in_world(robot, "fanuc_flange", q) @ tool
        np.testing.assert_allclose(told[:3, 3], (lies @ [*point, 1.0])[:3], atol=2e-3)
        np.testing.assert_allclose(reached[:3, 3], told[:3, 3], atol=2e-3)
        np.testing.assert_allclose(reached[:3, :3], told[:3, :3], atol=1e-5)
        corners += bool(np.any(np.all(np.abs(POINTS - point) < 1e-6, axis=1)))
    assert corners == len(POINTS)


def test_the_same_cell_without_the_key_is_warned_of_and_means_the_root(new_cell: Files) -> None:
    """The numbers that it had: those of the root, which is not where the display measures from."""
    robot = Path(tomllib.loads(new_cell.cell.read_text())["robot"])
    rows = []
    for base in (None, "world"):
        for file in (new_cell.cell, new_cell.folder / "stiffness.toml"):
            table = {**tomllib.loads(file.read_text()), "base": base}
            if "workobject" in table:
                table["workobject"]["xyz"][2] = 500.0  # within reach of the arm, measured from the root
            file.write_text(tomli_w.dumps({k: v for k, v in table.items() if v is not None}))
        done = preview_file(new_cell.toolpath, new_cell.cell, csv=new_cell.out / "a.csv")
        found = [f for f in done.findings if "positions in the base" in f.what]
        assert len(found) == (base is None)
        rows.append(columns(new_cell.out / "a.csv", *(f"q{k}_deg" for k in range(1, 7))))
        if base is None:
            away = f"{ARMS[robot.stem][1]:.4g}"
            assert found[0].level == "warning"
            assert re.search(rf"from 'world', the root of the URDF; 'wbase' stands {away} mm away", found[0].what)
            assert 'write base = "wbase" in cell and model; if not, base = "world" in the cell' in found[0].remedy
    np.testing.assert_array_equal(*rows)
    table = tomllib.loads(new_cell.cell.read_text())
    flange, tool = in_world(robot, "fanuc_flange", np.radians(rows[0][0])), table["tool"]["xyz"]
    part = homogeneous(np.array(table["workobject"]["xyz"]), np.array(table["workobject"]["rpy"]))
    np.testing.assert_allclose(flange @ [*tool, 1.0], part @ [*POINTS[0], 1.0], atol=2e-3)


@pytest.mark.parametrize(
    ("text", "base", "expected"),
    [
        (FRAMED, "world", ("wbase", 1e3 * np.linalg.norm([0.1, 0.2, 0.85]), True)),
        (urdf(), "world", None),
        (urdf(fixed("base_link", "base", "0 0 0.55")), "base", ("base", 0.0, True)),
        (urdf(fixed("world", "base", "0 0 0.2")), "base", ("base", 0.0, True)),
        # Fanuc's own name is of one meaning; `base` may be anything
        (urdf(fixed("world", "base"), fixed("base_link", "wbase", "0.03 0 0.04")), "base", ("wbase", 420.356, True)),
        # a name that ends so counts only beside the base_link of the same prefix
        (urdf(fixed("world", "pedestal_base"), fixed("base_link", "camera_base")), "world", None),
        (FRAMED.replace('"wbase"', '"r1_wbase"'), "world", ("r1_wbase", 878.92, True)),
        (urdf(fixed("base_link", "wbase", "0 0 0.5", "1.5 0 0")), "world", ("wbase", 830.66, False)),
        # of two arms the frame beside the own one
        (
            urdf(
                arm("b_"), fixed("b_base_link", "b_base", "0 0 1"), fixed("base_link", "base", "0 0 0.1"),
                '<joint name="b" type="fixed"><parent link="world"/><child link="b_base_link"/></joint>',
            ), "base", ("base", 0.0, True),
        ),
    ],
)  # fmt: skip
def test_which_frame_is_taken(text: str, base: str, expected: tuple | None, tmp_path: Path) -> None:
    (tmp_path / "r.urdf").write_text(text)
    tip = "fanuc_flange" if "b_J6" in text else None
    robot = load_robot(str(tmp_path / "r.urdf"), tip=tip)
    assert robot.base == base
    found = robot.base_frame
    assert (found is None) == (expected is None)
    if found is not None:
        assert (found.name, found.on_axis) == (expected[0], expected[2])
        assert found.distance * 1e3 == pytest.approx(expected[1], abs=0.01)
    named = load_robot(str(tmp_path / "r.urdf"), base="world", tip=tip)
    assert named.base == "world" and named.base_frame is None


@pytest.mark.parametrize(
    ("name", "base", "away"),
    [
        ("abb_irb6640_185_280", "base", 0.0),
        ("kuka_kr210_r2700_2", "base", 0.0),
        ("motoman_mh50", "base", 0.0),
        ("staubli_rx160", "base", 0.0),
        ("ur10_robot", "base", 0.0),
        ("fanuc_official_m710ic_50", "wbase", 565.0),
        ("fanuc_official_crx10ia_l", "wbase", 995.0),
    ],
)
def test_the_frame_of_real_arms(name: str, base: str, away: float, shared: Path) -> None:
    """As Pinocchio places it, seen from the link that is taken where the cell names none."""
    file = shared / "data" / "robots" / f"{name}.urdf"
    robot = load_robot(str(file))
    assert (robot.base_frame.name, robot.base_frame.on_axis, robot.base_frame.mount) == (base, True, None)
    assert robot.base_frame.distance * 1e3 == pytest.approx(away, abs=1e-9)
    model = pin.buildModelFromUrdf(str(file))
    q = np.radians([20.0, -30.0, 25.0, 40.0, 50.0, -60.0])
    full = pin.neutral(model)
    for joint, angle in zip(robot.joint_names, q, strict=True):
        full[model.joints[model.getJointId(joint)].idx_q] = angle
    theirs = np.linalg.inv(in_world(file, base, full)) @ in_world(file, robot.tip, full)
    ours = load_robot(str(file), base=base).pose(q)
    np.testing.assert_allclose(ours[:3, 3] * 1e3, theirs[:3, 3], atol=1e-6)
    np.testing.assert_allclose(ours[:3, :3], theirs[:3, :3], atol=1e-9)


def test_the_second_of_two_arms_has_its_own_frame(tmp_path: Path) -> None:
    beside = '<joint name="b" type="fixed"><parent link="world"/><child link="b_base_link"/></joint>'
    text = urdf(arm("b_"), fixed("b_base_link", "b_base", "0 0 1"), fixed("base_link", "wbase"), beside)
    (tmp_path / "r.urdf").write_text(text)
    found = load_robot(str(tmp_path / "r.urdf"), tip="b_fanuc_flange").base_frame
    assert (found.name, found.distance) == ("b_base", pytest.approx(1.0))


def question(folder: Path, text: str) -> dict[str, str]:
    """Answers to `init` about a URDF."""
    job = files(folder)
    (folder / "r.urdf").write_text(text)
    asked = {"robot": str(folder / "r.urdf"), "tool": "0 0 240 30", "part": "900 0 0", "cam": str(job.toolpath)}
    return {**asked, "stiffness": "unknown", "controller": "krl"}


@pytest.mark.parametrize(
    ("text", "base", "words"),
    [
        (urdf(fixed("base_link", "base", "0 0 0.55")), "base", "base = .base.: the part is taken as measured from"),
        (urdf(), None, "neither base nor wbase: the part is taken as measured from 'world', its root"),
        (FRAMED.replace('rpy="0 0 1.2"', 'rpy="1.5 0 0"'), "wbase", "whose z is not along axis 1"),
        (
            urdf(fixed("base_link", "wbase", "0 0 0.55"), stand=("0 0 3", "3.141592653589793 0 0")),
            "wbase",
            r"tilted in the root.*give \[mount\] rpy = \[180, 0, 0\]: gravity is -z of the world",
        ),
    ],
)
def test_what_init_says_of_the_base(text: str, base: str | None, words: str, tmp_path: Path) -> None:
    done = init_files(question(tmp_path, text), output=tmp_path / "n.toml")
    assert tomllib.loads((tmp_path / "n.toml").read_text()).get("base") == base
    said = [f for f in done.report["findings"] if "the part is taken" in f["what"]]
    assert len(said) == 1 and re.search(words, f"{said[0]['what']}. {said[0]['remedy']}")
    assert (said[0]["level"] == "note") == (base == "base")


def test_a_cell_of_a_tilted_arm_is_told_its_mount(tmp_path: Path) -> None:
    """The root is upright, the controller's base is not: named without [mount], gravity would pull sideways."""
    text = urdf(fixed("base_link", "wbase", "0 0 0.55"), stand=("0 0 3", "0 0.5235987756 0"))
    (tmp_path / "r.urdf").write_text(text)
    job = files(tmp_path, {"robot": "r.urdf", "tip": "fanuc_flange"}, {"robot": "r.urdf", "tip": "fanuc_flange"})
    (found,) = load_arm(load_cell(job.cell)).findings
    assert 'base = "wbase" in cell and model, and [mount] rpy = [0, 30, 0] in the cell; if not' in found.remedy


SOFT = {"base-compliance": {"linear_m_per_n": [1e-8] * 3, "angular_rad_per_nm": [1e-8] * 3}}


@pytest.mark.parametrize(
    ("cell", "model", "words"),
    [
        ("wbase", "world", r'those of joints and hold for any base of the arm: set base = "wbase" in the model'),
        (None, "wbase", r'positions measured from wbase, as controllers do, write base = "wbase" here; if they are'),
        ("base_link", "world", r'hold for any base of the arm: set base = "base_link" in the model'),
    ],
)
def test_the_model_of_another_base(cell: str | None, model: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "r.urdf").write_text(FRAMED)
    tip = {"robot": "r.urdf", "tip": "fanuc_flange"}
    job = files(tmp_path, {**tip, "base": cell}, {**tip, "base": model})
    with pytest.raises(CellError, match=words):
        preview_file(job.toolpath, job.cell)


def test_what_of_a_model_is_bound_to_its_base(tmp_path: Path) -> None:
    (tmp_path / "r.urdf").write_text(FRAMED)
    tip = {"robot": "r.urdf", "tip": "fanuc_flange"}
    made = {**tip, "base": "world", "effects": {**MODEL["effects"], **SOFT}}
    job = files(tmp_path, {**tip, "base": "wbase"}, made)
    with pytest.raises(CellError, match=r"its base-compliance is in the axes of its own base: identify it again"):
        preview_file(job.toolpath, job.cell)


def test_a_known_model_of_another_base_is_refused_by_init(tmp_path: Path) -> None:
    asked = question(tmp_path, FRAMED)
    files(tmp_path, {}, {"robot": "r.urdf"})
    with pytest.raises(CompensatorError, match=r"base 'world' and tip 'J6_link', the cell has 'wbase' and 'fanuc_fl"):
        init_files({**asked, "stiffness": str(tmp_path / "model.toml")}, output=tmp_path / "n.toml")
    assert not (tmp_path / "n.toml").exists()


@pytest.mark.parametrize(("link", "taken"), [("r1_wbase", "r1_wbase"), ("sawbase", None)])
def test_a_link_whose_name_only_ends_like_a_base_is_none(link: str, taken: str | None, tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(urdf(fixed("base_link", link, "0 0 0.55")))
    frame = load_robot(str(tmp_path / "arm.urdf")).base_frame
    assert (None if frame is None else frame.name) == taken
