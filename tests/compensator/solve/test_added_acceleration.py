"""What corrections add to joint accelerations: nothing on a steady cut; at a jump of the force what the program has."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from compensator.path.joint_motion import RAMP
from compensator.tasks.compensate import Done, compensate_file
from tests.compensator.small_job import WORN, Files, columns, files, write_csv

JUMP = 100  # pose from which on the force acts
WRENCHES = ("index", "fx", "fy", "fz", "mx", "my", "mz")


def line(folder: Path, force: list[float], model: dict | None = None) -> Files:
    """A millimetre from pose to pose at 3000 mm/min, with a force along y at each of them."""
    rows = [[float(k), 0.0, 0.0, 0.0, 0.0, 1.0, 3000.0, "cut"] for k in range(len(force))]
    write_csv(folder / "forces.csv", WRENCHES, [[k, 0.0, f, 0.0, 0.0, 0.0, 0.0] for k, f in enumerate(force)])
    return files(folder, {"process": {"kind": "table", "frame": "workobject", "file": "forces.csv"}}, model, rows)


def compensated(job: Files) -> Done:
    return compensate_file(job.toolpath, job.cell, job.out / "a.csv")


def test_a_steady_force_adds_nothing(tmp_path: Path) -> None:
    done = compensated(line(tmp_path, [300.0] * 200))
    motion = done.report["motion"]
    assert max(motion["added_acceleration_deg_per_s2"]["elsewhere"]) < 0.05
    assert not [f for f in done.findings if "corrections accelerate" in f.what]


def test_a_jump_of_the_force_is_told_with_its_pose(tmp_path: Path) -> None:
    job = line(tmp_path, [0.0] * JUMP + [800.0] * 100)
    done = compensated(job)
    q = columns(job.out / "a.csv", *(f"q{k}_deg" for k in range(1, 7)))
    jump = (q[JUMP] - q[JUMP - 1]) - (q[JUMP - 1] - q[JUMP - 2])  # in the program as it was written
    added = done.report["motion"]["added_acceleration_deg_per_s2"]
    assert max(added["elsewhere"]) == pytest.approx(np.abs(jump).max() / RAMP**2, rel=0.05)
    assert added["at_flank_changes"] == [0.0] * 6
    (told,) = [f for f in done.findings if "corrections accelerate" in f.what]
    assert told.kind == "path" and f"joint {int(np.argmax(np.abs(jump))) + 1} by" in told.what
    assert any(f"(pose {k})" in told.place for k in range(JUMP - 2, JUMP + 2))


def test_a_flank_change_is_counted_by_itself(tmp_path: Path) -> None:
    """The force turns round: so does the torque on the joints, and flanks change there."""
    rows = np.repeat([300.0, -300.0], 100).tolist()
    added = compensated(line(tmp_path, rows, WORN)).report["motion"]["added_acceleration_deg_per_s2"]
    assert max(added["at_flank_changes"]) > 20.0
    assert max(added["elsewhere"]) < 0.2 * max(added["at_flank_changes"])
