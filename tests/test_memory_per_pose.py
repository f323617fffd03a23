"""How many bytes a pose more takes at the peak of a run: between two sizes of one job, with all blocks small.

Counted by tracemalloc, so that neither the machine nor what else runs on it matters. What is worked on in blocks does
not depend on the length of the path and drops out; what is kept, or made of all poses at one time, stays.
"""

from __future__ import annotations

import gc
import tracemalloc
from pathlib import Path

import pytest

import compensator.process.milling.mill as mill
import compensator.report.csv.engagement as engagement
import compensator.solve.flank_poses as flank_poses
import compensator.solve.joint_state as joint_state
import stiffness.kinematics.spherical as spherical
import stiffness.memory.last_direction as last_direction
import toolpaths.columns as columns
import toolpaths.interpreting.reread_text as reread_text
import toolpaths.languages.rapid.writer as writer
from benchmarks import milled
from benchmarks.job import JOBS, program, write_inputs

WARM, SHORT, LONG = 810, 1000, 2200
BLOCK = 250
#: Bytes a pose, 15 % above what was measured (347, 575, 593, 698, 413, 574). Beyond them are a path that is kept
#: before and after poses were put in, and the text of a program as a whole; of a milled path a row of ``walk`` that is
#: kept for every pose (336 bytes), and shares of the coefficients (288).
BOUNDS = {
    ("compensate", False): 400,
    ("compensate", True): 660,
    ("filter", False): 680,
    ("filter", True): 800,
    ("mill", False): 475,
    ("mill", True): 660,
}
RUN = {**JOBS, "mill": milled.run}  # on a stock of a few bricks, whose grid is the same for both lengths


def peak(job: str, folder: Path, poses: int, *, memory: bool) -> tuple[int, int]:
    """The most bytes that a job takes, and the poses that it makes."""
    prepared(job, folder, poses, memory=memory)
    gc.collect()
    gc.freeze()  # when cycles are collected depends on how many objects other tests have left
    tracemalloc.start()
    try:
        made = RUN[job](folder)
        return tracemalloc.get_traced_memory()[1], made
    finally:
        tracemalloc.stop()
        gc.unfreeze()


def prepared(job: str, folder: Path, poses: int, *, memory: bool) -> None:
    """Inputs of a job."""
    folder.mkdir()
    (milled.write_job if job == "mill" else write_inputs)(folder, poses, memory=memory)
    if job == "filter":
        program(folder)


@pytest.mark.parametrize(("job", "memory"), list(BOUNDS))
def test_bytes_a_pose(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, job: str, memory: bool) -> None:
    for module in (columns, spherical, mill, engagement):
        monkeypatch.setattr(module, "BLOCK", BLOCK)
    monkeypatch.setattr(joint_state, "STATELESS", BLOCK)
    monkeypatch.setattr(joint_state, "PIECE", BLOCK)
    monkeypatch.setattr(last_direction, "TOGETHER", BLOCK)
    monkeypatch.setattr(flank_poses, "TOGETHER", 8)
    monkeypatch.setattr(writer, "MOVES_PER_MODULE", 200)
    monkeypatch.setattr(reread_text, "HELD", 50_000)
    prepared(job, tmp_path / "warm", WARM, memory=memory)
    RUN[job](tmp_path / "warm")  # kernels are built, modules imported
    few, short = peak(job, tmp_path / "short", SHORT, memory=memory)
    many, long = peak(job, tmp_path / "long", LONG, memory=memory)
    each = (many - few) / (long - short)
    assert 0.5 * BOUNDS[job, memory] < each < BOUNDS[job, memory]
