"""The milled examples: their files come from the script, and what they remove is what the geometry gives."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from compensator.tasks.compensate import compensate_file

EXAMPLES = Path(__file__).parents[1] / "examples"
sys.path.insert(0, str(EXAMPLES))
import make_jobs  # noqa: E402, a script beside its data


@pytest.mark.parametrize("name", ["pocket", "contour"])
def test_the_script_writes_the_same_bytes(name: str) -> None:
    text = "\n".join(getattr(make_jobs, name)()) + "\n"
    assert text.encode() == (EXAMPLES / f"{name}.nc").read_bytes()


def test_the_stock_of_the_wave() -> None:
    assert make_jobs.wave_stock() == (EXAMPLES / "wave-stock.obj").read_bytes()


def test_the_pocket_is_milled(tmp_path: Path) -> None:
    """120 x 80 x 12 mm without its four corners; nothing but warnings, and no force is typed."""
    done = compensate_file(EXAMPLES / "pocket.nc", EXAMPLES / "pocket.toml", tmp_path / "pocket.mod")
    expected = (120.0 * 80.0 - (4 - np.pi) * 64.0) * 12.0
    assert done.report["cut"]["removed_mm3"] == pytest.approx(expected, rel=0.005)
    assert done.report["predicted_error_mm"]["before"]["mean"] > 0.1
    assert done.report["predicted_error_mm"]["after"]["max"] < 0.001
    assert not any(f.level == "error" for f in done.findings)
