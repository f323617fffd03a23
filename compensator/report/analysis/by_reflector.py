"""Residuals of a fit reflector by reflector."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.report.analysis.predicted import PredictedSession
from stiffness.identification import scores
from stiffness.identification.predicted_readings import PredictedReadings
from stiffness.identification.scores import Score
from stiffness.session.session import Session

Bools = npt.NDArray[np.bool_]
Judge = Callable[[Session, PredictedReadings, Bools, Bools], Score | None]

KINDS = scores.KINDS


@dataclass(frozen=True)
class ReflectorResiduals:
    """Residuals of one reflector, RMS per axis, m; ``floor``: expected of the noise alone."""

    name: str
    link: int
    count: int
    rigid: float
    fitted: float
    floor: float


def reflector_residuals(sessions: tuple[PredictedSession, ...], kind: str) -> list[ReflectorResiduals]:
    """Of a kind of reading; sessions pooled where name and link are the same; in the order of the files."""
    judge = KINDS[kind]
    found: dict[tuple[str, int], list[tuple[Score, Score]]] = {}
    for s in sessions:
        session, used = s.fit.session, s.fit.used
        for k, r in enumerate(session.reflectors):
            rows = used & (session.samples.reflector == k)
            before, after = judge(session, s.rigid, rows, used), judge(session, s.fit.predicted, rows, used)
            if before is not None and after is not None:
                found.setdefault((r.name, r.link), []).append((before, after))
    out = []
    for (name, link), pairs in found.items():
        before, after = scores.pooled([b for b, _ in pairs]), scores.pooled([a for _, a in pairs])
        if before is not None and after is not None:
            out.append(
                ReflectorResiduals(
                    name=name,
                    link=link,
                    count=after.count,
                    rigid=before.rms,
                    fitted=after.rms,
                    floor=after.noise_floor,
                )
            )
    return out
