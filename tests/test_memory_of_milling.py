"""How many bytes a pose more of a milled path takes at the peak of a run: as test_memory_per_pose.py, on a stock of a
few bricks, whose grid is the same for both lengths."""

from __future__ import annotations

import tracemalloc
from pathlib import Path

import pytest

import compensator.process.milling.mill as mill
import compensator.report.csv.engagement as engagement
import compensator.solve.flank_poses as flank_poses
import compensator.solve.joint_state as joint_state
import stiffness.kinematics.spherical as spherical
import toolpaths.columns as columns
import toolpaths.interpreting.reread_text as reread_text
import toolpaths.languages.rapid.writer as writer
from benchmarks.milled import run, write_job

WARM, SHORT, LONG = 400, 1000, 2200
BLOCK = 200
#: Bytes a pose, 15 % above what was measured (771, 1,481); a row of ``walk`` that is kept for every pose
#: (336 bytes), or shares of the coefficients (288) that outlive the prediction, are beyond them.
BOUNDS = {False: 887, True: 1703}


def peak(folder: Path, poses: int, *, memory: bool) -> tuple[int, int]:
    """The most bytes that a run takes, and the poses that it makes."""
    prepared(folder, poses, memory=memory)
    tracemalloc.start()
    try:
        made = run(folder)
        return tracemalloc.get_traced_memory()[1], made
    finally:
        tracemalloc.stop()


def prepared(folder: Path, poses: int, *, memory: bool) -> None:
    """Inputs of a run."""
    folder.mkdir()
    write_job(folder, poses, memory=memory)


@pytest.mark.parametrize("memory", list(BOUNDS))
def test_bytes_a_milled_pose(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, memory: bool) -> None:
    monkeypatch.setattr(mill, "BLOCK", BLOCK)
    monkeypatch.setattr(engagement, "BLOCK", BLOCK)
    monkeypatch.setattr(columns, "BLOCK", BLOCK)
    monkeypatch.setattr(spherical, "BLOCK", BLOCK)
    monkeypatch.setattr(joint_state, "STATELESS", BLOCK)
    monkeypatch.setattr(joint_state, "PIECE", BLOCK)
    monkeypatch.setattr(flank_poses, "TOGETHER", 8)
    monkeypatch.setattr(writer, "MOVES_PER_MODULE", 200)
    monkeypatch.setattr(reread_text, "HELD", 50_000)
    prepared(tmp_path / "warm", WARM, memory=memory)
    run(tmp_path / "warm")  # kernels are built, modules imported
    few, short = peak(tmp_path / "short", SHORT, memory=memory)
    many, long = peak(tmp_path / "long", LONG, memory=memory)
    each = (many - few) / (long - short)
    assert 0.5 * BOUNDS[memory] < each < BOUNDS[memory]
