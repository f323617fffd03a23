"""A placement is sought in the base of the robot: where a URDF leaves open which frame that is, the study says so."""

from __future__ import annotations

from pathlib import Path

import pytest

from compensator.tasks.place import place_file
from tests.compensator.framed_arm import FRAMED
from tests.compensator.small_job import files

BOX = {None: "x=1000,y=0,z=800", "world": "x=1000,y=0,z=800", "wbase": "x=1000,y=0,z=-60"}


@pytest.mark.parametrize("base", BOX)
def test_a_study_says_which_frame_it_is_in(base: str | None, tmp_path: Path) -> None:
    (tmp_path / "framed.urdf").write_text(FRAMED)
    named = {"robot": "framed.urdf", "base": base, "tip": "fanuc_flange"}
    job = files(tmp_path, named, named)
    done = place_file(job.toolpath, job.cell, job.out / "a.csv", within=BOX[base], turns=4, poses=10, workers=1)
    assert done.report["status"]["good"] == 1
    said = [f for f in done.report["findings"] if "positions in the base are taken as measured from" in f["what"]]
    assert len(said) == (base is None)
