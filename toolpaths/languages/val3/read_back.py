"""Reads back the VAL3 that writer.py wrote, to verify the files on the disk; not VAL3 in general."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from toolpaths.errors import WriteError
from toolpaths.rotation import matrix_from_staubli
from toolpaths.writing.lines import text_of
from toolpaths.writing.numbers import numbers_of
from toolpaths.writing.program import Floats, ReadBack, printed_poses

_CALL = re.compile(r"^ *call (\w+_\d{3,})\(\)", re.M)
_MOVE = re.compile(r"^ *movel\((\w+)\[(\d+)\],\w+\[0\],(\w+)\[(\d+)\]\)", re.M)
_DATA = re.compile(r'<Data name="(\w+)"[^>]*>\r?\n(.*?)</Data>', re.S)
_POINT = re.compile(r' x="([^"]*)" y="([^"]*)" z="([^"]*)" rx="([^"]*)" ry="([^"]*)" rz="([^"]*)"')
_SPEED = re.compile(r' tmax="([^"]*)"')
_JOINTS = re.compile(r' j\d="([^"]*)"')


def read_back(path: Path) -> ReadBack:
    """Poses, feeds and start of the application whose program is at ``path``."""
    main = text_of(path)
    parts = [main] + [text_of(path.with_name(name + path.suffix)) for name in _CALL.findall(main)]
    moves = [m for text in parts for m in _MOVE.findall(text)]
    data = dict(_DATA.findall(text_of(path.with_suffix(".dtx"))))
    joints = [float(a) for a in _JOINTS.findall(data.get("jStart", ""))]
    if len(moves) == 0 or len(joints) < 6:
        raise WriteError(f"{path}: no moves found in the written program")
    tables = {name: _numbers(text) for name, text in data.items() if name.startswith(("pMove", "mMove"))}
    rows = np.array([tables[p][int(i)] for p, i, _, _ in moves])
    return ReadBack(
        poses=printed_poses(rows[:, :3] * 1e-3, rows[:, 3:], lambda r: matrix_from_staubli(np.radians(r))),
        start_joints=np.radians(joints[:6]),
        feed=np.array([tables[m][int(k)][0] for _, _, m, k in moves]) * 1e-3,
    )


def _numbers(text: str) -> Floats:
    """(N, 6) of points, (N, 1) mm/s of movement descriptors."""
    found = _POINT.findall(text) or [(v,) for v in _SPEED.findall(text)]
    return numbers_of([",".join(row) for row in found], len(found[0]) if found else 1)
