"""What is written beside real programs of the same language: words, their order, what a move is made of."""

from __future__ import annotations

import re
from itertools import combinations
from xml.etree import ElementTree

import numpy as np
import pytest

from tests.oracles import inform_reader, val3_reader
from tests.oracles.sample_programs import changed, random_program, small
from toolpaths.files import write_program
from toolpaths.frame import Frame

JOBS = ["robodk/PROGRAM.JBI", "robodk_posts/Motoman_test_post.jbi"]
LISTINGS = ["robodk/Program.LS", "robodk_posts/Fanuc_R30iA_test_post.ls"]


@pytest.mark.parametrize("name", JOBS)
def test_inform_words_come_in_the_order_of_real_jobs(shared, tmp_path, name):
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


def test_inform_positions_are_those_of_a_real_job(shared, tmp_path):
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


@pytest.mark.parametrize("name", ["Prog1_start.pgx", "start.pgx"])
def test_val3_programs_are_put_together_like_real_ones(shared, tmp_path, name):
    write_program(small(), tmp_path / "own.pgx")
    files = (shared / "data" / "cam" / "robodk" / name, tmp_path / "own.pgx")
    roots = [ElementTree.fromstring(f.read_bytes()) for f in files]
    assert roots[0].tag == roots[1].tag and [p.tag for p in roots[0]] == [p.tag for p in roots[1]]
    assert [sorted(p.attrib) for p in roots[0]] == [sorted(p.attrib) for p in roots[1]] == [["access", "name"]]
    assert [[c.tag for c in p] for p in roots[0]] == [[c.tag for c in p] for p in roots[1]]
    heads = [re.match(rb"<\?xml[^>]*\?>\r\n<Programs [^>]*>\r\n", f.read_bytes()) for f in files]
    assert heads[0][0].replace(b" ?>", b"?>") == heads[1][0]


def test_val3_moves_take_what_real_moves_take(shared, tmp_path):
    """A target, a tool, a movement descriptor, in that order; ours are elements of arrays. start.pgx calls only."""
    real = val3_reader.moves_of(shared / "data" / "cam" / "robodk" / "Prog1_start.pgx")
    assert real == [
        ("movej", ("jJoint[]", "flange[]", "mNomSpeed")), ("movej", ("jJoint[]", "flange[]", "mNomSpeed")),
        ("movel", ("pPoint[]", "flange[]", "mNomSpeed")), ("movec", ("pPoint[]", "pPoint[]", "flange[]", "mNomSpeed")),
    ]  # fmt: skip
    assert val3_reader.moves_of(shared / "data" / "cam" / "robodk" / "start.pgx") == []
    write_program(small(), tmp_path / "own.pgx")
    own = val3_reader.moves_of(tmp_path / "own.pgx")
    assert set(own) == {
        ("movej", ("jStart[]", "tTool1[]", "mStart[]")), ("movel", ("pMove001[]", "tTool1[]", "mMove001[]")),
    }  # fmt: skip
    by_word = [{w: (args[0][0], len(args)) for w, args in moves} for moves in (real, own)]
    assert by_word[1] == {w: by_word[0][w] for w in ("movej", "movel")}  # j or p first, three arguments


@pytest.mark.parametrize("name", LISTINGS)
def test_fanuc_heads_and_records_look_like_real_ones(shared, tmp_path, name):
    """The attributes in the same order with the same punctuation; records in the same lines."""
    write_program(small(), tmp_path / "own.ls")
    texts = [(shared / "data" / "cam" / name).read_text(), (tmp_path / "own.ls").read_bytes().decode()]
    texts = [t.replace("\r\n", "\n") for t in texts]
    heads = [re.search(r"^/PROG.*?^/MN\n", t, re.M | re.S)[0] for t in texts]
    shapes = [[re.sub(r"\s+", " ", re.split(r"[=:]", line)[0]).strip() for line in h.splitlines()] for h in heads]
    assert shapes[0][1:] == shapes[1][1:]
    records = [re.findall(r"^P\[\d+\]\{\n.*?^\};\n", t, re.M | re.S) for t in texts]
    number = re.compile(r"-?\d*\.?\d+")
    letters = re.compile(r"'[NF] [UD] [TB],")
    kinds = [{re.sub(r"\s+", "", letters.sub("'", number.sub("#", r))) for r in group} for group in records]
    assert kinds[1] <= kinds[0] and len(kinds[1]) == 2  # positions and joint angles
    moves = [set(re.findall(r"^ *\d+:([JL] P\[)\d+(\] )[\d.]+(?:%|mm/sec) (?:FINE|CNT)", t, re.M)) for t in texts]
    assert moves[0] == moves[1] == {("J P[", "] "), ("L P[", "] ")}
