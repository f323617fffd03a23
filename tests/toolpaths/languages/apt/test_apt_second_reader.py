"""Random APT/CL and CLSF programs, read also by a second reader."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.oracles.apt_reader import Corner, Second
from tests.oracles.random_apt import RandomApt
from toolpaths.files import read_toolpath

PROGRAMS = 150


@pytest.mark.parametrize("part", range(3))
def test_random_programs_agree_with_the_second_reader(tmp_path: Path, part: int) -> None:
    arcs = drilled = 0
    for seed in range(part * PROGRAMS // 3, (part + 1) * PROGRAMS // 3):
        text = RandomApt(seed).text()
        second = Second()
        corners = second.read(text)
        (tmp_path / "p.cls").write_text(text)
        path = read_toolpath(tmp_path / "p.cls", chord=1e-4)
        unit = second.unit * 1e-3
        at = np.flatnonzero(path.row % 1 == 0)
        assert len(at) == len(corners), (seed, text)
        np.testing.assert_allclose(path.position[at], np.array([c.xyz for c in corners]) * unit, rtol=0, atol=1e-9)
        np.testing.assert_allclose(path.axis[at], [c.axis for c in corners], rtol=0, atol=1e-8)
        np.testing.assert_array_equal(path.kind[at] == 0, [c.rapid for c in corners])
        np.testing.assert_allclose(path.feed[at] * 60, np.array([c.feed for c in corners]) * unit, rtol=1e-9)
        np.testing.assert_array_equal(path.tool[at], [c.tool for c in corners])
        np.testing.assert_allclose(path.spindle[at] * 30 / np.pi, [c.rpm for c in corners], rtol=1e-12)
        np.testing.assert_array_equal(path.sense[at], [c.sense for c in corners])
        arcs += check_arcs(path.position, path.row, corners, unit)
        drilled += "CYCLE" in text.upper()
    assert arcs > 100 and drilled > 30


def check_arcs(position: np.ndarray, row: np.ndarray, corners: list[Corner], unit: float) -> int:
    """Every pose between two corners lies on the helix of the arc there, or there is none; how many arcs."""
    for number, corner in enumerate(corners):
        inside = np.flatnonzero((row > number - 1) & (row < number))
        if corner.arc is None:
            assert len(inside) == 0
            continue
        center, normal, sweep = corner.arc
        start = corners[number - 1].xyz
        rise = np.dot(corner.xyz - start, normal)
        share = row[inside] - (number - 1)
        turned = Rotation.from_rotvec(np.outer(share * sweep, normal)).apply(start - center)
        expected = (center + turned + np.outer(share * rise, normal)) * unit
        np.testing.assert_allclose(position[inside], expected, rtol=0, atol=2e-8)
        assert len(inside) >= abs(sweep) / (np.pi / 4) - 1
    return sum(c.arc is not None for c in corners)
