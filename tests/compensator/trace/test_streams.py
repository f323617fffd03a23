"""Streams of positions that have a time and no row, of programs that ran on the plant."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from compensator.errors import TraceError
from compensator.tasks.diagnose import diagnose_files
from compensator.tasks.identify import evaluate_file
from compensator.trace.trace import load_trace
from tests.compensator.trace.test_traces_of_the_plant import GAP, NOISE, added, circles
from tests.trace_bench import Ran, write_trace

FEED = 1000.0 / 6e4  # m/s
RATE = 2.5  # readings a second


def clock(ran: Ran) -> np.ndarray:
    """s at every row, from the feed along the commanded path."""
    way = np.linalg.norm(np.diff(ran.table.command[:, :3, 3], axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(way / FEED)])


def stream(ran: Ran, row_time: np.ndarray, *, late: float = 7.3, stands: float = 2.0, name: str = "stream") -> Any:
    """(time s, reading mm) of a tracker whose clock is `late`, that reads before and after the arm moves."""
    time = np.arange(-stands, row_time[-1] + stands, 1 / RATE)
    read = np.stack([np.interp(time, row_time, axis) for axis in ran.tcp.T], axis=1) * 1e3
    return time + late, read + np.random.default_rng(3).normal(0, NOISE, read.shape)


def written(ran: Ran, time: np.ndarray, read: np.ndarray, **more: Any) -> Path:
    columns = {"time": time, **dict(zip("xyz", read.T, strict=True))}
    return write_trace(ran, "positions", columns, NOISE, "stream", **more)


def rows_of(ran: Ran, row_time: np.ndarray, time: np.ndarray) -> np.ndarray:
    return np.interp(time, row_time, np.arange(len(row_time), dtype=float))


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> Ran:
    """Circles in two planes, both ways; joint 1 has a gap that the model does not know."""
    return circles(tmp_path_factory.mktemp("stream"), planes=("xy", "xz"), points=60, gap=GAP, breakaway=1e9)


def test_at_the_programmed_feed_the_rows_are_those_of_the_clock(ran: Ran) -> None:
    time, read = stream(ran, clock(ran))
    session = load_trace(written(ran, time, read))
    path = session.path
    assert path is not None and path.lagging
    true = rows_of(ran, clock(ran), session.samples.time - 7.3)
    step = np.linalg.norm(np.diff(ran.table.command[:, :3, 3], axis=0), axis=1)[1:].mean()
    assert np.abs(path.index - true).max() * step < 2e-4  # m: what the arm deflects along its path
    assert np.ptp(path.index - true) * step < 1e-5  # but all of them alike
    assert len(session) > 0.9 * (time[-1] - time[0] - 4) * RATE
    assert any("programmed feed" in note for note in path.notes)


def test_a_gap_is_found_in_a_stream_and_the_lag_that_is_left_is_reported(ran: Ran, tmp_path: Path) -> None:
    time, read = stream(ran, clock(ran))
    path = written(ran, time, read)
    report = diagnose_files([path], path.parent / "model.toml").report
    assert added(report) == {"backlash": ["joint-1"]}
    assert report["added"][0]["parameters"]["gap_rad"]["value"] == pytest.approx(GAP[0], rel=0.05)
    assert abs(report["traces"][0]["latency_s"]) * FEED < 3e-4
    assert report["rms_mm"]["path"]["after"] < 1.5 * NOISE


def test_an_arm_that_slows_down_is_matched_by_shape(ran: Ran) -> None:
    """Half as fast in a third of the path, as a controller that blends and waits."""
    row_time = clock(ran)
    slow = np.concatenate([[0.0], np.cumsum(np.diff(row_time) * (1 + (np.arange(len(row_time) - 1) % 45 < 15)))])
    time, read = stream(ran, slow)
    session = load_trace(written(ran, time, read))
    path = session.path
    assert path is not None and not path.lagging
    step = np.linalg.norm(np.diff(ran.table.command[:, :3, 3], axis=0), axis=1)[1:].mean()
    off = np.abs(path.index - rows_of(ran, slow, session.samples.time - 7.3)) * step
    assert np.quantile(off, 0.99) < 1e-3 and np.median(off) < 2e-4
    assert any("shape of the path" in note for note in path.notes)
    _, report = evaluate_file(written(ran, time, read), ran.bench.folder / "model.toml")
    assert report["path"]["rms_mm"] < 0.2  # the gap, which the model does not know


def test_a_stream_in_a_frame_that_is_not_known_is_placed_by_its_shape(ran: Ran) -> None:
    time, read = stream(ran, clock(ran))
    turn = Rotation.from_euler("xyz", [40, -110, 75], degrees=True).as_matrix()
    path = written(ran, time, read @ turn.T + [2300.0, -2400.0, 400.0], registered=False)
    session = load_trace(path)
    assert session.path is not None
    true = rows_of(ran, clock(ran), session.samples.time - 7.3)
    step = np.linalg.norm(np.diff(ran.table.command[:, :3, 3], axis=0), axis=1)[1:].mean()
    assert np.abs(session.path.index - true).max() * step < 1e-3


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("elsewhere", ("from the commanded path", "column index")),
        ("no time", ("there is no column time",)),
        ("latency", ("instrument.latency", "take it out")),
    ],
)
def test_what_cannot_be_matched_is_refused(ran: Ran, change: str, words: tuple[str, ...]) -> None:
    time, read = stream(ran, clock(ran))
    if change == "elsewhere":
        path = written(ran, time, read + np.array([0.0, 0.0, 40.0]))
    elif change == "no time":
        path = write_trace(ran, "positions", dict(zip("xyz", read.T, strict=True)), NOISE, "stream")
    else:
        path = written(ran, time, read, instrument={"noise": NOISE, "latency": 0.02})
    with pytest.raises(TraceError) as caught:
        load_trace(path)
    assert all(word in str(caught.value) for word in words), caught.value
