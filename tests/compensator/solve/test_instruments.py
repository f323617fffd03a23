"""Effects of the instruments judge data: no planned path may feel them, whatever stands in the model file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from compensator.program.provenance import without_head
from compensator.tasks.compensate import compensate_file, preview_file
from stiffness.effects import CATALOGUE
from tests.compensator.small_job import MODEL, columns, files

SPRING = MODEL["effects"]["joint-stiffness"]
TRACKER = {"linear_m_per_s": [3e-8, -2e-8, 5e-8], "angular_rad_per_s": [1e-8, 2e-8, -3e-8], "settling_s": 3600.0}
SENSOR = {
    "force_n": [40.0, -30.0, 25.0],
    "moment_nm": [6.0, -4.0, 9.0],
    "scale": [0.2, 0.1, -0.2, 0.05, 0.1, -0.1],
    "misalignment_rad": [0.05, -0.03, 0.1],
    "in_tool_axes": 1.0,
}
PLAIN: dict[str, Any] = {"joint-stiffness": SPRING, "backlash": {"gap_rad": [1e-4] * 6}}
TILTED: dict[str, Any] = {**PLAIN, "tracker-drift": TRACKER, "force-sensor-bias": SENSOR}
BOTH = {"tracker-drift", "force-sensor-bias"}


def outputs(folder: Path, effects: dict[str, Any], suffix: str) -> tuple[bytes, bytes, list[str], list[str]]:
    """Bytes of the compensated program and of the preview, and what the two reports say was not applied."""
    folder.mkdir(exist_ok=True)  # programs name their source
    job = files(folder, model={"effects": effects})
    program, shown = job.out / f"program{suffix}", job.out / "preview.csv"
    done = compensate_file(job.toolpath, job.cell, program)
    seen = preview_file(job.toolpath, job.cell, csv=shown)
    told = without_head(program.read_bytes())  # the head names the model by its hash
    return told, shown.read_bytes(), done.report["not_applied"], seen.report["not_applied"]


@pytest.mark.parametrize("suffix", [".csv", ".mod"])
def test_instruments_never_move_a_planned_path(suffix: str, tmp_path: Path) -> None:
    """The same bytes with a tracker that creeps and a sensor that lies, and both named as not applied."""
    program, preview, *left = outputs(tmp_path / "job", PLAIN, suffix)
    same_program, same_preview, *left_out = outputs(tmp_path / "job", TILTED, suffix)
    assert left == [[], []] and [set(names) for names in left_out] == [BOTH, BOTH]
    assert same_program == program and same_preview == preview and len(program) > 500


def test_the_same_numbers_on_the_tool_do_move_it(tmp_path: Path) -> None:
    """The test above can fail: what acts on a path changes its program."""
    program, preview, *_ = outputs(tmp_path / "job", PLAIN, ".csv")
    payload = {**PLAIN, "payload": {"mass_kg": 12.0, "com_m": [0.0, 0.1, 0.2]}}
    other, other_preview, *left = outputs(tmp_path / "job", payload, ".csv")
    assert other != program and other_preview != preview and left == [[], []]


def test_every_effect_of_the_catalogue_on_one_path(tmp_path: Path) -> None:
    """All that act on a path act together: the program is solved; left out are the instruments, and the size of a
    cutter that no engagement is known of."""
    whole = TILTED | _others()
    assert set(whole) == {e.name for e in CATALOGUE}
    job = files(tmp_path, model={"effects": whole})
    done = compensate_file(job.toolpath, job.cell, job.out / "a.csv")
    assert set(done.report["not_applied"]) == BOTH | {"cutter-size"}
    assert done.report["predicted_error_mm"]["after"]["max"] < 1e-6
    position = ("x_mm", "y_mm", "z_mm")
    table = columns(job.out / "a.csv", *position, *(f"nominal_{c}" for c in position))
    assert np.abs(table[:, :3] - table[:, 3:]).max() > 0.3 and np.isfinite(table).all()


def _others() -> dict[str, Any]:
    offsets = {"zero_rad": [1e-4] * 6, "x_m": [1e-4] * 6}
    spring = {"linear_m_per_n": [2e-8] * 3, "angular_rad_per_nm": [5e-8] * 3}
    return {
        "preload-softening": {"ratio": [0.8] * 6},
        "joint-hardening": {"windup_rad": [5e-5] * 6, "knee_nm": [200.0] * 6, "further_rad": [3e-5] * 6},
        "joint-friction": {"friction_nm": [60.0, 60.0, 50.0, 12.0, 8.0, 5.0], "held": [0.8] * 6, "lag": [1.0] * 6},
        "joint-coupling": {"coupling": [0.0, 0.0, -0.4, *[0.0] * 11, 0.3]},
        "posture-stiffness": {"softer": [0.2] * 6, "stiffest_rad": [0.5] * 6, "cos2": [0.1] * 6, "sin2": [-0.1] * 6},
        "kinematic-offset": offsets,
        "joint-angle-error": {"error_rad": [4e-4 * ((k % 7) - 3) / 3 for k in range(720)]},
        "gravity-compensator": {"moment_nm": 9000.0, "angle_rad": 0.2, "free_length": 0.4, "eccentricity": 0.6},
        "payload": {"mass_kg": 8.0, "com_m": [0.0, 0.05, 0.1]},
        "base-compliance": spring,
        "link-compliance": {f"r{a}_rad_per_nm": [4e-8] * 6 for a in "xyz"},
        "tool-compliance": spring,
        "cutting-force": {"change": [0.2, -0.1, 0.3]},
        "cutter-size": {"radius_m": 2e-5},
        "thermal-drift": {"expansion_per_k": [1.2e-5] * 7, "zero_rad_per_k": [1e-6] * 6},
    }
