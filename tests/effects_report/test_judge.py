"""The judge of the effects report: what meets the target, and above all what does not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffness.effects import BY_NAME
from tests.effects_report.__main__ import QUICK
from tests.effects_report.case import Named, Row
from tests.effects_report.judge import misses, within
from tests.effects_report.table import markdown
from tests.effects_report.told import SINGLY, sites, told
from tests.plant.ailment import Truth
from tests.plant.cell_design import CELLS
from tests.plant.cells import SCENARIOS, SINGLE

GOOD = Row(
    arm="ur10", scenario="backlash joint-1", seed=1, size=3.0, of="left",
    truth=(("backlash", ("joint-1",)),), change=4.0, left=3.0, verdict="explained",
    named=(Named("backlash", ("joint-1",), ()),), added=("backlash",),
    at_hand=("joint-stiffness",), moved=(), points_at=(("joint-1", 0.9, "approach"),),
    before={"displacement": 9e-5, "absolute": 7e-5}, after={"displacement": 3e-5, "absolute": 2.1e-5},
    floor={"displacement": 3e-5, "absolute": 2e-5}, told={"displacement": 2.9e-5, "absolute": 2.05e-5},
    distances={"backlash gap_rad[1]": 1.4, "joint-stiffness k_nm_per_rad[1]": -0.3}, notes=(), seconds=1.0,
)  # fmt: skip
TWO = replace(
    GOOD, truth=(*GOOD.truth, ("payload", ("tool",))), named=(Named("payload", ("tool",), ()), *GOOD.named)
)
UNKNOWN = replace(
    GOOD, truth=(("unknown", ("joint-5", "column:spindle")),), verdict="unexplained", named=(), told=None, distances={}
)
CLEAN = replace(GOOD, scenario="clean", truth=(), verdict="adequate", named=(), distances={})


@pytest.mark.parametrize(
    "row",
    [
        GOOD,
        TWO,
        replace(GOOD, named=(Named("preload-softening", ("joint-1",), ("backlash",)),)),
        replace(UNKNOWN, points_at=(("joint-5", 0.8, ""), ("joint-4", 0.7, ""))),
        replace(UNKNOWN, points_at=(("column:spindle", 0.8, ""), ("joint-4", 0.7, ""))),
        CLEAN,
    ],
)
def test_what_meets_the_target(row: Row) -> None:
    assert misses(row) == []


@pytest.mark.parametrize(
    ("row", "word"),
    [
        (replace(GOOD, verdict="unexplained"), "verdict unexplained"),
        (replace(GOOD, verdict="adequate", named=()), "backlash not named"),
        (replace(GOOD, named=(Named("backlash", ("joint-2",), ()),)), "backlash named in joint-2"),
        (replace(GOOD, named=(*GOOD.named, Named("payload", ("tool",), ()))), "payload tool invented"),
        (replace(GOOD, named=(Named("joint-friction", ("joint-1",), ()),)), "backlash not named"),
        (replace(TWO, named=TWO.named[:1]), "backlash not named"),
        (replace(GOOD, after={"displacement": 3.1e-5, "absolute": 2.05e-5}), "displacement 1.07 x told"),
        (replace(GOOD, after={"displacement": 2.9e-5, "absolute": 2.3e-5}), "absolute 1.12 x told"),
        (replace(UNKNOWN, points_at=(("joint-4", 0.8, ""), ("joint-5", 0.7, ""))), "points at joint-4 first"),
        (replace(UNKNOWN, points_at=()), "points at nothing"),
        (replace(UNKNOWN, verdict="explained", named=GOOD.named), "backlash joint-1 invented"),
        (replace(CLEAN, moved=("joint-stiffness k_nm_per_rad joint-3",)), "joint-3 moved"),
        (replace(CLEAN, verdict="explained", named=GOOD.named), "backlash joint-1 invented"),
    ],
)
def test_what_does_not(row: Row, word: str) -> None:
    assert any(word in said for said in misses(row))
    assert "Not met" in markdown([row]) and "**missed**" in markdown([row])


def test_what_was_learned_is_judged_by_the_floor() -> None:
    """A table of a joint's angle may learn a ripple that is in no catalogue."""
    ripple = replace(
        GOOD, scenario="unknown ripple", truth=(("unknown", ("joint-3",)),), told=None,
        named=(Named("joint-angle-error", ("joint-3",), ()),), distances={},
    )  # fmt: skip
    assert misses(ripple) == []
    assert misses(replace(ripple, named=(Named("joint-angle-error", ("joint-2",), ()),))) != []
    assert misses(replace(ripple, after={"displacement": 3e-5, "absolute": 3e-5})) != []
    assert misses(replace(ripple, scenario="unknown brake")) != []


def test_numbers_count_where_they_can_be_compared() -> None:
    far = replace(GOOD, distances={"gap": -3.2, "joint-stiffness": 2.1})
    assert within([GOOD, far, UNKNOWN], 3.0) == (3, 4)
    assert within([GOOD, far, UNKNOWN], 1.96) == (2, 4)
    text = markdown([GOOD, far, UNKNOWN])
    assert "of 2 cases that are met: 3 of 4 within three standard deviations (75.0 %), 2 within" in text
    assert "| -3.2 gap of 2 |" in text


def test_a_size_without_target_is_in_a_table_and_not_in_the_count() -> None:
    text = markdown([GOOD, replace(GOOD, size=1.5, verdict="unexplained")])
    assert "one effect: 1 of 1 met" in text
    assert "(missed)" in text and "Every one met." in text


@pytest.mark.parametrize("name", [n for n, a in SINGLE.items() if a.known])
def test_words_of_the_plant_are_sites_and_numbers_of_the_catalogue(name: str) -> None:
    """Every place that an ailment names is a site, and every number told lies where the effect allows it."""
    ailment = SINGLE[name]
    effect = BY_NAME[ailment.effect]
    for cell in CELLS.values():
        factor = min(ailment.start, 0.5)
        _, values = ailment.apply(cell.healthy, cell.arm, factor)
        found = sites(effect, ailment.where, 6)
        assert {w for s in found for w in s.where} == {"tool" if w == "link-6" else w for w in ailment.where}
        hint = told(Truth(ailment.effect, ailment.where, ailment.law, factor, values, 1.0, 1.0), cell)
        parameters = {p.name: p for p in effect.parameters}
        for numbers in (hint.exact, *hint.starts):
            for (parameter, index), value in numbers.items():
                p = parameters[parameter]
                assert 0 <= index < p.count(6)
                assert p.low <= value <= p.high
        hinted = any(np.any(np.array(list(n.values()), dtype=float)) for n in (hint.exact, *hint.starts))
        assert hinted != (len(ailment.where) > 1 and ailment.effect in SINGLY)


def test_quick_cases_are_there() -> None:
    assert {name for _, name, _ in QUICK} <= set(SCENARIOS)
    assert {arm for arm, _, _ in QUICK} <= set(CELLS)
