"""A run with another process beside it against the same run alone: the same bytes, and the other one did its part."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

import compensator.solve.assessment as assessment
import compensator.solve.compensate as compensate
import stiffness.numerics.beside as beside
import toolpaths.languages.rapid.read_back as read_back
import toolpaths.languages.rapid.writer as writer
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


def by_whom(monkeypatch: pytest.MonkeyPatch, module: object, name: str) -> list[int]:
    """One entry for every call in this process."""
    whole, calls = getattr(module, name), list[int]()

    def counting(*args: object, **kwargs: object) -> object:
        calls.append(os.getpid())
        return whole(*args, **kwargs)

    monkeypatch.setattr(module, name, counting)
    return calls


@pytest.mark.skipif(not hasattr(os, "memfd_create") or cores() < 2, reason="one core, or a system without fork")
@pytest.mark.usefixtures("may_fork")
@pytest.mark.parametrize("worn", [False, True])
def test_another_process_gives_the_same_bytes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, worn: bool) -> None:
    process = {"kind": "constant", "frame": "path", "wrench": [-160.0, 90.0, 120.0, 5.0, -4.0, 3.0]}
    cell = {"gravity": "uncompensated", "process": process}
    job = files(tmp_path, cell, WORN if worn else MODEL, rows=wavy(71, rapid=True))
    monkeypatch.setattr(writer, "MOVES_PER_MODULE", 20)
    with left_with(1):
        alone = written(job, "alone")
    monkeypatch.setattr(beside, "FROM", 1)
    parts = [name for name in alone if name.startswith("p_0")]
    assert len(parts) > 3
    elsewhere(monkeypatch, compensate, "_positions")
    elsewhere(monkeypatch, compensate, "share_sizes")
    elsewhere(monkeypatch, assessment, "spread_of_unknown")
    looked_into = by_whom(monkeypatch, read_back, "_moves")
    flushes = by_whom(monkeypatch, os, "fsync")
    folder = job.out / "beside"
    folder.mkdir()
    compensate_file(job.toolpath, job.cell, folder / "p.mod", json=folder / "s.json")
    there = hashes(folder)
    assert there == {name: alone[name] for name in there}
    assert {"p.mod", "s.json", "p.pgf", *parts} <= set(there)
    assert len(looked_into) == (len(parts) + 1 + 1) // 2  # the main file and half of all here
    assert len(flushes) == 2  # of the main file, which was sealed, and of the summary
