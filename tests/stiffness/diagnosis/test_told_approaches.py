"""Sessions without approach columns: flanks of a gap are read off the readings, nothing else is taken for them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stiffness.diagnosis.diagnose import diagnose
from stiffness.diagnosis.flanks import _left, _turned, square
from stiffness.diagnosis.result import AddedEffect
from stiffness.diagnosis.told_approaches import MISSING, RIGHT, told_approaches, with_told_approaches
from stiffness.identify import identify
from stiffness.session.session import Session, load_session
from tests.plant.cells import SCENARIOS, write
from tests.stiffness.diagnosis.sick import KUKA

GAP = "backlash joint-5 no torque carries"


def blind(session: Session) -> Session:
    """The same without its columns."""
    s = session.samples
    nothing = replace(s, approach=np.zeros_like(s.approach), step=np.full_like(s.step, np.nan))
    return replace(session, samples=nothing)


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> Session:
    folder: Path = tmp_path_factory.mktemp("gap")
    case = write(SCENARIOS[GAP], folder, 1, KUKA, size=3.0, sessions=("D",))
    return load_session(case.paths["D"])


def test_the_flanks_of_a_gap_are_those_that_the_joint_came_by(seen: Session) -> None:
    session = blind(seen)
    fit = identify([session])
    assert fit.solution.misfit > 2
    told = told_approaches(fit, [])
    assert told is not None and told.where == (4,) and told.told == told.of == 34
    np.testing.assert_array_equal(told.sessions[0].samples.approach[:, 4], seen.samples.approach[:, 4])
    assert not np.delete(told.sessions[0].samples.approach, 4, axis=1).any()


def test_a_gap_that_no_torque_chooses_is_found_without_columns(seen: Session) -> None:
    session = blind(seen)
    model = identify([session]).model("kuka-kr210-r2700", {})
    found = diagnose([session], model)
    assert found.verdict == "explained"
    (gap,) = found.added
    assert gap.effect == "backlash" and gap.where == ("joint-5",)
    with_columns = identify([seen]).values()["backlash"]["gap_rad"][4]
    assert gap.parameters["gap_rad"][0][0] == pytest.approx(with_columns, rel=0.02) and with_columns > 1e-4
    assert any("read off the readings themselves, 34 of 34" in n and "backlash.side" in n for n in found.notes)
    # with all signs the other way round the readings are the same: +1 and -1 both lie in the interval
    assert gap.parameters["side"][1] == pytest.approx([1 / 1.96], rel=1e-3)
    np.testing.assert_allclose(found.model.sd["backlash"]["side"], [0, 0, 0, 0, 1 / 1.96, 0], rtol=1e-3)
    assert MISSING not in found.notes


@pytest.mark.parametrize(
    ("rotations", "share"),
    [("two", 0.0), ("normal", 1 - 2 / np.pi), ("uniform", 0.25), ("sine", 1 - 8 / np.pi**2)],
)
def test_random_rotations_are_no_flanks(rotations: str, share: float) -> None:
    """What the best signs leave of the square: (mean |z|)^2 / mean z^2 is lost, less for every distribution that is not
    two values."""
    rng = np.random.default_rng(5)
    d = list(rng.normal(0, 1e4, (400, 12)))
    carried = 2e-4 if rotations == "two" else 0.0
    m = list(rng.normal(0, 1e4, (400, 12)) * (np.arange(400) % 3 == 0)[:, None] * (carried > 0))
    z = {
        "two": rng.choice([-2e-4, 2e-4], 400),
        "normal": rng.normal(0, 2e-4, 400),
        "uniform": rng.uniform(-3e-4, 3e-4, 400),
        "sine": 3e-4 * np.sin(rng.uniform(-np.pi, np.pi, 400)),
    }[rotations]
    r = [x * a + carried * b for x, a, b in zip(z, d, m, strict=True)]
    best = min((_turned(r, m, d, g) for g in (0.0, 1e-4, 2e-4)), key=lambda f: _left(r, m, d, f))
    left = _left(r, m, d, best) / square(r)
    assert left == pytest.approx(share, abs=0.04) and (left < RIGHT) == (rotations == "two")
    if rotations == "two":
        assert best[0] == pytest.approx(2e-4, rel=1e-6)
        np.testing.assert_array_equal(best[1], np.sign(z))


@dataclass(frozen=True)
class Said:
    """What a diagnosis says, as far as a second one with approaches looks at it."""

    verdict: str
    fit: Any
    added: tuple[AddedEffect, ...] = ()
    outliers: tuple[tuple[str, int], ...] = ()
    notes: tuple[str, ...] = ("first",)


@pytest.mark.parametrize(
    ("verdict", "columns", "asks"),
    [("unexplained", False, True), ("unexplained", True, False), ("explained", False, False)],
)
def test_what_stays_unexplained_without_columns_asks_for_them(
    verdict: str, columns: bool, asks: bool, seen: Session, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever was added: a softer flank needs them as a gap does."""
    monkeypatch.setattr("stiffness.diagnosis.told_approaches.told_approaches", lambda fit, outliers: None)
    said: Any = Said(verdict, SimpleNamespace(sessions=[SimpleNamespace(session=seen if columns else blind(seen))]))
    found = with_told_approaches(said, lambda sessions, note: said, lambda text: None)
    assert found.notes == (("first", MISSING) if asks else ("first",))
