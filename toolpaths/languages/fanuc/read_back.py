"""Reads back the TP program that writer.py wrote, to verify the file on the disk; not .ls in general."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from toolpaths.errors import WriteError
from toolpaths.languages.fanuc.config import bits_of, model_joints
from toolpaths.rotation import matrix_from_fanuc
from toolpaths.writing.axes import places_of
from toolpaths.writing.lines import text_of
from toolpaths.writing.numbers import numbers_of
from toolpaths.writing.program import Floats, ReadBack, printed_poses

_MOVE = re.compile(r"^ *\d+:L P\[(\d+)\] ([0-9.]+)(mm/sec|cm/min|inch/min) ", re.M)
_CALL = re.compile(r"^ *\d+:  CALL (\w+) ;", re.M)
_NUMBER = r" *(-?[0-9.]+) +(?:mm|deg),?\s+"
_POSITION = re.compile(
    r"P\[(\d+)\]\{\s+GP1:\s+UF : \d+, UT : \d+,\s+CONFIG : '([NFUDTB ]+),[^']*',\s+"
    + "".join(f"{axis} ={_NUMBER}" for axis in "XYZWPR")
    + r"((?:E\d= *-?[0-9.]+ +(?:mm|deg),?\s+)*)"
)
_EXTERNAL = re.compile(r"E\d= *(-?[0-9.]+)")
_JOINTS = re.compile(r"P\[\d+\]\{\s+GP1:\s+UF : \d+, UT : \d+,\s+" + "".join(f"J{i}={_NUMBER}" for i in range(1, 7)))
_UNITS = {"mm/sec": 1e-3, "cm/min": 1.0 / 6e3, "inch/min": 25.4e-3 / 60.0}


def read_back(path: Path) -> ReadBack:
    """Poses, feeds (rapids, too), configuration and start of the program at ``path``."""
    main = text_of(path)
    calls = _CALL.findall(main)
    found = [path.with_name(path.stem + name[len(path.stem) :] + path.suffix) for name in calls]
    parts = [main] if not calls else [text_of(p) for p in found]
    moves = [_moves(text) for text in parts]
    rows, feeds, bits = (np.concatenate([m[k] for m in moves]) for k in range(3))
    external = [m[3] for m in moves if m[3] is not None]
    if len(rows) == 0:
        raise WriteError(f"{path}: no moves found in the written program")
    start = _JOINTS.search(main)
    return ReadBack(
        poses=printed_poses(rows[:, :3] * 1e-3, rows[:, 3:], lambda wpr: matrix_from_fanuc(np.radians(wpr))),
        start_joints=None if start is None else model_joints(np.radians(np.array(start.groups(), dtype=np.float64))),
        feed=feeds,
        configuration=bits.astype(np.int32),
        external=np.concatenate(external) if external else None,
    )


def _moves(text: str) -> tuple[Floats, Floats, Floats, Floats | None]:
    """(M, 6) numbers of the positions in the order of the moves, (M,) m/s, (M,) configuration bits, and external axes
    (M, K) where there are some."""
    made: dict[str, int] = {}
    at: dict[str, tuple[str, str, str]] = {}
    for number, config, *values, axes in _POSITION.findall(text):
        made.setdefault(config, bits_of(config))
        at[number] = (config, ",".join(values), axes)
    moves = _MOVE.findall(text)
    found = [at[number] for number, _, _ in moves]
    numbers = numbers_of([row for _, row, _ in found], 6)
    feeds = np.array([float(v) * _UNITS[unit] for _, v, unit in moves])
    external = places_of([_EXTERNAL.findall(axes) for _, _, axes in found])
    return numbers, feeds, np.array([made[config] for config, _, _ in found], dtype=np.float64), external
