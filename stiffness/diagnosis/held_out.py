"""Held-out set-ups: they take no part in a diagnosis, and score the model before and after it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from stiffness.diagnosis.result import HeldOutScores
from stiffness.identification import scores
from stiffness.identification.evaluate import predicted_by
from stiffness.identification.fit import Fit
from stiffness.identification.scores import KINDS, Score
from stiffness.model.model import ComplianceModel
from stiffness.session.session import Session

Bools = npt.NDArray[np.bool_]

FEWEST = 8  # set-ups; with fewer, leaving some out leaves nothing
EVERY = 5  # set-ups, one of which takes part in nothing


def held_out(session: Session) -> Bools:
    """(N,) readings of every fifth set-up of every block, in the order of the file; of a trace every fifth stretch of
    the path, in all runs, or every fifth run where there are many."""
    s = session.samples
    out = np.zeros(len(s), dtype=bool)
    if session.path is not None:
        part = session.path.run if session.path.whole_runs else session.path.stretch
        parts = np.unique(part)
        # not the middle one of five: a path there and back would have the same places held out both ways
        return np.isin(part, parts[1::EVERY]) if len(parts) >= EVERY else out
    for block in np.unique(s.block):
        rows = np.flatnonzero(s.block == block)
        setups = list(dict.fromkeys(s.setup[rows].tolist()))
        if len(setups) >= FEWEST:
            out[rows] = np.isin(s.setup[rows], setups[EVERY // 2 :: EVERY])
    return out


def held_out_scores(
    model: ComplianceModel, base: Fit, refined: Fit | None, sound: Sequence[Bools]
) -> dict[str, HeldOutScores | None]:
    """Scores of the model as it was, refitted, and refined, on set-ups that took no part.

    Args:
        refined: None: the model stays as it was.
        sound: per session (N,), readings that are no outliers.
    """
    every: dict[str, list[tuple[Score | None, ...]]] = {kind: [] for kind in KINDS}
    for k, (old, use) in enumerate(zip(base.sessions, sound, strict=True)):
        new = None if refined is None else refined.sessions[k]
        held = held_out(old.session)
        rows = held if held.any() else np.ones_like(held)
        before = predicted_by(model, old.session, use & (~held if held.any() else True)).predicted
        for kind, judge in KINDS.items():
            seen = (before, old.predicted, before if new is None else new.predicted)
            every[kind].append(tuple(judge(old.session, p, rows, use) for p in seen))
            old, new = old.further(), None if new is None else new.further()
    return {kind: _pooled(found) for kind, found in every.items()}


def _pooled(found: Sequence[tuple[Score | None, ...]]) -> HeldOutScores | None:
    before, refitted, after = (scores.pooled(column) for column in zip(*found, strict=True))
    return None if before is None or refitted is None or after is None else HeldOutScores(before, refitted, after)
