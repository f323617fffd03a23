"""Random Klartext programs against a second reader."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.oracles.cnc_moves import assert_same, curves_of
from tests.oracles.heidenhain_reader import second_reading
from tests.oracles.random_heidenhain import RandomKlartext
from tests.oracles.read_text import read_text


@pytest.mark.parametrize("seed", range(25))
def test_as_the_second_reader(tmp_path: Path, seed: int) -> None:
    text = RandomKlartext(seed).text
    moves = second_reading(text)
    assert len(moves) > 40 and curves_of(moves) > 5
    assert_same(read_text("part.h", tmp_path, text), moves)
