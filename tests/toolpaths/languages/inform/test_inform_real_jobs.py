"""INFORM beside real jobs: words, their order, what a move is made of."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from tests.oracles import inform_reader
from tests.oracles.sample_programs import changed, random_program, small
from toolpaths.files import write_program
from toolpaths.frame import Frame

JOBS = ["robodk/PROGRAM.JBI", "robodk_posts/Motoman_test_post.jbi"]


@pytest.mark.parametrize("name", JOBS)
def test_words_come_in_the_order_of_real_jobs(shared, tmp_path, name):
    """////FRAME is the one word that RoboDK's jobs leave out: DX100, 4.1.4, a relative job in the robot frame."""
    real = inform_reader.dialect(shared / "data" / "cam" / name)
    write_program(small(), tmp_path / "own.jbi")
    own = inform_reader.dialect(tmp_path / "own.jbi")
    assert set(own.words) - set(real.words) == {"////FRAME"}
    assert set(real.words) - set(own.words) == {"///PULSE"}
    common = [w for w in dict.fromkeys(own.words) if w in real.words]
    for a, b in combinations(common, 2):
        assert real.words.index(a) < real.words.index(b), (a, b)
    assert {m.word for m in own.moves} == {m.word for m in real.moves} == {"MOVJ", "MOVL"}
    assert real.moves[0].word == own.moves[0].word == "MOVJ"


def test_positions_are_those_of_a_real_job(shared, tmp_path):
    """The real job's numbers, written by us with their work object, are the same numbers with more digits."""
    real = inform_reader.dialect(shared / "data" / "cam" / JOBS[0])
    rows = np.array([v for k, v in real.positions.items() if k > "C00001"])  # the first two are pulses
    poses = [inform_reader.pose(inform_reader.Position(r[:3].tolist(), r[3:].tolist(), 9, [])) for r in rows]
    p = changed(
        random_program(len(rows), 1), position=rows[:, :3] * 1e-3, rotation=np.array([t[:3, :3] for t in poses]),
        workobject=Frame.identity(),
    )  # fmt: skip
    write_program(p, tmp_path / "own.jbi")
    own = np.array(list(inform_reader.dialect(tmp_path / "own.jbi").positions.values()))[1:]
    np.testing.assert_allclose(own[:, :3], rows[:, :3], atol=1e-9)
    turned = [inform_reader.pose(inform_reader.Position(r[:3].tolist(), r[3:].tolist(), 9, [])) for r in own]
    np.testing.assert_allclose(turned, poses, atol=2e-6)
