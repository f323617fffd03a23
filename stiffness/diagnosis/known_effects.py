"""Known effects: what the model at hand has beside its springs and its geometry, and what a search makes of it.

A search may find them again, elsewhere or with other numbers, or explain the readings without them. Then an effect that
these readings could not show stays as the model has it, and one that they would have shown is removed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import stats

from stiffness.diagnosis.added_effects import Addition, ModelFits, as_addition
from stiffness.diagnosis.linearisation import can_show
from stiffness.diagnosis.result import RemovedEffect
from stiffness.effects.effect import Effect
from stiffness.identification.fit import Fit
from stiffness.identification.unknowns import can_be_richer
from stiffness.model.model import ComplianceModel
from stiffness.session.session import Session, count_setups

# studied in tests/stiffness/test_one_session.py
SHOWN = 0.01  # chance that noise alone looks like what an effect of the model does to the readings


@dataclass(frozen=True, repr=False, eq=False)
class KnownEffects:
    """``base``: effects that all others are added to; ``given``: those of them that the sessions cannot show, by name;
    ``known``: effects of the model that a search may drop, replace or re-shape, with its values."""

    base: tuple[Effect, ...]
    given: tuple[str, ...]
    known: tuple[Addition, ...]

    @classmethod
    def of(cls, model: ComplianceModel, effects: Sequence[Effect], sessions: Sequence[Session]) -> KnownEffects:
        """Of ``effects`` of a model, those that these sessions show."""
        joints = sessions[0].robot.n
        ground = [e for e in effects if e.fitted_unasked]
        every = {e.name: as_addition(e, model.values[e.name], joints) for e in effects if e not in ground}
        given = [e for e in effects if e not in ground and not _can_show(e, every[e.name], sessions)]
        return cls(
            base=tuple(e for e in effects if e in ground or e in given),
            given=tuple(e.name for e in given),
            known=tuple(a for a in every.values() if a is not None and a.effect not in given),
        )


def _can_show(effect: Effect, own: Addition | None, sessions: Sequence[Session]) -> bool:
    """Whether sessions can show an effect as a model has it: a table needs as many set-ups as it has knots."""
    tabled = own is not None and effect.as_table is not None and bool(own.extras)
    return can_show(effect, sessions) and (not tabled or can_be_richer(effect, count_setups(sessions)))


def with_known(
    fits: ModelFits, fit: Fit, additions: list[Addition], known: Sequence[Addition]
) -> tuple[Fit, list[Addition], list[RemovedEffect]]:
    """With those known effects that the search did not find and these readings could not show either, as they were; and
    those that are removed."""
    found = {a.effect.name: a for a in additions}
    removed = [_elsewhere(k, found[k.effect.name]) for k in known if k.effect.name in found]
    out = [r for r in removed if r is not None]
    for k in (k for k in known if k.effect.name not in found):
        trial = fits.fit([*additions, replace(k, held=True)], fit)
        if _seen(fit, trial) < float(stats.chi2.isf(SHOWN, max(len(k.numbers(fits.joints)), 1))):
            fit, additions = trial, [*additions, replace(k, held=True)]
        else:
            out.append(RemovedEffect(k.effect.name, k.where, _why(fit, trial, additions)))
    return fit, additions, out


def _elsewhere(known: Addition, found: Addition) -> RemovedEffect | None:
    """Places of a known effect where the search did not find it again."""
    where = tuple(w for w in known.where if w not in found.where)
    why = f"with {found.effect.name} in {' '.join(found.where)} the readings need none here"
    return RemovedEffect(known.effect.name, where, why) if where else None


def _seen(without: Fit, held: Fit) -> float:
    """Chi-square of what an effect, held at its values, does to the readings that no other number makes up for."""
    pairs = zip(without.sessions, held.sessions, strict=True)
    blocks = ((a, b) for x, y in pairs for a, b in zip(x.blocks(), y.blocks(), strict=True))
    return sum(float(np.sum((a.residual - b.residual) ** 2)) for a, b in blocks)


def _why(fit: Fit, held: Fit, additions: Sequence[Addition]) -> str:
    others = ", ".join(a.effect.name for a in additions)
    beside = f"with {others} in the model " if others else ""
    more = held.solution.chi2 - fit.solution.chi2
    return f"{beside}the readings need none: as the model has it, chi-square changes by {more:+.0f}"
