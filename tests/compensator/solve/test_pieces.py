"""A path that is solved piece by piece against the same path solved at once: the pieces hand all of their state on."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import compensator.solve.joint_state as joint_state
from compensator.tasks.compensate import Done, compensate_file
from tests.compensator.small_job import WORN, files


def contour(poses: int) -> list[list[object]]:
    """A rapid and a figure of eight with a swaying tool: every joint turns round, several times."""
    t = np.linspace(0, 4 * np.pi, poses)
    tilt = 0.1 * np.sin(3 * t)
    rows = np.column_stack([60 * np.sin(t), 40 * np.sin(2 * t), 3 * np.cos(t), tilt, 0 * t, np.sqrt(1 - tilt**2)])
    cuts: list[list[object]] = [[*row, 1200, "cut"] for row in rows.tolist()]
    return [[*rows[0, :2].tolist(), 80.0, 0, 0, 1, 0, "rapid"], *cuts]


def solved(folder: Path, *, side: list[float]) -> Done:
    folder.mkdir()
    gaps = {**WORN["effects"]["backlash"], "side": side}
    job = files(folder, {}, {"effects": {**WORN["effects"], "backlash": gaps}}, rows=contour(90))
    return compensate_file(job.toolpath, job.cell, job.out / "p.mod")


@pytest.mark.parametrize("side", [[1.0] * 6, [-1.0, 1.0, 0.5, -1.0, -0.5, 1.0]])
def test_pieces_hand_the_state_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, side: list[float]) -> None:
    """The same commands and states; a path in pieces of one pose may differ where a joint hardly moves and either
    direction agrees with the correction that it asks for: there the written program still leaves no error."""
    whole = solved(tmp_path / "whole", side=side).result
    crossings = np.abs(np.diff(whole.state.middle[:, -6:], axis=0)).max(axis=0)
    assert (crossings > 1e-5).sum() >= 3 and whole.inserted > 0  # there is a state to hand on
    for size in (64, 1):
        monkeypatch.setattr(joint_state, "PIECE", size)
        done = solved(tmp_path / f"pieces of {size}", side=side)
        assert done.report["predicted_error_mm"]["after"]["max"] < 5e-4
        if size == 1:
            continue
        cut = done.result
        for name in ("q", "actual", "torque", "position"):
            np.testing.assert_allclose(getattr(cut.command, name), getattr(whole.command, name), rtol=1e-9, atol=1e-9)
        for name in ("low", "high", "middle"):
            np.testing.assert_allclose(getattr(cut.state, name), getattr(whole.state, name), rtol=0, atol=1e-12)
        np.testing.assert_allclose(cut.before, whole.before, rtol=0, atol=1e-12)
