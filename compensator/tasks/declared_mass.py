"""Declared mass: what sessions declare for their tools, and findings where a model counts such a mass twice."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffness.model.counted_twice import REMEDY, counted_twice
from stiffness.model.model import ComplianceModel
from stiffness.session.session import Session
from toolpaths.finding import WARNING, Finding


def declared_masses(sessions: Sequence[Session]) -> dict[str, float]:
    """kg by tool, column ``payload`` included; without tools whose sessions do not agree."""
    told: dict[str, set[float]] = {}
    for s in sessions:
        told.setdefault(s.tool.name, set()).update(np.unique(np.round(s.samples.payload + (s.tool.mass or 0.0), 6)))
    return {tool: float(masses.pop()) for tool, masses in told.items() if len(masses) == 1}


def mass_findings(model: ComplianceModel, session: Session) -> list[Finding]:
    """Warnings where a session declares a mass that the model has found by itself."""
    return [
        Finding(WARNING, model.source, text, REMEDY, kind="model")
        for tool, mass in declared_masses([session]).items()
        for text in counted_twice(model, tool, mass)
    ]
