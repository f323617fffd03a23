"""Reads back the RAPID that writer.py wrote, to verify the file on the disk; not RAPID in general."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from toolpaths.errors import WriteError
from toolpaths.languages.rapid.writer import MOVES_PER_MODULE
from toolpaths.rotation import matrix_from_quaternion
from toolpaths.sharing import each
from toolpaths.writing.axes import places_of
from toolpaths.writing.lines import text_of
from toolpaths.writing.numbers import numbers_of
from toolpaths.writing.program import Floats, ReadBack, printed_poses

_MOVE = re.compile(r"^ *MoveL \[\[([-+.,0-9]*\],\[[-+.,0-9]*\],\[[-+.,0-9]*)\],\[([^\]]*)\]\],([^,]*),", re.M)
_START = re.compile(r"^ *MoveAbsJ \[\[(.*?)\],", re.M)
_SPEED = re.compile(r"speeddata (\w+):=\[([0-9.]+),")
_CALL = re.compile(r"^ *\w+_run_(\d{3,});", re.M)


def read_back(path: Path) -> ReadBack:
    """Poses, feeds (mm/s as printed, in m/s), configuration (cfx) and start of the program at ``path``."""
    main = text_of(path)
    files = [path, *(path.with_name(f"{path.stem}_{i}{path.suffix}") for i in _CALL.findall(main))]
    moves = each(lambda file: _moves(text_of(file)), files, poses=len(files) * MOVES_PER_MODULE)  # one text at a time
    rows, feed = np.concatenate([m[0] for m in moves]), np.concatenate([m[1] for m in moves])
    external = [m[2] for m in moves if m[2] is not None]
    del moves
    start = _START.search(main)
    if start is None or len(rows) == 0:
        raise WriteError(f"{path}: no moves found in the written program")
    return ReadBack(
        poses=printed_poses(rows[:, :3] * 1e-3, rows[:, 3:7].copy(), matrix_from_quaternion),  # not the whole table
        start_joints=np.radians([float(a) for a in start[1].split(",")]),
        feed=feed,
        configuration=rows[:, 10].astype(np.int32),
        external=np.concatenate(external) if external else None,
    )


def _moves(text: str) -> tuple[Floats, Floats, Floats | None]:
    """(M, 11) numbers of the robtargets, (M,) m/s, and external axes (M, K) where there are some."""
    found = _MOVE.findall(text)
    rows = numbers_of([pose.replace("],[", ",") for pose, _, _ in found], 11)
    declared = {name: float(v) * 1e-3 for name, v in _SPEED.findall(text)}
    feeds = {speed: _feed(speed, declared) for speed in {speed for _, _, speed in found}}
    parts = {axes: [v for v in axes.split(",") if v != "9E9"] for axes in {axes for _, axes, _ in found}}
    external = places_of([parts[axes] for _, axes, _ in found])
    return rows, np.array([feeds[speed] for _, _, speed in found], dtype=np.float64), external


def _feed(speed: str, declared: dict[str, float]) -> float:
    name, _, own = speed.partition("\\V:=")
    if name == "vrapid":
        return float("nan")
    return float(own) * 1e-3 if own else declared[name]
