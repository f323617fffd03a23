"""A session of a plant that is ill in a known way, and the model of the healthy arm fitted to it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import numpy as np

from stiffness.diagnosis.added_effects import ModelFits
from stiffness.diagnosis.search import Search
from stiffness.effects import BASE
from stiffness.identification.fit import Fit
from stiffness.identify import identify
from stiffness.session.session import Session, load_session
from tests.plant.ailment import Truth
from tests.plant.cell_design import CELLS
from tests.plant.cells import SCENARIOS, write

ABB, UR, KUKA = CELLS


@dataclass(frozen=True)
class Sick:
    """The ill ``session``, ``fits`` of joint stiffness on it, the ``base`` fit, a ``search`` on them, and the truth."""

    session: Session
    fits: ModelFits
    base: Fit
    search: Search
    truth: tuple[Truth, ...]


@cache
def sick(scenario: str, arm: str = UR, seed: int = 3, size: float = 3.0) -> Sick:
    """Made once per run."""
    folder = Path(mkdtemp(prefix="sick"))
    case = write(SCENARIOS[scenario], folder, seed, arm, size=size, sessions=("A_healthy", "D"))
    healthy, ill = (load_session(case.paths[k]) for k in ("A_healthy", "D"))
    model = identify([healthy], [BASE.name]).model(healthy.robot_name, {})
    fits = ModelFits.of([ill], [BASE], model.values, [np.ones(len(ill), dtype=bool)])
    return Sick(ill, fits, fits.fit([]), Search(fits, (), lambda text: None), case.truth)
