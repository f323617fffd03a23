"""Seconds to diagnose a session of 2,000 readings, against one fit of the model at hand, and where the time goes.

Sessions are made here from the product's own statics with noise: what a diagnosis finds is a matter of the tests.
"""

from __future__ import annotations

import cProfile
import pstats
import statistics
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.identify import session
from benchmarks.table import Row
from benchmarks.timing import interleaved, on_cores
from stiffness.diagnosis.diagnose import diagnose
from stiffness.effects import BY_NAME
from stiffness.identify import identify
from stiffness.model.model import ComplianceModel
from stiffness.session.session import Session

READINGS = 2_000
ROUNDS = 3
GOAL = "under 60 s"
#: Where the time goes: a name, and the function whose whole time is counted.
PARTS = {
    "equilibria of the arm": "equilibrium_kernel.py:run",
    "positions of reflectors": "readings.py:positions",
    "whitening": "weighting.py:blocks",
    "slopes by every number of the catalogue": "sensitivities.py:of",
    "selection in the linear model": "selection.py:forward",
    "where the rest sits": "attribution.py:residual_sources",
}


def run(readings: int = READINGS, rounds: int = ROUNDS) -> Iterator[Row]:
    """A base that yields, and nothing wrong."""
    group = f"diagnose (abb-irb6600-175-255; {readings:,} readings; two cores)"
    base = {name: np.array(v) for name, v in BY_NAME["base-compliance"].neutral(6).items()}
    base["angular_rad_per_nm"] = np.array([6e-8, 4e-8, 2e-8])
    with tempfile.TemporaryDirectory(prefix="bench-") as name:
        healthy = session(Path(name) / "healthy", readings)
        ill = session(Path(name) / "ill", readings, 2, ill={"base-compliance": base})
    model = identify([healthy], ["joint-stiffness"]).model(healthy.robot_name, {})
    cases = {"nothing wrong": healthy, "a base that yields": ill}
    tasks = {what: on_cores(2, lambda g=given: diagnose([g], model)) for what, given in cases.items()}  # type: ignore[misc]
    tasks["one fit of joint stiffness"] = on_cores(2, lambda: identify([healthy], ["joint-stiffness"]))
    times = interleaved(tasks, rounds)
    one = statistics.median(times["one fit of joint stiffness"])
    for what in cases:
        seconds = statistics.median(times[what])
        yield Row(group, what, seconds, "s", GOAL)
        yield Row(group, f"{what}, against one fit of joint stiffness", seconds / one, "x", "")
    yield from _shares(group, ill, model)


def _shares(group: str, given: Session, model: ComplianceModel) -> Iterator[Row]:
    """Shares of the whole time; they overlap where one part calls another."""
    profile = cProfile.Profile()
    profile.runcall(diagnose, [given], model)
    found: dict[tuple[str, int, str], tuple[int, int, float, float, object]] = pstats.Stats(profile).stats  # type: ignore[attr-defined]
    whole = sum(own for _, _, own, _, _ in found.values())
    times: dict[str, float] = {}
    for (file, _, name), (_, _, _, cumulative, _) in found.items():
        key = f"{Path(file).name}:{name}"
        times[key] = max(times.get(key, 0.0), cumulative)
    for what, function in PARTS.items():
        yield Row(group, f"a base that yields: {what}", 100 * times[function] / whole, "%", "")
