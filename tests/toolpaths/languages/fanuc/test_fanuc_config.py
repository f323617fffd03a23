"""Fanuc .ls in place: CONFIG of corrected positions, and what a warning says of postures."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from tests.oracles.commanded import commanded
from tests.oracles.commanded import run as run_filter
from tests.oracles.tp_programs import SOURCE, program, record
from toolpaths.languages.fanuc.config import continued_turns, turn_numbers

run = partial(run_filter, "test.ls")


def test_turn_numbers_follow_a_correction_past_180_degrees(tmp_path):
    """Of the poses of the file and of those put in; 0 strictly between -180 and 180, 180 is turn 1."""
    at = [("N U T, 0, 0, 0", 0), ("N U T, 0, 0, 0", 10), ("N U T, 0, -1, 1", 20), ("N U T, 0, 0, 0", 30)]
    records = "".join(record(n, x, 0).replace("N U T, 0, 0, 1", config) for n, (config, x) in enumerate(at, 1))
    text = program(["J P[1] 20% FINE", *[f"L P[{n}] 20mm/sec FINE" for n in (2, 3, 4)]], records)
    # J1, J4, J6 of the file's poses as the controller counts them: before and behind the correction
    nominal = np.array([[10, -179.0, 170], [10, -179.8, 179.8], [10, -180.2, 180.3], [10, -179.7, 179.5]])
    wanted = np.array([[10, -179.0, 170], [10, -180.1, 180.2], [10, -180.1, 180.2], [10, -179.9, 179.9]])
    between = (np.array([0.5 * (nominal[1] + nominal[2])]), np.array([[10, -180.15, 179.9]]))

    def make(t, off):
        made, row = commanded(t, [0, 1, 2, 2, 3], np.array([0, 0, 1e-4]))
        row = np.array([0.0, 1.0, 1.5, 2.0, 3.0])
        both = []
        for table, inside in zip((nominal, wanted), between, strict=True):
            q = np.zeros((5, 6))
            q[:, [0, 3, 5]] = np.insert(table, 2, inside[0], axis=0) + 360.0 * np.array(off)
            both.append(np.radians(q))
        return replace(made, nominal_joints=both[0], joints=both[1]), row

    for off in ((0, 0, 0), (0, 1, -1), (-1, -2, 0)):  # the model counts whole turns from elsewhere
        _, _, done = run(tmp_path, text, lambda t, off=off: make(t, off))
        new = done.text.decode()
        configs = dict(re.findall(r"^P\[(\d)\]\{.*?CONFIG : '(.*?)'", new, re.M | re.S))
        assert configs == {
            "1": "N U T, 0, 0, 0", "2": "N U T, 0, -1, 1", "3": "N U T, 0, -1, 1", "4": "N U T, 0, 0, 0",
            "5": "N U T, 0, -1, 0",
        }  # fmt: skip


@pytest.mark.parametrize("seed", range(20))
def test_turn_numbers_of_random_paths(seed):
    """Joints that wander over several turns; the model is up to 0.04 deg off the controller, and whole turns."""
    g = np.random.default_rng(seed)
    controller = np.cumsum(g.normal(scale=25.0, size=(400, 3)), axis=0)
    model = controller + g.uniform(-0.04, 0.04, (400, 3)) + 360.0 * g.integers(-2, 3, 3)
    moved = g.uniform(-3.0, 3.0, (400, 3))
    said = turn_numbers(controller).astype(float)
    said[g.random((400, 3)) < 0.2] = np.nan  # poses put in
    said[0] = turn_numbers(controller[0])
    got = continued_turns(said, model, model + moved)
    clear = np.abs((controller + moved) % 360.0 - 180.0) > 0.2
    wrong = clear & (got != turn_numbers(controller + moved))
    assert clear.mean() > 0.95 and not wrong.any()
    np.testing.assert_array_equal(
        turn_numbers(np.array([179.999, -179.999, 180, -180, 540, -540])), [0, 0, 1, -1, 2, -2]
    )


def test_another_posture_and_unseen_calls_are_said(tmp_path):
    text = SOURCE.replace("DO[1]=ON", "CALL GUN_ON(3)")
    (tmp_path / "test.ls").write_text(text)

    def make(t):
        made, row = commanded(t, np.arange(len(t)), np.array([0, 0, 1e-4]))
        return replace(made, configuration=np.zeros(len(t), dtype=np.int32)), row

    _, _, done = run(tmp_path, text, make)
    first, second = done.changes[:2]
    assert "test.ls:7" in str(first) and "CONFIG says N U T, the arm was solved as F U T" in str(first)
    assert first.count == 5 and "test.ls:9: CALL GUN_ON: GUN_ON.ls is not beside" in str(second)
    assert "CONFIG : 'F" not in done.text.decode()
