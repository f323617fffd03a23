"""Reads back the URScript that writer.py wrote, to verify the file on the disk; not URScript in general."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from toolpaths.errors import WriteError
from toolpaths.rotation import matrix_from_ur
from toolpaths.writing.lines import text_of
from toolpaths.writing.numbers import numbers_of
from toolpaths.writing.program import Floats, ReadBack, printed_poses

_MOVE = re.compile(r"^  movel\(pose_trans\(wobj, p\[(.*?)\]\), a=1\.2, v=([^,)]*)", re.M)
_START = re.compile(r"^  movej\(\[(.*?)\]", re.M)
_NEXT = re.compile(r"^  # continued in: (.*)$", re.M)


def read_back(path: Path) -> ReadBack:
    """Poses in the work object, feeds (NaN of rapids) and start of the programs that begin at ``path``."""
    texts = [text_of(path)]
    while following := _NEXT.search(texts[-1]):
        texts.append(text_of(path.with_name(following[1])))
    rows, feeds = (np.concatenate(v) for v in zip(*(_moves(text) for text in texts), strict=True))
    start = _START.search(texts[0])
    if start is None or len(rows) == 0:
        raise WriteError(f"{path}: no moves found in the written program")
    return ReadBack(
        poses=printed_poses(rows[:, :3], rows[:, 3:], matrix_from_ur),
        start_joints=np.array([float(a) for a in start[1].split(",")]),
        feed=feeds,
    )


def _moves(text: str) -> tuple[Floats, Floats]:
    """(M, 6) numbers of the movels, (M,) m/s."""
    found = _MOVE.findall(text)
    feeds = np.array([float("nan") if v == "v_rapid" else float(v) for _, v in found], dtype=np.float64)
    return numbers_of([pose for pose, _ in found], 6), feeds
