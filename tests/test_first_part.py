"""The loop of docs/first-part.md: 95 % of what the first part showed is gone on the second."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.first_part import CAUSES, loop


@pytest.mark.parametrize(("cause", "found"), [(CAUSES[0], "cutting-force"), (CAUSES[1], "joint-1: -30%")])
def test_the_second_part_is_right(tmp_path: Path, cause, found: str) -> None:
    done = loop(tmp_path, cause)
    first, _ = done.parts
    assert first.rms > 20.0
    assert found in done.found
    assert done.gone > 0.95
