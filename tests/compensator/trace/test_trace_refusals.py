"""Traces that are refused: every message names file, row or key, value, and what to do."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from compensator.errors import CompensatorError
from compensator.tasks.measurements import load_measurement
from compensator.trace.thinning import MOST, thinned
from compensator.trace.trace import load_trace
from stiffness.errors import StiffnessError
from stiffness.session.turning import turning_rows
from tests.compensator.trace.test_traces_of_the_plant import CENTRE, circles
from tests.trace_bench import ballbar, positions, write_trace

Change = Callable[[dict[str, Any]], None]


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory):
    return circles(tmp_path_factory.mktemp("trace"), points=40)


def refused(path: Path) -> str:
    with pytest.raises((CompensatorError, StiffnessError)) as caught:
        load_trace(path)
    return str(caught.value)


def trace_with(ran, change: dict[str, Any], kind: str = "positions", columns: Any = None) -> Path:
    at = np.arange(len(ran.tcp))
    given = columns or {"index": at, **dict(zip("xyz", ran.tcp.T * 1e3, strict=True))}
    more = {k: v for k, v in change.items() if k != "kind"}
    return write_trace(ran, change.get("kind", kind), given, 0.005, "changed", **more)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"registred": False}, ("unknown key registred", "did you mean registered?")),
        ({"approach": [1, 0]}, ("approach has 2 numbers, expected 6",)),
        ({"approach": [2, 0, 0, 0, 0, 0]}, ("expected -1, 0 (unknown) or 1",)),
        ({"instrument": {"noise": 0.0}}, ("instrument.noise = 0.0", "above 0")),
        ({"kind": "ballbar"}, ("needs [ballbar]",)),
        ({"kind": "balbar"}, ("kind",)),
        ({"ballbar": {"center": [1500.0, 0.0, 900.0], "radius": 150.0}}, ("[ballbar] with kind = 'positions'",)),
        ({"cell": "nowhere.toml"}, ("nowhere.toml", "no such file")),
        ({"program": "nowhere.csv"}, ("nowhere.csv", "no such file")),
    ],
)
def test_keys(ran, change: dict[str, Any], words: tuple[str, ...]) -> None:
    text = refused(trace_with(ran, change))
    assert all(word in text for word in words), text


def test_registered_is_not_of_a_ballbar(ran) -> None:
    assert "registered is not of a ball-bar" in refused(ballbar(ran, 0.005, CENTRE, name="bar", registered=True))


@pytest.mark.parametrize(
    ("column", "value", "words"),
    [
        ("index", 1e6, "counted from 0"),
        ("index", 0.5, "between a rapid and a cut"),
        ("x", "1,5", "row 3, column x"),
        ("sd", -1.0, "above zero"),
        ("time", "soon", "not a number"),
    ],
)
def test_cells(ran, column: str, value: Any, words: str) -> None:
    at = np.arange(len(ran.tcp))
    columns: dict[str, Any] = {"index": at.astype(object)}
    columns |= dict(zip("xyz", (ran.tcp.T * 1e3).astype(object), strict=True))
    columns.setdefault(column, np.ones(len(at), dtype=object))
    columns[column] = columns[column].copy()
    columns[column][1] = value
    text = refused(trace_with(ran, {}, columns=columns))
    assert words in text and "changed-samples.csv" in text and "row 3" in text, text


def test_a_missing_column_is_named(ran) -> None:
    text = refused(trace_with(ran, {}, columns={"index": [0, 1], "x": [1.0, 2.0], "y": [1.0, 2.0]}))
    assert "column z missing" in text


def test_a_program_of_another_tool_is_refused(ran, tmp_path: Path) -> None:
    path = positions(ran, 0.005, name="moved")
    cell = ran.bench.folder / "cell.toml"
    before = cell.read_text()
    try:
        cell.write_text(before.replace("220.0", "230.0"))
        text = refused(path)
    finally:
        cell.write_text(before)
    assert "run.csv" in text and "robot, tool and work object of the cell" in text


def test_the_model_of_the_cell_may_be_missing_and_a_trace_is_known_by_its_schema(ran) -> None:
    path = positions(ran, 0.005, name="bare")
    cell = ran.bench.folder / "cell.toml"
    before = cell.read_text()
    try:
        cell.write_text("\n".join(line for line in before.splitlines() if not line.startswith("model = ")))
        session = load_measurement(path)
    finally:
        cell.write_text(before)
    assert session.path is not None and session.path.kind == "positions" and len(session) == len(ran.tcp)


def test_a_hundred_thousand_samples_are_thinned_and_turning_points_stay(ran) -> None:
    rows = load_trace(positions(ran, 0.005)).path.rows
    index = np.linspace(0, len(rows) - 1, 100_000)
    kept = thinned(index, np.zeros(len(index), dtype=np.int64), rows)
    assert len(kept) <= MOST and np.all(np.diff(kept) > 0)
    (turns, *_) = turning_rows(rows.q)
    for row in turns:
        assert np.abs(index[kept] - row).min() < 0.02


def test_the_notes_tell_how_many_samples_take_part(ran) -> None:
    at = np.linspace(1, len(ran.tcp) - 1, 5000)
    low = np.minimum(np.floor(at).astype(int), len(ran.tcp) - 2)
    share = (at - low)[:, None]
    read = (1 - share) * ran.tcp[low] + share * ran.tcp[low + 1]
    session = load_trace(trace_with(ran, {}, columns={"index": at, **dict(zip("xyz", read.T * 1e3, strict=True))}))
    assert f"{len(session)} of 5000 samples take part" in session.path.notes[0]
