"""Damaged files of devices: read, or refused in words that name the file; never a traceback."""

from __future__ import annotations

import numpy as np
import pytest

from compensator.devices.completion import completed, nominal_points
from compensator.devices.order import TraceOrder, refuse_incomplete
from compensator.devices.readings import BALLBAR, POSITIONS, DeviceFile
from compensator.devices.samples import samples_of
from compensator.devices.selection import selected
from compensator.devices.table import DEVICES
from compensator.errors import CompensatorError
from tests.compensator.devices.device_samples import BAR, NOMINALS, SA_BARE, SAMPLES

TEXTS = {**SAMPLES, "bare": SA_BARE, "bar": BAR}
NOISE = "0123456789.,;-+eE \n\tXYZnan<>/=\"'µ\x00"
ROUNDS = 150


def damaged(text: str, rng: np.random.Generator) -> str:
    """Cut off, a character or a line lost, doubled or replaced; several of it."""
    for _ in range(int(rng.integers(1, 4))):
        at, length = int(rng.integers(len(text) + 1)), int(rng.integers(1, 30))
        lines = text.splitlines(keepends=True)
        k = int(rng.integers(len(lines))) if lines else 0
        text = (
            text[:at],
            text[:at] + text[at + length :],
            text[:at] + NOISE[int(rng.integers(len(NOISE)))] + text[at + 1 :],
            "".join(lines[:k] + lines[k + 1 :]),
            "".join(lines[: k + 1] + lines[k:]),
        )[int(rng.integers(5))]
    return text


def through(file: DeviceFile, name: str) -> None:
    """The whole way from a text to samples; numbers that come out are finite."""
    given = next(d for d in DEVICES if d.name == name).read(file)
    frame = None if given.kind == BALLBAR else "base" if given.kind == POSITIONS else "workobject"
    bar = {"center": (0.0, 0.0, 1.0), "radius": 150.0} if given.kind == BALLBAR else {}
    order = TraceOrder(frame=frame, noise=0.01, units="mm" if given.to_mm is None else None, **bar)
    if given.kind == POSITIONS and not (np.isfinite(given.time).all() or np.isfinite(given.index).all()):
        order = TraceOrder(frame=frame, noise=0.01, units=order.units, index=f"0:{len(given) - 1}")
    chosen = selected(given, None, None)
    to_mm = refuse_incomplete(chosen, order)
    whole = completed(chosen, nominal_points(DeviceFile("n", NOMINALS)), to_mm)
    made = samples_of(whole, order, to_mm, None)
    assert all(np.isfinite(values).all() for values in made.columns.values())
    assert made.csv().count("\n") == len(made) + 1


@pytest.mark.parametrize("sample", TEXTS)
def test_damaged_files(sample: str) -> None:
    name = {"bare": "spatial-analyzer", "bar": "csv"}.get(sample, sample)
    rng = np.random.default_rng(sorted(TEXTS).index(sample))
    kept = 0
    for _ in range(ROUNDS):
        file = DeviceFile("file.txt", damaged(TEXTS[sample], rng))
        try:
            through(file, name)
            kept += 1
        except CompensatorError as e:
            assert str(e).startswith(("file.txt", "--index")), str(e)
    assert 0 < kept < ROUNDS
