"""Diagnosis: what measured data say of a model: adequate, lacking an effect, moved, or more than anyone can tell."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import numpy.typing as npt

from stiffness.diagnosis.attribution import Share
from stiffness.identification.fit import Fit
from stiffness.identification.scores import Score
from stiffness.model.model import ComplianceModel
from stiffness.planning.next_setups import NextSetup

Floats = npt.NDArray[np.float64]
Verdict = Literal["unexplained", "explained", "parameters-changed", "insufficient-data", "adequate"]


@dataclass(frozen=True)
class Added:
    """An effect that the model lacked: ``where`` it is, and ``parameters`` name -> (values, sd, unit) of its sites.

    ``sites``: the places one by one, in the order of the numbers.

    ``explains``: share of what was above the noise that leaves with it; ``confused_with``: effects that these readings
    do not tell from it.
    """

    effect: str
    where: tuple[str, ...]
    parameters: Mapping[str, tuple[Floats, Floats, str]]
    explains: float
    confused_with: tuple[str, ...]
    sites: tuple[tuple[str, ...], ...] = ()


@dataclass(frozen=True)
class Changed:
    """A number of the model that has moved since the model was made."""

    effect: str
    where: tuple[str, ...]
    parameter: str
    before: float
    after: float
    sd: float
    unit: str


@dataclass(frozen=True)
class Candidate:
    """How well the model with one effect more predicts set-ups left out: RMS per axis, m, weighted by the noise."""

    effect: str
    where: tuple[str, ...]
    heldout_rms: float
    confused_with: tuple[str, ...]


@dataclass(frozen=True)
class Line:
    """Before and after on readings that took no part, for one kind of evidence; scores in m.

    ``refitted``: the model's own parameters fitted anew, nothing added: what is between it and the noise is structure.
    """

    before: Score
    refitted: Score
    after: Score


@dataclass(frozen=True, repr=False)
class Diagnosis:
    """The outcome.

    Attributes:
        lines: ``displacement`` and ``absolute``, None where a session has no such evidence.
        candidates: every effect that could be tried, best first.
        points_at: where what is left sits, largest first; before anything was added where nothing is left.
        outliers: (session, line of samples.csv).
        notes: in words, for the report.
        model: refined.
        base, fit: the model at hand fitted anew, and with what was added, on the readings that took part.
        held: set-ups that took no part, per session.
        base_heldout_rms: of the model at hand, as ``Candidate.heldout_rms``.
    """

    verdict: Verdict
    added: tuple[Added, ...]
    changed: tuple[Changed, ...]
    lines: Mapping[str, Line | None]
    candidates: tuple[Candidate, ...]
    points_at: tuple[Share, ...]
    next_setups: tuple[NextSetup, ...]
    outliers: tuple[tuple[str, int], ...]
    notes: tuple[str, ...]
    model: ComplianceModel
    base: Fit
    fit: Fit
    held: tuple[tuple[int, ...], ...] = field(default=())
    base_heldout_rms: float | None = None

    def __repr__(self) -> str:
        return f"Diagnosis({self.verdict}, added {', '.join(a.effect for a in self.added) or 'nothing'})"
