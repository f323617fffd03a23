"""The reference: a fit that is told which effects there are and where, and finds their numbers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from stiffness.diagnosis.added_effects import Addition, ModelFits
from stiffness.diagnosis.result import Diagnosis
from stiffness.effects import BY_NAME
from stiffness.effects.effect import Site
from stiffness.errors import StiffnessError
from stiffness.identification.evaluate import shown_effects
from stiffness.identification.fit import Fit
from stiffness.model.model import ComplianceModel
from stiffness.session.session import Session
from tests.effects_report.told import Numbers, sites, told
from tests.plant.ailment import Truth
from tests.plant.cell_design import Cell


def reference(session: Session, model: ComplianceModel, truths: Sequence[Truth], cell: Cell, said: Diagnosis) -> Fit:
    """Of several beginnings, with and without the numbers that data have to ask for, the best fit."""
    effects = [e for e in shown_effects(model, session) if e.fitted_where in ("load", "position")]
    truths = [t for t in truths if t.effect not in {e.name for e in effects}]
    values = {e.name: model.values[e.name] for e in effects}
    model_fits = ModelFits.of([session], effects, values, [np.ones(len(session.samples), dtype=bool)])
    if not truths:  # the model at hand has them
        return model_fits.fit([])
    fits = [fit for additions in _beginnings(truths, cell, said) for fit in _fits(model_fits, additions)]
    if not fits:
        raise ValueError(f"no fit of {', '.join(t.effect for t in truths)} on {cell.name} comes to an end")
    return min(fits, key=_price)


def _beginnings(truths: Sequence[Truth], cell: Cell, said: Diagnosis) -> Iterator[list[Addition]]:
    parts = [told(t, cell) for t in truths]
    for k in range(max(len(p.starts) for p in parts)):
        begun = [p.exact | p.starts[min(k, len(p.starts) - 1)] for p in parts]
        yield [_addition(t, cell, numbers) for t, numbers in zip(truths, begun, strict=True)]
    if {a.effect for a in said.added} == {t.effect for t in truths}:  # what was found is one beginning more
        found = said.fit.values()
        begun = [_addition(t, cell, p.exact | p.starts[0]) for t, p in zip(truths, parts, strict=True)]
        yield [_filled(a, found[a.effect.name]) for a in begun]


def _addition(truth: Truth, cell: Cell, numbers: Numbers) -> Addition:
    effect, joints = BY_NAME[truth.effect], cell.arm.n
    values = effect.neutral(joints)
    for (name, index), value in numbers.items():
        parameter = next(p for p in effect.parameters if p.name == name)
        values[name][index] = np.clip(value, parameter.low, parameter.high)
    return Addition(effect, sites(effect, truth.where, joints), frozenset(), values)


def _filled(a: Addition, found: dict[str, np.ndarray]) -> Addition:
    """Numbers of the addition's sites from a fit."""
    values = {k: v.copy() for k, v in a.values.items()}
    for p in a.effect.parameters:
        for site in (s for s in a.sites if s.kind == p.site):
            if site.index is None or isinstance(p.size, int):
                values[p.name] = np.array(found[p.name])
            elif site.index < len(values[p.name]):
                values[p.name][site.index] = found[p.name][site.index]
    return replace(a, values=values)


def _fits(model_fits: ModelFits, additions: Sequence[Addition]) -> Iterator[Fit]:
    choices = [(frozenset[Site](), frozenset(a.sites)) if _has_extras(a) else (frozenset[Site](),) for a in additions]
    for extras in product(*choices):
        chosen = [_plain(replace(a, extras=e)) for a, e in zip(additions, extras, strict=True)]
        try:
            yield model_fits.fit(chosen)
        except (StiffnessError, np.linalg.LinAlgError):
            continue


def _has_extras(a: Addition) -> bool:
    return any(p.extra for p in a.effect.parameters)


def _plain(a: Addition) -> Addition:
    """Without extras their numbers are neutral, or where they belong when nothing is known."""
    if a.extras:
        return a
    values = dict(a.values)
    for p in (p for p in a.effect.parameters if p.extra):
        values[p.name] = np.full_like(values[p.name], p.start if p.neutral is None else p.neutral)
    return replace(a, values=values)


def _price(fit: Fit) -> float:
    """Chi-square, and what the numbers cost."""
    return fit.solution.chi2 + len(fit.unknowns) * float(np.log(fit.solution.count))
