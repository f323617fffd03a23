"""What is read of VAL3 programs: against the second reader; frames, tools, speeds and assignments by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.contracts.languages.val3 import DATA, SET, WHOLE, program
from tests.oracles import val3_reader
from tests.oracles.sample_programs import random_program, small
from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath, refuse_own, write_program
from toolpaths.rotation import matrix_from_quaternion
from toolpaths.toolpath import CUT, Toolpath
from toolpaths.writing.program import Program


def read(tmp_path: Path, text: str, data: str = "") -> Toolpath:
    (tmp_path / "part.pgx").write_text(text)
    if data:
        (tmp_path / "part.dtx").write_text(data)
    return read_toolpath(tmp_path / "part.pgx")


@pytest.mark.parametrize("given", [small(), random_program(300, 5, "R"), random_program(12_000, 6, "LONG")])
@pytest.mark.parametrize("name", ["part", "start"])
def test_the_second_reader_agrees_on_what_the_writer_wrote(tmp_path: Path, given: Program, name: str) -> None:
    """Poses in the work object, speeds, tools, corners, joints; from the program, and from start() that calls it."""
    write_program(given, tmp_path / "part.pgx")
    path = read_toolpath(tmp_path / f"{name}.pgx")
    app = val3_reader.read(tmp_path / "part.pjx")
    assert len(path) == len(app.moves) and path.quaternion is not None and path.setting is not None
    cut = path.kind == CUT
    np.testing.assert_array_equal(cut, [m.word == "movel" for m in app.moves])
    lines = [m for m in app.moves if m.word == "movel"]
    pose = np.array([val3_reader.pose(app, m.target) for m in lines])
    np.testing.assert_allclose(path.position[cut], pose[:, :3, 3] * 1e-3, rtol=0, atol=1e-12)
    np.testing.assert_allclose(matrix_from_quaternion(path.quaternion[cut]), pose[:, :3, :3], rtol=0, atol=1e-9)
    np.testing.assert_allclose(path.feed[cut], [m.mdesc["tmax"] * 1e-3 for m in lines], rtol=1e-12)
    corner = [m.mdesc["leave"] * 1e-3 if m.mdesc["blend"] == "Cartesian" else 0.0 for m in lines]
    zones = path.setting.zones
    assert zones is not None and path.setting.workobject is not None
    np.testing.assert_allclose(zones[cut], corner, rtol=0, atol=1e-15)
    joints = [m.target for m in app.moves if m.word == "movej"]
    for (_, q), m in zip(sorted(path.setting.joints.items()), joints, strict=True):
        np.testing.assert_allclose(np.degrees(q), [m[f"j{i}"] for i in range(1, 7)], atol=1e-12)
    np.testing.assert_allclose(path.setting.workobject.matrix, given.workobject.matrix, rtol=0, atol=1e-7)
    np.testing.assert_allclose(path.setting.tools[1].frame.matrix, given.tools[1].frame.matrix, rtol=0, atol=1e-7)


def test_what_the_writer_wrote_is_not_compensated_again(tmp_path: Path) -> None:
    write_program(small(), tmp_path / "part.pgx")
    with pytest.raises(ReadError, match="compensated already"):
        refuse_own(tmp_path / "part.pgx")


def test_frames_tools_and_arcs(tmp_path: Path) -> None:
    path = read(tmp_path, WHOLE, DATA)
    setting = path.setting
    assert setting is not None and setting.workobject is not None
    frame = np.eye(4)
    frame[:3, :3] = Rotation.from_euler("x", 10, degrees=True).as_matrix()
    frame[:3, 3] = [0.8, -0.1, 0.2]
    np.testing.assert_allclose(setting.workobject.matrix, frame, atol=1e-12)
    np.testing.assert_allclose(setting.tools[1].frame.origin, [0, 0, 0.18], atol=1e-12)  # tMill[1] in tMill[0]
    np.testing.assert_allclose(np.degrees(setting.joints[0]), [0, -20, 95, 0, 45, 0], atol=1e-12)
    np.testing.assert_allclose(path.position[1] * 1e3, [1, 2, 33], atol=1e-9)  # appro: 30 mm back along the tool
    np.testing.assert_allclose(path.position[2] * 1e3, [1, 2, 3], atol=1e-9)
    arc = path.position[(path.row > 2) & (path.row <= 3)] * 1e3
    center = np.array([11.0, 12.5, 3.0])  # of the circle through (1, 2), (11, -2), (21, 2): 10^2 + 10.5^2 = 14.5^2
    assert len(arc) > 10
    np.testing.assert_allclose(np.linalg.norm(arc - center, axis=1), 14.5, atol=1e-9)
    assert setting.zones is not None and setting.zones[2] == pytest.approx(0.5e-3)
    np.testing.assert_allclose(path.feed[path.kind == CUT], 0.02)
    assert path.events[0].word == "a comment" and "do5=true" in [e.word for e in path.events]


def test_what_is_assigned_counts_from_there_on(tmp_path: Path) -> None:
    path = read(tmp_path, program(
        *SET, "movel(pa,t,m)", "pa.trsf.x=40", "m.tvel=7.5", "m.blend=joint", "m.leave=2", "m.reach=3", "movel(pa,t,m)",
        "m.blend=off", "movel(p5,t,m)", "if nCount>3", "nCount=nCount+1", "endIf", "movel(pa,flange[0],m)",
    ))  # fmt: skip
    np.testing.assert_allclose(path.position[1:, 0] * 1e3, [12.5, 40, 0, 40], atol=1e-12)
    np.testing.assert_allclose(path.feed[1:] * 1e3, [10, 7.5, 7.5, 7.5])
    assert path.setting is not None and path.setting.zones is not None
    np.testing.assert_allclose(path.setting.zones[2:4] * 1e3, [3.0, 0.0])
    assert path.tool.tolist() == [1, 1, 1, 1, 0]


def test_programs_and_data_beside(tmp_path: Path) -> None:
    """The project says which data belong to the program; frames of a library are the controller's."""
    (tmp_path / "mill.pgx").write_text(program("movel(pW[0],tMill[0],mCut)", locals_="").replace("part", "mill"))
    (tmp_path / "shop.dtx").write_text(DATA.replace("world[0]", "lib:fTable[0]"))
    files = "".join(f'<Program file="{name}.pgx" />' for name in ("part", "mill"))
    (tmp_path / "shop.pjx").write_text(
        f'<Project><Parameters millimeterUnit="true" />{files}<Database><Data file="shop.dtx" /></Database></Project>'
    )
    path = read(tmp_path, program("movej(jHome,tMill[0],mCut)", "call mill()", "call lib:grip()", locals_=""))
    np.testing.assert_allclose(path.position[1] * 1e3, [1, 2, 3], atol=1e-12)
    assert path.setting is not None and path.setting.workobject is None
    assert path.file is not None and path.file.tolist() == [0, 1]
    (tmp_path / "shop.pjx").write_text((tmp_path / "shop.pjx").read_text().replace("true", "false"))
    with pytest.raises(ReadError, match="lengths in inches"):
        read_toolpath(tmp_path / "part.pgx")
