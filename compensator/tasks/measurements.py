"""Measurements: sessions of set-ups and traces of programs that ran, told apart by the schema of their files."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from compensator.errors import TraceError
from compensator.trace.trace import load_trace
from compensator.trace.trace_file import SCHEMA
from stiffness.model.model import ComplianceModel
from stiffness.session.session import Session, load_session


def load_measurement(path: Path) -> Session:
    """A session, or a trace as a session of path readings.

    Raises:
        StiffnessError, CompensatorError: refused; names file, row, column, value and what to do.
    """
    return load_trace(path) if _schema(path) == SCHEMA else load_session(path)


def load_measurements(paths: Sequence[Path]) -> list[Session]:
    """Several; what the cell of a trace does not tell of gravity is as in the sessions beside it."""
    loaded = [load_measurement(path) for path in paths]
    told = next((s for s in loaded if s.path is None), None)
    if told is None:
        return loaded
    return [_as_told(s, told.gravity, told.reference_temperature) for s in loaded]


def in_terms_of(session: Session, model: ComplianceModel) -> Session:
    """A trace with the gravity and the reference temperature of a model, where its cell does not give them."""
    return _as_told(session, model.gravity, model.reference_temperature)


def _as_told(session: Session, gravity: str, temperature: float | None) -> Session:
    if session.path is None:
        return session
    kept = session.gravity if session.path.gravity_told else gravity
    if kept == "uncompensated" and session.robot.mass is None:
        raise TraceError(
            f"{session.source}: gravity = 'uncompensated' needs the masses of the links: {session.robot.mass_problem}; "
            "take a robot file with masses, or gravity = \"calibrated-out\" in the cell if the controller knows the sag"
        )
    return replace(session, gravity=kept, reference_temperature=temperature)


def _schema(path: Path) -> object:
    """What a file says it is; None where it cannot be read, which its reader then tells."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8-sig")).get("schema")
    except (OSError, ValueError):
        return None
