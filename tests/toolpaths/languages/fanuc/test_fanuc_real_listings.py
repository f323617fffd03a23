"""Fanuc .ls beside real listings: attributes, records, moves."""

from __future__ import annotations

import re

import pytest

from tests.oracles.sample_programs import small
from toolpaths.files import write_program

LISTINGS = ["robodk/Program.LS", "robodk_posts/Fanuc_R30iA_test_post.ls"]


@pytest.mark.parametrize("name", LISTINGS)
def test_heads_and_records_look_like_real_ones(shared, tmp_path, name):
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
