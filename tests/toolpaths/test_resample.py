"""Sampling: bounds held, nothing moved, sampling twice changes nothing."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from toolpaths.errors import ReadError, ToolpathError
from toolpaths.resample import ANGLE, resample
from toolpaths.toolpath import CLOCKWISE, CUT, RAPID, Event, Toolpath, tool_axis


def make(position: np.ndarray, axis: np.ndarray | None = None, quaternion: np.ndarray | None = None) -> Toolpath:
    n = len(position)
    if quaternion is not None:
        axis = tool_axis(quaternion)
    return Toolpath(
        source="x.csv",
        language="csv",
        position=np.asarray(position, dtype=float),
        axis=np.tile([0.0, 0.0, 1.0], (n, 1)) if axis is None else axis,
        quaternion=quaternion,
        feed=np.arange(n) * 1e-3,
        kind=(np.arange(n) % 2).astype(np.uint8),
        tool=np.arange(n, dtype=np.int32) // 2,
        spindle=np.full(n, 100.0),
        sense=np.full(n, CLOCKWISE),
        line=np.arange(n, dtype=np.int32) + 2,
        row=np.arange(n, dtype=float),
    )


def random_path(seed: int, n: int, *, turned: bool) -> Toolpath:
    rng = np.random.default_rng(seed)
    position = np.cumsum(rng.normal(size=(n, 3)) * rng.choice([0.0, 1e-4, 0.01, 0.3], size=(n, 1)), axis=0)
    if turned:
        return make(position, quaternion=np.roll(Rotation.random(n, random_state=seed).as_quat(), 1, axis=1))
    axis = rng.normal(size=(n, 3))
    axis[rng.random(n) < 0.3] = [0, 0, 1]
    return make(position, axis / np.linalg.norm(axis, axis=1, keepdims=True))


def test_values() -> None:
    path = make(np.array([[0, 0, 0], [0.01, 0, 0], [0.01, 0.0, 0.001]]))
    path = replace(path, events=(Event(0, "a", 1), Event(1, "b", 2), Event(2, "c", 3), Event(3, "d", 4)))
    new = resample(path, spacing=0.004)
    np.testing.assert_allclose(new.position[:, 0], [0, 0.01 / 3, 0.02 / 3, 0.01, 0.01], rtol=1e-14)
    np.testing.assert_allclose(new.row, [0, 1 / 3, 2 / 3, 1, 2], rtol=1e-14)
    np.testing.assert_array_equal(new.kind, [RAPID, CUT, CUT, CUT, RAPID])
    np.testing.assert_array_equal(new.feed, [0, 1e-3, 1e-3, 1e-3, 2e-3])
    np.testing.assert_array_equal(new.tool, [0, 0, 0, 0, 1])
    np.testing.assert_array_equal(new.line, [2, 3, 3, 3, 4])
    assert [(e.pose, e.word) for e in new.events] == [(0, "a"), (1, "b"), (4, "c"), (5, "d")]


def test_turns_are_split_by_the_angle() -> None:
    quarter = make(np.zeros((2, 3)), np.array([[0, 0, 1.0], [1.0, 0, 0]]))
    for tolerance in (0.1, 0.5, 3.0):
        new = resample(quarter, spacing=1.0, angle=math.radians(tolerance))
        steps = math.ceil((math.pi / 2) / math.sqrt(8 * math.radians(tolerance)))
        assert len(new) == steps + 1
        tilt = np.arange(steps + 1) * (math.pi / 2) / steps
        expected = np.column_stack([np.sin(tilt), 0 * tilt, np.cos(tilt)])
        np.testing.assert_allclose(new.axis, expected, rtol=0, atol=1e-15)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000), st.floats(1e-4, 1.0), st.floats(1e-4, 0.5), st.booleans())
def test_bounds_hold_and_twice_is_once(seed: int, spacing: float, angle: float, turned: bool) -> None:
    path = random_path(seed, 12, turned=turned)
    new = resample(path, spacing=spacing, angle=angle)
    step = np.linalg.norm(np.diff(new.position, axis=0), axis=1)
    assert step.max() <= spacing * (1 + 2e-6)
    most = math.sqrt(8 * angle) * (1 + 2e-6) + 1e-7
    if turned:
        assert new.quaternion is not None
        dot = np.abs(np.einsum("ij,ij->i", new.quaternion[1:], new.quaternion[:-1]))
        assert 2 * np.arccos(np.minimum(dot, 1)).max() <= most
        np.testing.assert_allclose(np.linalg.norm(new.quaternion, axis=1), 1, rtol=0, atol=1e-14)
        np.testing.assert_allclose(new.axis, tool_axis(new.quaternion), rtol=0, atol=1e-14)
    else:
        assert np.arccos(np.clip(np.einsum("ij,ij->i", new.axis[1:], new.axis[:-1]), -1, 1)).max() <= most
    kept = np.searchsorted(new.row, path.row)
    for name in ("position", "axis", "feed", "kind", "tool", "line", "row"):
        np.testing.assert_array_equal(getattr(new, name)[kept], getattr(path, name), err_msg=name)
    assert resample(new, spacing=spacing, angle=angle) is new


@pytest.mark.parametrize("seed", range(5))
def test_orientations_against_scipy(seed: int) -> None:
    path = random_path(seed, 8, turned=True)
    new = resample(path, spacing=0.01, angle=ANGLE)
    assert path.quaternion is not None and new.quaternion is not None and len(new) > 100
    rotations = Rotation.from_quat(np.roll(path.quaternion, -1, axis=1))
    expected = Slerp(path.row, rotations)(new.row)
    ours = Rotation.from_quat(np.roll(new.quaternion, -1, axis=1))
    assert (expected.inv() * ours).magnitude().max() < 1e-10
    np.testing.assert_allclose(new.position[:, 0], np.interp(new.row, path.row, path.position[:, 0]), atol=1e-12)


def test_axis_lies_in_the_plane_of_its_ends() -> None:
    path = random_path(3, 20, turned=False)
    new = resample(path, spacing=0.05)
    end = np.ceil(new.row).astype(int)
    normal = np.cross(path.axis[np.maximum(end - 1, 0)], path.axis[end])
    np.testing.assert_allclose(np.einsum("ij,ij->i", normal, new.axis), 0, atol=1e-14)


def test_reversed_axis_is_refused_by_line() -> None:
    path = make(np.zeros((3, 3)), np.array([[0, 0, 1.0], [0, 0, 1.0], [0, 0, -1.0]]))
    with pytest.raises(ReadError, match=r"x\.csv:4: the tool axis turns to its opposite"):
        resample(path, spacing=0.1)


def test_senseless_arguments() -> None:
    path = make(np.array([[0.0, 0, 0], [900.0, 0, 0]]))
    for spacing, angle in ((0.0, 1.0), (-1.0, 1.0), (1.0, 0.0), (math.nan, 1.0)):
        with pytest.raises(ValueError, match="above 0"):
            resample(path, spacing=spacing, angle=angle)
    with pytest.raises(ToolpathError, match=r"makes 900,000,000 poses; at most 2,000,000 .* take more than"):
        resample(path, spacing=1e-6)
    assert len(resample(path.take([0]), spacing=1e-6)) == 1
