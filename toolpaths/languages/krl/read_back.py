"""Reads back the KRL that writer.py wrote, to verify the file on the disk; not KRL in general."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from toolpaths.errors import WriteError
from toolpaths.rotation import matrix_from_kuka
from toolpaths.writing.axes import places_of
from toolpaths.writing.lines import text_of
from toolpaths.writing.numbers import numbers_of
from toolpaths.writing.program import Floats, ReadBack, printed_poses

_WORD = re.compile(
    r"^ *(?:LIN \{X ([^,]*),Y ([^,]*),Z ([^,]*),A ([^,]*),B ([^,]*),C ([^,}]*)(?:,S (\d+),T (\d+))?((?:,E\d [^,}]*)*)\}"
    r"|\$VEL\.CP=(\S+))",
    re.M,
)
_START = re.compile(r"^ *PTP \{(?:E6)?AXIS: (.*?)(?:,E\d.*?)?\}", re.M)
_CALL = re.compile(r"^ *(\w+_\d{3,})\(\)", re.M)


def read_back(path: Path) -> ReadBack:
    """Poses, feeds, configuration (from S) and start of the program at ``path``."""
    main = text_of(path)
    parts = [main] + [text_of(path.with_name(name + path.suffix)) for name in _CALL.findall(main)]
    poses, feeds, status, external = zip(*(_moves(text) for text in parts), strict=True)
    axes = [some for some in external if some is not None]
    rows, s = np.concatenate(poses), np.concatenate(status)
    start = _START.search(main)
    if start is None or len(rows) == 0:
        raise WriteError(f"{path}: no moves found in the written program")
    return ReadBack(
        poses=printed_poses(rows[:, :3] * 1e-3, rows[:, 3:], lambda abc: matrix_from_kuka(np.radians(abc))),
        start_joints=np.radians([float(a.split()[1]) for a in start[1].split(",")]),
        feed=np.concatenate(feeds),
        configuration=_configuration(s) if (s >= 0).all() else None,
        external=np.concatenate(axes) if axes else None,
    )


def _moves(text: str) -> tuple[Floats, Floats, Floats, Floats | None]:
    """(M, 6) numbers of the LINs, (M,) m/s, (M,) S or -1, and external axes (M, K) where there are some."""
    rows: list[str] = []
    feeds: list[float] = []
    status: list[float] = []
    axes: list[list[str]] = []
    speed = float("nan")
    for found in _WORD.findall(text):
        if found[9]:
            speed = float(found[9])
        else:
            rows.append(",".join(found[:6]))
            feeds.append(speed)
            status.append(float(found[6] or -1))
            axes.append([part.split(" ")[1] for part in found[8].split(",")[1:]])
    return numbers_of(rows, 6), np.array(feeds), np.array(status), places_of(axes)


def _configuration(status: Floats) -> np.ndarray[tuple[int], np.dtype[np.int32]]:
    """(N,) bits as in Program of S."""
    s = status.astype(np.int32)
    return ((s & 1) << 2) | ((1 - ((s >> 1) & 1)) << 1) | ((s >> 2) & 1)
