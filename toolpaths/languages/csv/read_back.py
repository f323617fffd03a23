"""Reads back the CSV that writer.py wrote, to verify the file on the disk; not CSV poses in general."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from toolpaths.errors import WriteError
from toolpaths.languages.csv.writer import columns
from toolpaths.rotation import matrix_from_quaternion
from toolpaths.writing.program import ReadBack, printed_poses


def read_back(path: Path) -> ReadBack:
    """Command poses, joints and feeds of a file that ``files`` wrote."""
    with open(path, encoding="ascii", newline="") as stream:
        header = next(csv.reader([stream.readline()]), [])
        n = sum(name.startswith("q") and name.endswith("_deg") for name in header)
        external = tuple(header[len(columns(n)) :])
        if tuple(header) != columns(n, external):
            raise WriteError(f"{path}: the header is not that of a program as csv")
        last = 2 + 7 + n
        wanted = [*range(2, last), *range(len(columns(n)), len(header))]
        text = np.loadtxt(stream, delimiter=",", dtype=np.float64, usecols=wanted, ndmin=2)
    with open(path, encoding="ascii", newline="") as stream:
        stream.readline()
        feed = np.array([float(row.split(",", last + 1)[last] or "nan") for row in stream]) / 6e4
    return ReadBack(
        poses=printed_poses(text[:, :3] * 1e-3, text[:, 3:7], matrix_from_quaternion),
        joints=np.radians(text[:, 7 : 7 + n]),
        feed=feed,
        external=text[:, 7 + n :] if external else None,
    )
