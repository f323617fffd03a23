"""VAL3 beside real programs: how they are put together, what a move takes."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest

from tests.oracles import val3_reader
from tests.oracles.sample_programs import small
from toolpaths.files import write_program


@pytest.mark.parametrize("name", ["Prog1_start.pgx", "start.pgx"])
def test_programs_are_put_together_like_real_ones(shared, tmp_path, name):
    write_program(small(), tmp_path / "own.pgx")
    files = (shared / "data" / "cam" / "robodk" / name, tmp_path / "own.pgx")
    roots = [ElementTree.fromstring(f.read_bytes()) for f in files]
    assert roots[0].tag == roots[1].tag and [p.tag for p in roots[0]] == [p.tag for p in roots[1]]
    assert [sorted(p.attrib) for p in roots[0]] == [sorted(p.attrib) for p in roots[1]] == [["access", "name"]]
    assert [[c.tag for c in p] for p in roots[0]] == [[c.tag for c in p] for p in roots[1]]
    heads = [re.match(rb"<\?xml[^>]*\?>\r\n<Programs [^>]*>\r\n", f.read_bytes()) for f in files]
    assert heads[0][0].replace(b" ?>", b"?>") == heads[1][0]


def test_moves_take_what_real_moves_take(shared, tmp_path):
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
