"""Which readings of a file make the trace: one group, one point; strays are left out and counted."""

from __future__ import annotations

from collections import Counter

import numpy as np

from compensator.devices.readings import POSITIONS, DeviceReadings
from compensator.errors import DeviceError
from toolpaths.finding import NOTE, WARNING, Finding

STRAY = 0.01  # of the largest group: a smaller one got into an export by mistake


def selected(given: DeviceReadings, group: str | None, point: str | None) -> DeviceReadings:
    """The readings of a group and, of positions, of a point: what the command line asks for, else what is clear.

    Raises:
        DeviceError: no such group or point; several of them and none asked for.
    """
    return _of_point(_of_group(given, group), point)


def _of_group(given: DeviceReadings, wanted: str | None) -> DeviceReadings:
    counts = Counter(given.group)
    if wanted is not None and wanted not in counts:
        raise DeviceError(f"{given.source}: --group {wanted!r}: no such group; it has {_listed(counts)}")
    if len(counts) == 1:
        return given
    (first, most), (_, second), *_ = counts.most_common()
    if wanted is None and second > STRAY * most:
        raise DeviceError(f"{given.source}: several groups of points: {_listed(counts)}; give one of them as --group")
    kept = wanted if wanted is not None else first
    rows = np.flatnonzero([g == kept for g in given.group])
    lost = np.flatnonzero([g != kept for g in given.group])
    others = Counter({g: n for g, n in counts.items() if g != kept})
    what = f"points of other groups than {kept!r} are left out: {_listed(others)}"
    level = WARNING if wanted is None else NOTE
    return given.take(rows, Finding(level, given.place(int(lost[0])), what, count=len(lost)))


def _of_point(given: DeviceReadings, wanted: str | None) -> DeviceReadings:
    """Of positions the TCP is one point: names that come back are those of several reflectors."""
    counts = Counter(given.name)
    if wanted is not None and wanted not in counts:
        raise DeviceError(f"{given.source}: --point {wanted!r}: no such point; it has {_listed(counts)}")
    if wanted is None:
        if given.kind == POSITIONS and len(counts) > 1 and max(counts.values()) > 1:
            raise DeviceError(
                f"{given.source}: several points that are measured again and again: {_listed(counts)}; a trace follows "
                "one, the TCP: give it as --point"
            )
        return given
    rows = np.flatnonzero([name == wanted for name in given.name])
    if len(rows) == len(given):
        return given
    lost = len(given) - len(rows)
    return given.take(rows, Finding(NOTE, given.source, f"{lost} points of other names than {wanted!r} are left out"))


def _listed(counts: Counter[str]) -> str:
    shown = [f"{name!r} ({n} points)" for name, n in counts.most_common(8)]
    return ", ".join(shown) + (f" and {len(counts) - 8} more" if len(counts) > 8 else "")
