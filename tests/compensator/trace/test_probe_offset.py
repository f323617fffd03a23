"""A touch probe whose offset is not known: it belongs to the measurement, and the cutter's size does not show."""

from __future__ import annotations

from pathlib import Path

import pytest

from compensator.tasks.identify import evaluate_file
from compensator.tasks.measurements import load_measurement
from compensator.trace.trace_file import read_trace_file
from stiffness.diagnosis.linearisation import can_show
from stiffness.effects import BY_NAME
from tests.compensator.trace.test_traces_of_the_plant import NOISE, contour, raised, surface


def test_an_offset_of_the_probe_is_estimated_and_reported(tmp_path: Path) -> None:
    ran, normals = contour(tmp_path, force=1.0)
    path = surface(ran, NOISE, normals)
    raised(path, 0.03)
    _, report = evaluate_file(path, tmp_path / "model.toml")
    assert report["path"]["rms_mm"] == pytest.approx(0.03, rel=0.1) and "probe_offset_mm" not in report["traces"][0]
    assert can_show(BY_NAME["cutter-size"], [load_measurement(path)])
    path.write_text(path.read_text() + "\n[probe]\ncalibrated = false\n")
    _, report = evaluate_file(path, tmp_path / "model.toml")
    assert report["traces"][0]["probe_offset_mm"] == pytest.approx(0.03, abs=0.004)  # 25 points placed it
    assert report["path"]["rms_mm"] < 1.3 * NOISE
    assert not can_show(BY_NAME["cutter-size"], [load_measurement(path)])
    path.write_text(path.read_text().replace('kind = "surface"', 'kind = "positions"'))
    with pytest.raises(Exception, match=r"\[probe\] with kind = 'positions'.*take it out"):
        read_trace_file(path)
