"""The picture of frames and signs: what it shows is what the page says."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

PAGE = Path(__file__).parents[1] / "docs" / "frames.md"


def test_signs_and_frames_are_as_the_page_has_them() -> None:
    pytest.importorskip("matplotlib")
    from docs.make_frames_picture import WRENCH, shown

    s = shown()
    assert f"{WRENCH[0]:.0f} N along x and {WRENCH[2]:.0f} N along z" in PAGE.read_text(encoding="utf-8")
    assert s.force == pytest.approx(WRENCH[:3])
    assert s.deflection @ s.force > 0.8 * np.linalg.norm(s.deflection) * np.linalg.norm(s.force)
    assert s.deflection[0] > s.deflection[2] > 5e-4 and abs(s.deflection[1]) < 1e-6
    assert 1e-6 < np.linalg.norm(s.correction + s.deflection) < 1e-5
    assert s.axis == pytest.approx(-s.links.rotation[-1][:, 2], abs=1e-9)
    tool = s.links.rotation[-2].T @ (s.links.origin[-1] - s.links.origin[-2])
    assert tool == pytest.approx([0.0, 0.0, 0.35], abs=1e-9)
    assert s.work.rotation == pytest.approx(np.eye(3)) and s.work.origin == pytest.approx([1.05, 0.0, 0.7])
