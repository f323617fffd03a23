"""A few cases of the traces report, and its judge: causes in no catalogue, nothing wrong, numbers known together."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from tests.traces_report.case import Named, Row, run
from tests.traces_report.causes import Scenario, scenarios
from tests.traces_report.judge import misses
from tests.traces_report.table import markdown


@pytest.fixture(scope="module")
def keep(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Programs and models at hand are made once."""
    yield tmp_path_factory.mktemp("traces")


def named(name: str, kind: str) -> Scenario:
    return next(s for s in scenarios() if (s.name, s.kind) == (name, kind))


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("unknown servo lag joint-1", "ballbar"),
        ("unknown servo lag joint-2", "ballbar"),  # the play of two joints would explain it, with more numbers
        ("backlash joint-1 + joint-friction joint-2", "ballbar"),  # each joint has its group
        ("base-compliance", "surface"),  # a larger force and a smaller cutter: two effects where one does
        ("unknown fixture slip", "surface"),
        ("clean 1", "surface"),
        ("base-compliance", "positions"),  # coupled joints and other springs explain the same: it is in their group
        ("softer joint-3", "positions"),  # no stiffness stands out by itself: they are known together only
    ],
)
def test_a_case_meets_its_target(keep: Path, name: str, kind: str) -> None:
    row = run(named(name, kind), "healthy", keep)
    assert misses(row) == []


GOOD = Row(
    scenario="backlash joint-1", kind="ballbar", flow="healthy", truth=(("backlash", ("joint-1",)),), change=3.1,
    left=3.0, verdict="explained", named=(Named("backlash", ("joint-1",), ()),), points_at=(("joint-1", 0.9, "speed"),),
    next_traces=(), before=2e-5, after=5.1e-6, told=5e-6, seconds=1.0,
)  # fmt: skip
LAG = replace(
    GOOD, truth=(("unknown", ("joint-1", "speed")),), verdict="unexplained", named=(), told=None,
    points_at=(("joint-1", 0.9, "speed of joint 1"),),
)  # fmt: skip


@pytest.mark.parametrize(
    ("row", "why"),
    [
        (replace(GOOD, after=5.6e-6), "1.12 x told"),
        (replace(GOOD, named=()), "backlash not named"),
        (replace(GOOD, named=(Named("backlash", ("joint-2",), ()),)), "backlash named in joint-2"),
        (replace(GOOD, named=(*GOOD.named, Named("payload", ("tool",), ()))), "payload tool invented"),
        (replace(GOOD, truth=(), verdict="adequate"), "backlash joint-1 invented"),
        (replace(GOOD, flow="sheet", verdict="adequate"), "verdict adequate"),
        (replace(LAG, points_at=(("link-1", 0.9, ""),)), "points at link-1 first, not joint-1"),
        (replace(LAG, points_at=(("joint-1", 0.9, "angle of joint 1"),)), "follows angle of joint 1, not its speed"),
        (replace(LAG, verdict="explained"), "verdict explained"),
    ],
)
def test_what_misses_the_target(row: Row, why: str) -> None:
    assert misses(row) == [why]
    assert why in markdown([row]) and "**missed**" in markdown([row])


def test_what_meets_it() -> None:
    lost = replace(GOOD, flow="sheet", left=0.3, verdict="adequate", named=(), after=1e-3)
    assert misses(lost) == []
    assert misses(replace(lost, flow="healthy")) != []
    group = replace(GOOD, named=(Named("joint-stiffness", ("joint-2",), ("backlash",), True),))
    assert [misses(r) for r in (GOOD, LAG, group)] == [[], [], []]


def test_each_joint_of_an_effect_stands_for_one_cause() -> None:
    both = Named("backlash", ("joint-1", "joint-2"), ("joint-friction",))
    pair = replace(GOOD, named=(both,), truth=(*GOOD.truth, ("joint-friction", ("joint-2",))))
    assert misses(pair) == []
    assert misses(replace(pair, named=(replace(both, where=("joint-1",)),))) == ["joint-friction not named"]
    assert misses(replace(pair, named=(replace(both, confused_with=()),))) == ["joint-friction not named"]
    beside = (Named("joint-hardening", ("joint-1",), ()), *GOOD.named)
    assert misses(replace(GOOD, named=beside)) == ["joint-hardening joint-1 invented"]
