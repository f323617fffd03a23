"""What a search keeps in memory: products while terms are chosen by them, derivatives and blocks by the piece."""

from __future__ import annotations

from collections.abc import Mapping
from weakref import WeakSet, ref

import numpy as np
import numpy.typing as npt
import pytest

from stiffness.diagnosis import linearisation
from stiffness.diagnosis.added_effects import ModelFits
from stiffness.diagnosis.alternatives import with_alternatives
from stiffness.diagnosis.linear_fit import NormalEquations
from stiffness.diagnosis.search import Search
from stiffness.diagnosis.sensitivities import Sensitivities
from stiffness.effects.effect import Numbers
from stiffness.identification.fit import Fit
from stiffness.identification.reading_slopes import ReadingSlopes
from stiffness.identification.session_fit import SessionFit
from stiffness.identification.unknowns import numbers_of
from stiffness.numerics.least_squares import solve
from stiffness.numerics.whitened import Whitened, whitened
from tests.stiffness.diagnosis.sick import sick
from tests.stiffness.diagnosis.test_search import addition

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]


class Counted(NormalEquations):
    """Normal equations that can be counted; ``most``: of them at once."""

    alive: WeakSet[Counted]
    most: int

    def __init__(self, *args: object, **kwargs: object) -> None:
        super().__init__(*args, **kwargs)  # type: ignore[arg-type]
        Counted.alive.add(self)
        Counted.most = max(Counted.most, len(Counted.alive))


def test_no_products_stand_while_a_fit_is_made(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where tables are candidates they take a hundred MB and more, and so does a fit of them."""
    Counted.alive, Counted.most = WeakSet(), 0
    monkeypatch.setattr(linearisation, "NormalEquations", Counted)
    during = list[int]()
    fit_of = ModelFits.fit

    def fit(self: ModelFits, *args: object, **kwargs: object) -> Fit:
        during.append(len(Counted.alive))
        return fit_of(self, *args, **kwargs)  # type: ignore[arg-type]

    monkeypatch.setattr(ModelFits, "fit", fit)
    ill = sick("base-compliance")
    search = Search(ill.fits, (), lambda text: None)
    begun = search.linearisation.at(ill.base, [])
    beginnings, start = search.beginnings(begun), begun.expansion
    del begun
    _, additions = search.run(start, beginnings)
    in_search = len(during)
    wrong = [addition("payload", "tool")]
    _, better, _ = with_alternatives(search, ill.fits.fit(wrong, ill.base), wrong, ill.base)
    assert [a.effect.name for a in additions] == [a.effect.name for a in better] == ["base-compliance"]
    assert in_search > 1 and len(during) > in_search + 3
    assert set(during) == {0}
    assert Counted.most == 1


def test_every_column_is_one_of_a_term() -> None:
    """Products of the numbers of what has been added would only take room; what stays has the gain that it had."""
    ill = sick("base-compliance")
    before = ill.search.linearisation.at(ill.base, [])
    chosen = next(t for t in before.selector.terms if t.effect.name == "base-compliance")
    fit, additions = ill.search.run(before, [before.selector.together([chosen])])
    after = ill.search.linearisation.at(fit, additions)
    assert len(after.columns) < len(before.columns)
    for linear in (before, after):
        assert {k for t in linear.selector.terms for k in t.columns} == set(range(len(linear.columns)))
        assert len(linear.selector.equations.reduced.slope) == len(linear.columns)
        for t in linear.selector.terms:
            assert {linear.columns[k].number.effect for k in t.columns} == {t.effect.name}
            assert {linear.columns[k].number for k in t.columns} <= set(numbers_of(t.effect, t.site, 6, t.extras))


def test_derivatives_are_worked_out_for_a_piece_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each by the numbers of its run alone; the products are those of all at once."""
    ill = sick("base-compliance")
    whole = ill.search.linearisation.at(ill.base, [])
    asked = list[tuple[Index, int]]()
    made = Sensitivities.of

    def of(
        self: Sensitivities, fit: SessionFit, values: Mapping[str, Numbers], rows: Index, wanted: Index
    ) -> ReadingSlopes:
        out = made(self, fit, values, rows, wanted)
        asked.append((rows, out.dense.shape[2]))
        assert len(out.dense) == len(rows) and out.dense.shape[2] <= len(wanted)
        return out

    monkeypatch.setattr(Sensitivities, "of", of)
    monkeypatch.setattr(linearisation, "PIECE", 7)
    pieces = ill.search.linearisation.at(ill.base, [])
    setup = ill.session.samples.setup
    assert max(len(np.unique(setup[rows])) for rows, _ in asked) <= 7
    runs = len({c.run for c in whole.columns})
    assert np.array_equal(np.bincount(np.concatenate([rows for rows, _ in asked])), np.full(len(setup), runs))
    some, every = sum(width * len(rows) for rows, width in asked), runs * len(setup) * max(w for _, w in asked)
    assert 0 < some < 0.7 * every
    a, b = whole.selector.equations.reduced, pieces.selector.equations.reduced
    scale = np.sqrt(np.where(a.squares > 0, a.squares, 1.0))  # some numbers move nothing here
    unit = np.outer(scale, scale)
    assert b.squares == pytest.approx(a.squares, rel=1e-9)
    assert b.curvature / unit == pytest.approx(a.curvature / unit, abs=1e-9)
    assert b.slope / scale == pytest.approx(a.slope / scale, rel=1e-7, abs=1e-7)


def test_a_fit_has_the_blocks_of_one_evaluation() -> None:
    """An exponential through points: when a vector is evaluated, nothing of the one before stands any more."""
    x = np.linspace(-1, 1, 40)
    made, before = list[ref[Whitened]](), list[int]()

    def blocks(vector: Floats, state: None) -> tuple[list[Whitened], None]:
        before.append(sum(r() is not None for r in made))
        value = np.exp(vector[0] * x) + vector[1]
        jacobian = np.column_stack([x * np.exp(vector[0] * x), np.ones(40)])
        out = [whitened(np.arange(40), np.exp(0.7 * x) + 3.0 - value, jacobian, 1e-4 * np.eye(40))]
        made.extend(ref(b) for b in out)
        return out, None

    free, loose = np.full(2, np.inf), np.full(2, 1e3)
    found, _ = solve(blocks, np.zeros(2), None, prior=np.zeros(2), prior_sd=loose, low=-free, high=free)
    assert found.vector == pytest.approx([0.7, 3.0], abs=1e-6)
    assert len(before) > 2 and set(before) == {0}
