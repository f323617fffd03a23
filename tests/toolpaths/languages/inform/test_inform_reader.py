"""What is read of INFORM jobs: against the second reader, arcs and calls by hand, real jobs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.contracts.languages.inform import ARC, CUT, FIRST, GO, job
from tests.oracles import inform_reader
from tests.oracles.sample_programs import random_program, small
from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath, refuse_own, write_program
from toolpaths.rotation import matrix_from_quaternion
from toolpaths.toolpath import Toolpath
from toolpaths.writing.program import Program


def read(tmp_path: Path, text: str) -> Toolpath:
    (tmp_path / "part.jbi").write_text(text)
    return read_toolpath(tmp_path / "part.jbi")


@pytest.mark.parametrize("program", [small(), random_program(300, 5, "R"), random_program(12_000, 6, "LONG")])
def test_the_second_reader_agrees_on_what_the_writer_wrote(tmp_path: Path, program: Program) -> None:
    """Poses in the robot frame, speeds, tools, configurations, stops; of jobs that call others, too."""
    file = tmp_path / "part.jbi"
    write_program(program, file)
    path, moves = read_toolpath(file), inform_reader.read(file).moves
    assert len(path) == len(moves) and path.quaternion is not None and path.setting is not None
    pose = np.array([inform_reader.pose(m.position) for m in moves])
    np.testing.assert_allclose(path.position, pose[:, :3, 3] * 1e-3, rtol=0, atol=1e-12)
    np.testing.assert_allclose(matrix_from_quaternion(path.quaternion), pose[:, :3, :3], rtol=0, atol=1e-12)
    joint = np.array([m.word == "MOVJ" for m in moves])
    np.testing.assert_array_equal(path.kind, ~joint)
    np.testing.assert_allclose(path.feed[~joint], np.array([m.speed for m in moves])[~joint] * 1e-3, rtol=1e-12)
    np.testing.assert_array_equal(path.tool, [m.position.tool for m in moves])
    bits = [m.position.rconf[0] + 2 * m.position.rconf[1] + 4 * m.position.rconf[2] for m in moves]
    np.testing.assert_array_equal(path.setting.configuration, bits)
    np.testing.assert_array_equal(path.setting.zones == 0.0, [m.level == 0 for m in moves])
    assert path.setting.workobject is not None and np.array_equal(path.setting.workobject.matrix, np.eye(4))
    assert len(path.sources) == (0 if len(program) < 5000 else 4)


def test_what_the_writer_wrote_is_not_compensated_again(tmp_path: Path) -> None:
    for name in ("a", "long_name_of_a_program"):
        write_program(small(), tmp_path / f"{name}.jbi")
        with pytest.raises(ReadError, match="compensated already"):
            refuse_own(tmp_path / f"{name}.jbi")


def test_three_movc_are_an_arc(tmp_path: Path) -> None:
    """From C00002 through C00003 to C00004, found as the circle through the three; a line leads to the first."""
    path = read(tmp_path, job(GO, CUT, *ARC, "MOVL C00001 V=10.0"))
    at = path.line - FIRST
    np.testing.assert_allclose(path.position[at == 2] * 1e3, [[40, -3, 0]], atol=1e-12)
    arc = path.position[at == 4] * 1e3
    assert len(arc) > 20 and not (at == 3).any()
    np.testing.assert_allclose(arc[-1], [60, 17, 4], atol=1e-9)
    a, b, c = (np.array(p, dtype=float) for p in ((40, -3, 0), (40, 17, 0), (60, 17, 4)))
    normal = np.cross(b - a, c - a)
    center = np.linalg.solve(
        [b - a, c - a, normal], [(b @ b - a @ a) / 2, (c @ c - a @ a) / 2, normal @ a]
    )
    np.testing.assert_allclose(np.linalg.norm(arc - center, axis=1), np.linalg.norm(a - center), rtol=1e-9)
    assert np.linalg.norm(arc - b, axis=1).min() < 1.0


def test_speed_stands_for_the_moves_that_give_none(tmp_path: Path) -> None:
    path = read(tmp_path, job(GO, CUT, "SPEED VJ=50.00 V=7.5", "MOVL C00002", "MOVL C00003 V=9.0", "MOVL C00004"))
    np.testing.assert_allclose(path.feed[1:] * 1e3, [10.0, 7.5, 9.0, 7.5])


def test_user_frames_and_the_other_jobs_beside(tmp_path: Path) -> None:
    """A user frame is not known; a job that is called runs in its place, its lines are those of its own file."""
    (tmp_path / "DRILL.JBI").write_text(job("MOVL C00002 V=4.0", "MOVL C00003 V=4.0").replace("PART", "DRILL"))
    text = job(GO, CUT, "CALL JOB:DRILL", "CALL JOB:GRIP", "MOVL C00004 V=9.0", kind="USER")
    with pytest.raises(ReadError, match="another frame, and one of the two is not in the file"):
        read(tmp_path, text.replace("///POSTYPE", "///USER 3\n///POSTYPE"))
    path = read(tmp_path, text.replace("POSTYPE USER", "POSTYPE BASE"))
    np.testing.assert_allclose(path.feed[1:] * 1e3, [10, 4, 4, 9])
    assert path.file is not None and path.file.tolist() == [0, 0, 1, 1, 0]
    assert path.line.tolist() == [FIRST, FIRST + 1, FIRST, FIRST + 1, FIRST + 4]
    assert [e.word for e in path.events if "CALL" in e.word] == ["CALL JOB:DRILL", "CALL JOB:GRIP"]
    alone = read(tmp_path, job(GO, CUT, kind="USER").replace("///POSTYPE", "///USER 3\n///POSTYPE"))
    assert alone.setting is not None and alone.setting.workobject is None


def test_real_jobs(shared: Path) -> None:
    """RoboDK's: pulses lead to where only the controller knows, and the path begins behind them."""
    path = read_toolpath(shared / "data/cam/robodk/PROGRAM.JBI")
    np.testing.assert_allclose(path.position[0] * 1e3, [418.57, 147.321, 251.179], atol=1e-9)
    np.testing.assert_allclose(path.feed * 1e3, 200.0)
    assert path.tool.tolist() == [9] * 4 and any("DOUT OT#(5) ON" in e.word for e in path.events)
    assert len(read_toolpath(shared / "data/cam/robodk_posts/Motoman_test_post.jbi")) == 8
