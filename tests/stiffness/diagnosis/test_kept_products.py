"""What a search keeps in memory: products of all columns only as long as terms are chosen by them."""

from __future__ import annotations

from weakref import WeakSet

import pytest

from stiffness.diagnosis import linearisation
from stiffness.diagnosis.added_effects import ModelFits
from stiffness.diagnosis.alternatives import with_alternatives
from stiffness.diagnosis.linear_fit import NormalEquations
from stiffness.diagnosis.search import Search
from stiffness.identification.fit import Fit
from stiffness.identification.unknowns import numbers_of
from tests.stiffness.diagnosis.sick import sick
from tests.stiffness.diagnosis.test_search import addition


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
            assert {linear.columns[k].number for k in t.columns} <= set(numbers_of(t.effect, t.site, 6, True))
