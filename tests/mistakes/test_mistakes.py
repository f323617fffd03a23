"""Every mistake of docs/mistakes.md is made again; its row has not changed."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.mistakes.inputs import write_inputs
from tests.mistakes.mistake import Mistake
from tests.mistakes.page import CHAPTERS, PAGE, outcome, page, row
from tests.mistakes.shell import Mishap

ALL = [mistake for mistakes in CHAPTERS.values() for mistake in mistakes]
LINES = PAGE.read_text(encoding="utf-8").splitlines()


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which nothing is wrong."""
    folder = tmp_path_factory.mktemp("inputs")
    write_inputs(folder)
    return folder


def test_the_page_has_a_row_for_each() -> None:
    """A hundred of them, each once; remake it by `python -m tests.mistakes`."""
    rows = iter(line for line in LINES if line.startswith("| ") and not line.startswith(("| mistake", "| ---")))
    assert page(lambda mistake: next(rows)).splitlines() == LINES and next(rows, None) is None
    assert len(ALL) >= 100 and len({(m.what, m.command) for m in ALL}) == len(ALL)


@pytest.mark.parametrize("mistake", ALL, ids=lambda m: m.what)
def test_it_is_as_the_page_says(inputs: Path, tmp_path: Path, mistake: Mistake | Mishap) -> None:
    """Exit status, message, what is left behind; the rest is looked at where it is made."""
    assert row(mistake, outcome(mistake, inputs, tmp_path / "here")) in LINES


def test_nothing_is_wrong_with_the_inputs(inputs: Path, tmp_path: Path) -> None:
    """So that every refusal is that of the mistake."""
    for verb, command, written in (
        ("compensate", "compensate part.nc --cell cell.toml -o a.mod", ("a.mod",)),
        ("table", "compensate path.csv --cell table.toml -o a.csv --json a.json", ("a.csv", "a.json")),
        ("evaluate", "evaluate session.toml --model model.toml --json a.json", ("a.json",)),
        ("identify", "identify session.toml --effects joint-stiffness -o a.toml", ("a.toml",)),
    ):
        found = outcome(Mistake("none", command), inputs, tmp_path / verb)
        assert (found.status, found.left) == (0, written), found
