"""The example's CAM file: made by its script, and a cut that touches the surface it was made for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from toolpaths.files import read_toolpath
from toolpaths.toolpath import CUT

pytest.importorskip("opencamlib", reason="opencamlib (extra `example`) is not installed")
from examples import make_example

WAVE = Path(__file__).parents[1] / "examples" / "wave.nc"


def test_the_script_writes_the_same_bytes() -> None:
    assert make_example.program().encode("ascii") == WAVE.read_bytes()


def test_the_number_of_moves_is_that_of_a_real_job() -> None:
    moves = [line for line in WAVE.read_text(encoding="ascii").splitlines() if line[:1] in {"X", "Y", "Z", "G"}]
    assert 3000 < len(moves) < 5000


def test_the_ball_touches_the_surface_and_does_not_cut_into_it() -> None:
    path = read_toolpath(WAVE)
    tips = path.position[path.kind == CUT] * 1e3
    part = (tips[:, 2] > -20) & (np.abs(tips[:, 0] - 100) < 95) & (np.abs(tips[:, 1] - 75) <= 75)
    tips = tips[part][::7]
    assert len(tips) > 300
    radius = make_example.CUTTER / 2
    around = np.linspace(-3.5, 3.5, 71)  # mm; the surface is nowhere steeper than 20 deg: touched within 2.1 mm
    gaps = []
    for x, y, z in tips:
        points = np.array([(x + a, y + b, make_example.height(x + a, y + b)) for a in around for b in around])
        gaps.append(np.linalg.norm(points - (x, y, z + radius), axis=1).min() - radius)
    # chords of facets and of the thinned path stand at most 0.02 mm off the true surface
    assert min(gaps) > -0.025
    assert max(gaps) < 0.025
    assert np.ptp(tips[:, 2]) > 8
