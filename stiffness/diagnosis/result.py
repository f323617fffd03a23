"""Diagnosis: the outcome: a model is adequate, lacks an effect, has moved, or leaves structure that none explains."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import numpy.typing as npt

from stiffness.diagnosis.attribution import ResidualSource
from stiffness.identification.fit import CLEAR, Fit
from stiffness.identification.scores import Score
from stiffness.model.model import ComplianceModel
from stiffness.planning.next_setups import NextSetup

Floats = npt.NDArray[np.float64]
Verdict = Literal["unexplained", "explained", "parameters-changed", "insufficient-data", "adequate"]


@dataclass(frozen=True)
class AddedEffect:
    """An effect that the model lacked.

    Attributes:
        where: its places. sites: the places one by one, in the order of the numbers.
        parameters: name -> (values, standard deviations, unit) at its sites.
        explains: fraction of the chi-square above the noise that it takes away.
        confused_with: effects that these readings do not tell from it.
    """

    effect: str
    where: tuple[str, ...]
    parameters: Mapping[str, tuple[Floats, Floats, str]]
    explains: float
    confused_with: tuple[str, ...]
    sites: tuple[tuple[str, ...], ...] = ()


@dataclass(frozen=True)
class RemovedEffect:
    """An effect of the model, or some of its places, that the readings would show and do not need, and ``why``."""

    effect: str
    where: tuple[str, ...]
    why: str


@dataclass(frozen=True)
class MovedParameter:
    """A number of the model that has moved since the model was made, with its standard deviation, and the effects that
    these readings do not tell from that."""

    effect: str
    where: tuple[str, ...]
    parameter: str
    before: float
    after: float
    sd: float
    unit: str
    confused_with: tuple[str, ...] = ()


@dataclass(frozen=True)
class Candidate:
    """The cross-validated residual of the model with one effect more: RMS per axis, m, weighted by the noise."""

    effect: str
    where: tuple[str, ...]
    heldout_rms: float
    confused_with: tuple[str, ...]


@dataclass(frozen=True)
class HeldOutScores:
    """Residuals on held-out set-ups or stretches, of one kind of evidence: of the model as it was, with its own
    parameters ``refitted`` (what it leaves above the noise is structure), and refined."""

    before: Score
    refitted: Score
    after: Score


@dataclass(frozen=True, repr=False)
class Diagnosis:
    """The outcome.

    Attributes:
        scores: on held-out set-ups, of ``displacement`` and ``absolute``, None where a session cannot tell.
        candidates: every effect that could be tried, best first.
        residual_sources: where what is left sits, largest first; before anything was added where nothing is left.
        outliers: (session, line of samples.csv).
        notes: in words, for the report.
        model: refined.
        base, fit: the model at hand fitted anew, and with what was added, on the readings that took part; ``last``:
            the latter on all readings.
        held: set-ups that took no part, per session. next_traces: what to trace next, in words.
        base_heldout_rms: of the model at hand, as ``Candidate.heldout_rms``.
    """

    verdict: Verdict
    added: tuple[AddedEffect, ...]
    removed: tuple[RemovedEffect, ...]
    changed: tuple[MovedParameter, ...]
    scores: Mapping[str, HeldOutScores | None]
    candidates: tuple[Candidate, ...]
    residual_sources: tuple[ResidualSource, ...]
    next_setups: tuple[NextSetup, ...]
    outliers: tuple[tuple[str, int], ...]
    notes: tuple[str, ...]
    model: ComplianceModel
    base: Fit
    fit: Fit
    last: Fit
    held: tuple[tuple[int, ...], ...] = field(default=())
    base_heldout_rms: float | None = None
    next_traces: tuple[str, ...] = ()

    @property
    def known_better(self) -> tuple[HeldOutScores, ...]:
        """Scores of an adequate model whose numbers are no more wrong than they say, and that readings know better."""
        every = self.scores.values() if self.verdict == "adequate" else ()
        return tuple(s for s in every if s is not None and s.before.rms > CLEAR * s.refitted.rms)

    def __repr__(self) -> str:
        return f"Diagnosis({self.verdict}, added {', '.join(a.effect for a in self.added) or 'nothing'})"
