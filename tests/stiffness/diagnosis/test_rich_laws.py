"""Laws as rich as makers and literature have them, fitted to a plant that has others: the noise is reached."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
import pytest

from stiffness.diagnosis.added_effects import Addition, ModelFits, at_values_of
from stiffness.effects import BASE, BY_NAME
from stiffness.identification.fit import Fit
from stiffness.identify import identify
from stiffness.session.session import load_session
from tests.plant import ailments_joint as joint
from tests.plant.ailment import Ailment
from tests.plant.cell_design import CELLS
from tests.plant.cells import Scenario, write

ABB, UR, KUKA = CELLS
TORQUES = np.array([500.0, 450.0, 350.0, 70.0, 25.0, 10.0])  # N*m, typical of the joints of the ABB


@cache
def fits(arm: str, ailments: tuple[Ailment, ...], size: float) -> ModelFits:
    """Of joint stiffness of the healthy cell to readings of the ill one."""
    folder = Path(mkdtemp(prefix="laws"))
    paths = write(Scenario("ill", ailments), folder, 3, arm, size=size, sessions=("A_healthy", "D")).paths
    healthy, ill = (load_session(paths[k]) for k in ("A_healthy", "D"))
    model = identify([healthy], [BASE.name]).model(healthy.robot_name, {})
    return ModelFits.of([ill], [BASE], model.values, [np.ones(len(ill), dtype=bool)])


def simple(on: ModelFits, name: str, joints: tuple[int, ...], **begun: float | np.ndarray) -> tuple[Fit, Addition]:
    """The law without extras."""
    effect = BY_NAME[name]
    values = effect.neutral(6) | {k: np.zeros(6) + v for k, v in begun.items()}
    sites = tuple(s for s in effect.sites(6) if s.index is not None and s.index + 1 in joints)
    values = {k: np.where(np.isin(np.arange(6) + 1, joints), v, effect.neutral(6)[k]) for k, v in values.items()}
    addition = Addition(effect, sites, frozenset(), values)
    fit = on.fit([addition])
    return fit, at_values_of(fit, [addition])[0]


def rich(on: ModelFits, found: Addition) -> Fit:
    """The law with its extras, begun where the simple one ended and where the effect says."""
    begun = (found.values, *found.effect.restarts(found.values))
    every = [on.fit([replace(found, extras=frozenset(found.sites), values=values)]) for values in begun]
    return min(every, key=lambda f: f.solution.chi2)


def misfit(fit: Fit) -> float:
    """Residual over noise."""
    return float(np.sqrt(fit.solution.chi2 / fit.solution.freedom))


@pytest.mark.parametrize(("arm", "knees"), [(ABB, (0.25, 0.6)), (KUKA, (0.3, 0.45))], ids=["2.4", "1.5"])
def test_three_sharp_pieces_in_all_joints(arm: str, knees: tuple[float, float]) -> None:
    on = fits(arm, tuple(joint.hardening(k, knees) for k in range(1, 7)), 10.0)
    one, found = simple(on, "joint-hardening", (1, 2, 3, 4, 5, 6), windup_rad=3e-4, knee_nm=TORQUES)
    both = rich(on, found)
    assert misfit(one) > 1.1 and misfit(both) < 1.035
    values = both.values()["joint-hardening"]
    assert np.all(values["sharpness"] > 0.8)
    assert values["knee_ratio"] == pytest.approx(np.full(6, knees[1] / knees[0]), rel=0.15)


def test_hysteresis_of_several_bearings_in_all_joints() -> None:
    on = fits(ABB, (joint.hysteresis(),), 8.0)
    one, found = simple(on, "joint-friction", (1, 2, 3, 4, 5, 6), friction_nm=TORQUES / 3, held=0.6)
    assert misfit(one) > 1.2 and misfit(rich(on, found)) < 1.03


def test_three_waves_a_turn_in_three_joints() -> None:
    on = fits(UR, (joint.waves((1, 2, 4), 3),), 6.0)
    one, found = simple(on, "posture-stiffness", (1, 2, 4), softer=0.1)
    both = rich(on, found)
    assert misfit(one) > 2 and misfit(both) < 1.03
    values = both.values()["posture-stiffness"]
    size = np.hypot(values["cos3"], values["sin3"])[[0, 1, 3]]
    assert size == pytest.approx(np.full(3, size.mean()), rel=0.1)  # the plant's waves are of one height
