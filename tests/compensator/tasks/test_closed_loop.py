"""The circle closes: an ill cell is measured and diagnosed, and a path made with the refined model is cut on it.

All effects on all arms: `python -m tests.closed_loop`, docs/closed-loop.md.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffness.effects import CATALOGUE
from tests.closed_loop import TARGET, limits, page
from tests.compensator.ill_cells import FIRST, Ill, acting, cancelled
from tests.compensator.plant_bench import Table
from tests.plant.cells import SCENARIOS

UR10, ABB = "ur10", "abb-irb6600-175-255"
CASES = (
    ("backlash joint-1", UR10),
    ("kinematic-offset joint-3", UR10),
    ("joint-coupling joint-2 joint-3", UR10),
    ("joint-hardening joint-2", ABB),
    ("payload", ABB),
    ("thermal-drift all", ABB),
)
POSES = 60
SETUPS = 16
MICROMETRE = 1e-6


@pytest.mark.parametrize(("scenario", "arm"), CASES, ids=[" ".join(c) for c in CASES])
def test_the_refined_model_cancels_the_deflection(scenario: str, arm: str, tmp_path: Path) -> None:
    ill = Ill.make(scenario, arm, tmp_path, poses=POSES, setups=SETUPS)
    before, joints, refined = ill.errors(None), ill.errors(ill.at_hand), ill.errors(ill.refined)
    assert [a.effect for a in ill.diagnosis.added] == [t.effect for t in ill.case.truth]
    assert before.mean > 1e-3
    assert cancelled(before, joints) < TARGET  # the effect matters on this path
    assert cancelled(before, refined) >= TARGET
    assert refined.mean < joints.mean / 4
    assert refined.p95 < 0.02 * before.p95 and refined.max < 0.03 * before.max
    assert refined.poses > 0.75 * (refined.poses + len(refined.doubtful)) >= 0.75 * POSES
    gap = float(ill.plant.wear.gap.max())
    assert refined.doubtful.max(initial=0.0) < refined.max + 2.0 * gap  # off by a gap, at 2 m, never more
    check_program(ill)


def check_program(ill: Ill) -> None:
    """What was run is the printed program; and the path is hard on every joint."""
    program = Table.read(ill.folder / "refined.csv")
    plain = Table.read(ill.folder / f"{FIRST}.csv")
    assert program.cut.sum() >= POSES and not program.cut[0] and not program.cut[-1]
    believed = np.array([ill.plant.nominal(q) for q in program.q])
    commanded = ill.in_base(program.command)
    assert np.abs(believed - commanded).max() < MICROMETRE / 10
    assert np.linalg.norm(commanded - ill.wanted(program), axis=(1, 2)).max() > 1e-3
    move = np.sign(np.diff(plain.q[plain.cut], axis=0))
    assert np.all(np.sum(move[1:] != move[:-1], axis=0) >= 2)  # reversals of each joint
    assert np.ptp(plain.nominal[:, :3, 3], axis=0).min() > 0.03
    assert np.degrees(np.ptp(plain.nominal[:, :3, 2], axis=0)).max() > 5


def test_every_effect_that_acts_on_a_path_is_in_the_table() -> None:
    """All of the catalogue that some cell is ill with, but instruments."""
    known = {e.name: e.scope for e in CATALOGUE}
    ill = {s.effects[0][0] for s in SCENARIOS.values() if len(s.effects) == 1} & set(known)
    assert {SCENARIOS[name].effects[0][0] for name in acting()} == {n for n in ill if known[n] != "instruments"}
    assert len(ill) >= 14


def made_up(cancels: float, **other: object) -> dict[str, object]:
    numbers = {"mean": 2.0, "p95": 3.0, "max": 4.0, "poses": 90, "doubtful": 0, "doubtful_max": 0.0}
    return {
        "scenario": "x",
        "arm": "ur10",
        "none": numbers,
        "joints": numbers,
        "refined": numbers,
        "cancelled": cancels,
        "verdict": "explained",
        "added": ["x joint-1"],
        **other,
    }


def test_the_table_says_what_missed_and_why() -> None:
    text = "before\n<!-- table -->\nstale\n<!-- end -->\nafter\n"
    told = {"mean": 3.0, "cancelled": 0.995}
    rows = [
        made_up(0.9991),
        made_up(0.96, told=told, quiet={"mean": 1.0, "cancelled": 0.999}, verdict="unexplained", added=[]),
        made_up(0.985, told={"mean": 3.0, "cancelled": 0.985}, quiet={"mean": 2.9, "cancelled": 0.985}),
        made_up(0.985, told={"mean": 3.0, "cancelled": 0.985}, quiet={"mean": 0.1, "cancelled": 0.999}),
    ]
    assert [limits(r).split(":")[0] for r in rows] == ["", "the diagnosis", "law of the effect", "noise of the session"]
    made = page(text, rows)
    assert made.startswith("before\n") and made.endswith("<!-- end -->\nafter\n") and "stale" not in made
    assert "1 of 4" in made and "99.91 %" in made and "**96.00 %**" in made and "| unexplained |" in made
