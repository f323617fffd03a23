"""The files of one run, told apart by their numbers on the disk."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from compensator.errors import CompensatorError
from compensator.tasks.run_files import RunFiles


def test_a_number_that_is_free_again_is_no_output(tmp_path: Path) -> None:
    """An output is replaced, and a later file of the run gets the number that the old one had."""
    target, new, again = (tmp_path / name for name in ("out.toml", "staged", "again"))
    target.write_text("old")
    os.link(target, again)
    run = RunFiles([target])
    with pytest.raises(CompensatorError, match=r"out\.toml: is an input of this run \(read as .*again\)"):
        run.opened(again)
    new.write_text("new")
    os.replace(new, target)
    run.opened(again)
    with pytest.raises(CompensatorError, match=r"again: is an input of this run"):
        run.refuse_input(again)
    os.replace(again, tmp_path / "moved")
    run.refuse_input(tmp_path / "moved")
