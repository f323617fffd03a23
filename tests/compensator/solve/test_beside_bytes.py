"""A run with another process beside it against the same run alone: the same bytes, and the other one did its part."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

import compensator.solve.assessment as assessment
import compensator.solve.compensate as compensate
import stiffness.numerics.beside as beside
from compensator.tasks.compensate import compensate_file
from stiffness.numerics.cores import cores, left_with
from tests.compensator.small_job import MODEL, WORN, files
from tests.compensator.solve.test_blocks import hashes, wavy, written

HERE = os.getpid()


def elsewhere(monkeypatch: pytest.MonkeyPatch, module: object, name: str) -> None:
    """The function refuses to work in this process."""
    whole = getattr(module, name)

    def refusing(*args: object, **kwargs: object) -> object:
        assert os.getpid() != HERE, f"{name} was done here"
        return whole(*args, **kwargs)

    monkeypatch.setattr(module, name, refusing)


@pytest.mark.skipif(not hasattr(os, "memfd_create") or cores() < 2, reason="one core, or a system without fork")
@pytest.mark.parametrize("worn", [False, True])
def test_another_process_gives_the_same_bytes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, worn: bool) -> None:
    process = {"kind": "constant", "frame": "path", "wrench": [-160.0, 90.0, 120.0, 5.0, -4.0, 3.0]}
    cell = {"gravity": "uncompensated", "process": process}
    job = files(tmp_path, cell, WORN if worn else MODEL, rows=wavy(71, rapid=True))
    with left_with(1):
        alone = written(job, "alone")
    monkeypatch.setattr(beside, "FROM", 1)
    elsewhere(monkeypatch, compensate, "_positions")
    elsewhere(monkeypatch, assessment, "spread_of_unknown")
    folder = job.out / "beside"
    folder.mkdir()
    compensate_file(job.toolpath, job.cell, folder / "p.mod", json=folder / "s.json")
    assert hashes(folder) == {name: alone[name] for name in ("p.mod", "s.json")}
