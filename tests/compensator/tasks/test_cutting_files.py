"""`cutting`: coefficients come back from the forces that they made; what is not determined is named."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from compensator.errors import CompensatorError
from compensator.process.milling.material import NAMES, SI, load_material
from compensator.tasks.cutting import cutting_file
from tests.compensator.process.milling.milling_jobs import arc_force
from tests.compensator.small_job import FORCES

K = np.array([700.0, 150.0, 200.0, 20.0, 20.0, 1.0])
HEAD = "shape,diameter_mm,flutes,ap_mm,entry_deg,exit_deg,feed_per_tooth_mm"


ARCS = ((-90, 90), (0, 90), (-90, 0))


def forces(
    folder: Path, feeds: tuple[float, ...], noise: float = 0.0, arcs: tuple[tuple[int, int], ...] = ARCS
) -> Path:
    """Slots and half immersions at some feeds; forces by the closed form."""
    rng, lines = np.random.default_rng(5), [f"{HEAD},fx_n,fy_n,fz_n"]
    for feed in feeds:
        for arc in arcs:
            force = arc_force(*np.radians(arc), ap=3e-3, feed=feed * 1e-3, teeth=4, coefficients=K * SI)
            force = force + noise * rng.normal(size=3)
            lines.append(f"flat,20,4,3,{arc[0]},{arc[1]},{feed},{','.join(f'{v:.6f}' for v in force)}")
    path = folder / "forces.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


def test_the_coefficients_come_back(tmp_path: Path) -> None:
    cutting_file(forces(tmp_path, (0.05, 0.1, 0.2)), tmp_path / "m.toml")
    found = load_material("m.toml", tmp_path)
    assert found.coefficients / SI == pytest.approx(K, rel=2e-3)


def test_intervals_hold_the_truth(tmp_path: Path) -> None:
    """2 N of noise: standard deviations of the right size, written with covariance and range."""
    done = cutting_file(forces(tmp_path, (0.05, 0.1, 0.15, 0.2), 2.0), tmp_path / "m.toml", json=tmp_path / "m.json")
    off = (done.fit.coefficients / SI - K) / (done.fit.sd / SI)
    assert np.abs(off).max() < 3.5 and np.sqrt(np.mean(off**2)) > 0.1
    assert done.report["rms_n"] == pytest.approx(2.0, rel=0.5)
    found = load_material("m.toml", tmp_path)
    assert found.sd is not None and found.sd == pytest.approx(done.fit.sd, rel=1e-4)
    assert found.feed_per_tooth == pytest.approx((0.05e-3, 0.2e-3))
    low, high = done.report["interval95"]["ktc"]
    assert low < 700.0 < high


def test_one_feed_does_not_tell_edge_from_chip(tmp_path: Path) -> None:
    with pytest.raises(CompensatorError, match=r"ktc is not determined: the tests do not tell .* another feed"):
        cutting_file(forces(tmp_path, (0.1,) * 4, 1.0, ((-90, 90),)), tmp_path / "m.toml")
    assert not (tmp_path / "m.toml").exists()


def test_spindle_power_gives_the_tangential_two(tmp_path: Path) -> None:
    """P = N n ap R (ktc f 2 + kte pi) for a slot, from the torque by hand."""
    lines = [f"{HEAD},power_w,spindle_rpm"]
    for feed in (0.05, 0.1, 0.2):
        torque = 4 / (2 * np.pi) * 3e-3 * 10e-3 * (K[0] * 1e6 * feed * 1e-3 * 2 + K[3] * 1e3 * np.pi)
        lines.append(f"flat,20,4,3,-90,90,{feed},{torque * 2 * np.pi * 100.0:.6f},6000")
    (tmp_path / "p.csv").write_text("\n".join(lines) + "\n")
    done = cutting_file(tmp_path / "p.csv", tmp_path / "m.toml")
    assert done.report["coefficients"]["ktc"] == pytest.approx(700.0, rel=2e-3)
    assert done.report["coefficients"]["kte"] == pytest.approx(20.0, rel=2e-2)
    assert [done.report["coefficients"][n] for n in NAMES if n not in ("ktc", "kte")] == [None] * 4
    assert "krc is not determined: spindle power" in " ".join(f["what"] for f in done.report["findings"])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("fx_n", "fx"), r"forces\.csv:1: unknown column 'fx'"),
        (("0.05", "-0.05"), r"forces\.csv:2: feed_per_tooth_mm = -0\.05; above 0"),
        (("-90,90", "90,-90"), r"forces\.csv:2: entry_deg = 90, exit_deg = -90"),
        (("flat,20,4", "flat,20,0"), r"forces\.csv:2: .*flutes"),
        (("flat,20", "flat,nan"), r"forces\.csv:2: diameter_mm = 'nan'"),
        (("flat,20", "conic,20"), r"forces\.csv:2: .*shape"),
    ],
)
def test_a_wrong_table_is_refused(tmp_path: Path, change: tuple[str, str], message: str) -> None:
    (tmp_path / "forces.csv").write_text(FORCES.replace(*change, 1))
    with pytest.raises(CompensatorError, match=message):
        cutting_file(tmp_path / "forces.csv", tmp_path / "m.toml")
