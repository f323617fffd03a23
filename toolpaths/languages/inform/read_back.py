"""Reads back the INFORM jobs that writer.py wrote, to verify the files on the disk; not INFORM in general."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from toolpaths.errors import WriteError
from toolpaths.frame import Frame
from toolpaths.rotation import matrix_from_motoman
from toolpaths.writing.lines import text_of
from toolpaths.writing.numbers import numbers_of
from toolpaths.writing.program import Floats, ReadBack, printed_poses

_CALL = re.compile(r"^CALL JOB:(\S+)", re.M)
_POSITION = re.compile(r"^C(\d{5})=(\S+)", re.M)
_MOVE = re.compile(r"^MOVL C(\d{5}) V=(\S+)", re.M)
_FRAME = re.compile(
    r"^'Work object in the robot frame\r\n'X (\S+) Y (\S+)\r\n'Z (\S+) mm\r\n'Rx (\S+) Ry (\S+)\r\n'Rz (\S+) deg", re.M
)


def read_back(path: Path) -> ReadBack:
    """Poses in the work object that the job's comments state, and feeds, of the job at ``path``."""
    main = text_of(path)
    numbers = [name.rpartition("_")[2] for name in _CALL.findall(main)]
    parts = [main] + [text_of(path.with_name(f"{path.stem}_{n}{path.suffix}")) for n in numbers]
    rows, feeds = zip(*(_moves(text) for text in parts), strict=True)
    poses, frame = np.concatenate(rows), _FRAME.search(main)
    if frame is None or len(poses) == 0:
        raise WriteError(f"{path}: no moves found in the written job")
    base = np.array([float(v) for v in frame.groups()])
    work = Frame(matrix_from_motoman(np.radians(base[3:])), base[:3])
    return ReadBack(
        poses=printed_poses(
            work.inward(poses[:, :3]) * 1e-3, poses[:, 3:],
            lambda turn: work.rotation.T @ matrix_from_motoman(np.radians(turn)),
        ),
        feed=np.concatenate(feeds) * 1e-3,
    )


def _moves(text: str) -> tuple[Floats, Floats]:
    """(M, 6) mm and deg of the positions that MOVLs go to, (M,) mm/s."""
    table = dict(_POSITION.findall(text))
    found = _MOVE.findall(text)
    rows = numbers_of([table[number] for number, _ in found], 6)
    return rows, np.array([float(v) for _, v in found])
