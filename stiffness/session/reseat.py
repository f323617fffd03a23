"""Reseat: a reflector that was taken off and put on anew is another reflector, roughly at the same place."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from stiffness.session.file import Reflector
from stiffness.session.samples import Samples
from stiffness.session.table import CsvTable

Ints = npt.NDArray[np.int64]


def reseated(
    table: CsvTable, samples: Samples, known: tuple[Reflector, ...]
) -> tuple[Samples, tuple[Reflector, ...]]:
    """The readings with every seat of a reflector as a reflector of its own.

    The seat with the lowest number is the reflector as session.toml has it; every further one is called
    ``NAME (reseat K)``, is not exact, and begins at the same place. A probe of several reflectors is put on as a whole.

    Raises:
        SessionError: a number that counts nothing, or reflectors of one probe with different numbers in one reading.
    """
    if "reseat" not in table.cells:
        return samples, known
    seat = table.integers(["reseat"])[:, 0]
    table.refuse(seat < 0, ["reseat"], "a count of how often the reflector was put on anew: 0 or above")
    _check_probes(table, samples, seat, known)
    reflectors, number = list(known), samples.reflector.copy()
    for k, r in enumerate(known):
        mine = samples.reflector == k
        whole = mine if r.group is None else np.isin(samples.reflector, _members(known, r.group))
        for value in np.unique(seat[whole])[1:].tolist():
            if not (mine & (seat == value)).any():
                continue
            number[mine & (seat == value)] = len(reflectors)
            group = None if r.group is None else f"{r.group} (reseat {value})"
            reflectors.append(replace(r, name=f"{r.name} (reseat {value})", exact=False, group=group))
    return replace(samples, reflector=number), tuple(reflectors)


def _members(known: tuple[Reflector, ...], group: str) -> list[int]:
    return [k for k, r in enumerate(known) if r.group == group]


def _check_probes(table: CsvTable, samples: Samples, seat: Ints, known: tuple[Reflector, ...]) -> None:
    for group in dict.fromkeys(r.group for r in known if r.group is not None):
        rows = np.flatnonzero(np.isin(samples.reflector, _members(known, group)))
        key = np.column_stack([samples.setup, samples.state, samples.block, samples.repeat])[rows]
        _, first, of = np.unique(key, axis=0, return_index=True, return_inverse=True)
        differs = np.zeros(len(samples), dtype=bool)
        differs[rows] = seat[rows] != seat[rows][first[of.reshape(-1)]]
        why = f"reflectors of probe {group!r} in one reading have different numbers; a probe is put on as a whole"
        table.refuse(differs, ["reseat"], why)
