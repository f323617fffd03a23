"""A small session with everything in it: two tracker stations, rough reflectors, a probe, ropes, a payload, repeats."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from stiffness.effects import BASE, BY_NAME
from stiffness.effects.effect import Effect, Numbers
from stiffness.identification.observations import SessionObservations
from stiffness.identification.session_data import SessionData
from stiffness.identification.unknowns import Unknowns, start_values, unknowns
from stiffness.identification.weighting import Weighting
from stiffness.session.session import Session, load_session
from tests.plant import Arm, lab
from tests.plant.lab_design import random_setups
from tests.stiffness import session_desk

Floats = npt.NDArray[np.float64]
TARGETS = (
    lab.Target("tcp", 6, session_desk.TOOL.xyz),
    lab.Target("elbow", 3, (0.2, 0.06, 0.05)),
    lab.Target("rough", 6, (0.08, 0.04, 0.02), exact=False),
    lab.Target("probe-a", 5, (0.0, 0.1, 0.05), exact=False, group="probe"),
    lab.Target("probe-b", 5, (0.1, 0.1, 0.05), exact=False, group="probe"),
    lab.Target("probe-c", 5, (0.0, 0.1, 0.15), exact=False, group="probe"),
)
STIFFNESS = np.array([5e4, 5e4, 3e4, 1e4, 1e4, 8e3])


def session(folder: Path, seed: int = 1, setups: int = 5, targets: Sequence[lab.Target] = TARGETS) -> Session:
    """Of the UR10 with a gap, read back from its files."""
    arm = Arm.load(session_desk.ROBOT, tool=session_desk.TOOL)
    plan = random_setups(arm, setups, seed, force=60.0, pulls=(None, "elbow"), payload=3.0, levels=(0.5, 1.0))
    form = lab.Form(
        registered=False, blocks=2, repeats=2, rough=0.002, frame="tool", step=True, sensed="state", seconds=2.0,
        climate=lambda t: 20 + 3 * np.sin(t / 500), reference_temperature=20.0,
    )  # fmt: skip
    noise = lab.Noise(tracker=2e-5, tracker_angle=2e-4, force=0.3, torque=0.1)
    notes = lab.measure(session_desk.ur10(), plan, targets, noise=noise, form=form, seed=seed)
    return load_session(notes.write(folder, "ur10"))


def values(*names: str) -> tuple[tuple[Effect, ...], dict[str, dict[str, Floats]]]:
    """Effects in the order of the catalogue, joint stiffness among them, and where a fit of them starts."""
    wanted = {BASE.name, *names}
    effects = tuple(e for e in BY_NAME.values() if e.name in wanted)
    numbers = start_values(effects, 6)
    numbers[BASE.name]["k_nm_per_rad"] = STIFFNESS.copy()
    return effects, numbers


def observed(
    of: Session, layout: Unknowns, fixed: Mapping[str, Numbers], offset: float = 0.0
) -> SessionObservations:
    return SessionObservations.of(SessionData.of(of), Weighting(of, offset), layout, fixed)


def free(*names: str) -> tuple[Unknowns, dict[str, dict[str, Floats]]]:
    """All numbers of joint stiffness and of other effects, and where they start."""
    effects, numbers = values(*names)
    return unknowns(effects, 6, extras=lambda effect, site: True), numbers
