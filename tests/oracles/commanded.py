"""Poses that a filter is asked to put in: those of a toolpath, moved and turned; and what came of it in the file."""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.oracles.sample_programs import SPINDLE
from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath
from toolpaths.frame import Frame
from toolpaths.languages.table import reading
from toolpaths.rewriting.filter import Rewritten
from toolpaths.rotation import rotation_of_axis
from toolpaths.toolpath import Toolpath
from toolpaths.writing.marker import MARKER
from toolpaths.writing.program import Program

SHIFT = np.array([1.2e-4, -3.4e-4, 5.6e-4])
TURN = Rotation.from_rotvec([1e-3, -2e-3, 3e-3])


def commanded(toolpath, index=None, shift=0.0, turn=(0, 0, 0), row=None) -> tuple[Program, np.ndarray]:
    """The toolpath's poses ``index`` (None: all), moved by ``shift`` (m) and turned (a vector), and their rows.

    Rapids are moved as well: a filter has to leave them.
    """
    t = toolpath.take(np.arange(len(toolpath)) if index is None else index)
    n = len(t)
    if t.quaternion is None:
        rotation = Rotation.from_matrix(rotation_of_axis(t.axis))
    else:
        quaternion = np.where(np.isfinite(t.quaternion), t.quaternion, [1, 0, 0, 0])
        rotation = Rotation.from_quat(quaternion, scalar_first=True)
    position = np.nan_to_num(t.position, nan=0.5)
    told = np.zeros(n, dtype=int)
    if t.setting is not None and t.setting.configuration is not None:
        told = np.maximum(t.setting.configuration[np.ceil(t.row - 1e-9).astype(int)], 0)
    made = Program(
        name="P",
        position=position + shift,
        rotation=(Rotation.from_rotvec(turn) * rotation).as_matrix(),
        joints=np.zeros((n, 6)),
        feed=t.feed,
        kind=t.kind,
        tool=t.tool,
        line=t.line,
        tools={int(k): SPINDLE for k in set(t.tool)},
        workobject=Frame.identity(),
        rapid_speed=1.0,
        configuration=told,
        nominal_position=position,
        nominal_rotation=rotation.as_matrix(),
        source=Path(toolpath.source).name,
    )
    return made, t.row if row is None else np.asarray(row)


def program_of(path: Toolpath, position: np.ndarray | None = None, axis: np.ndarray | None = None) -> Program:
    """The toolpath's poses with other positions and tool axes."""
    made, _ = commanded(path)
    position = made.position if position is None else np.array(position)
    rotation = made.rotation if axis is None else rotation_of_axis(axis)
    return replace(made, position=position, rotation=rotation, configuration=None)


def run(
    name: str, folder: Path, text: str, make: Callable[[Toolpath], tuple[Program, np.ndarray]], chord: float = 1e-5
) -> tuple[Toolpath, Program, Rewritten]:
    """A file, and what the filter of its language makes of it with what ``make`` commands for its poses."""
    file = folder / name
    file.write_bytes(text.encode())
    path = read_toolpath(file, chord=chord, shown=name)
    made, row = make(path)
    return path, made, _rewritten(file, made, row)


def read_again(name: str, folder: Path, done: Rewritten, chord: float = 1e-5) -> Toolpath:
    """What stands in a changed program, which the filter does not take a second time."""
    file = folder / f"again-{name}"
    file.write_bytes(done.text)
    path = read_toolpath(file, chord=chord)
    with pytest.raises(ReadError, match="compensated already"):
        _rewritten(file, *commanded(path, [0]))
    return path


def _rewritten(file: Path, made: Program, row: np.ndarray) -> Rewritten:
    language = reading(file)
    assert language is not None
    return language.rewrite(file.read_bytes(), made, row, file, None)


def bent(path: Toolpath, nominal: list[float], after: list[float]) -> Program:
    """Moved poses with the same joint angles, deg, at every pose: by the program, and behind the correction."""
    angles = [np.radians(np.tile(q, (len(path), 1)).astype(float)) for q in (nominal, after)]
    return replace(commanded(path, shift=SHIFT)[0], nominal_joints=angles[0], joints=angles[1])


def whole(path: Toolpath) -> np.ndarray:
    """The poses that stand in the file: not those of its arcs."""
    return np.flatnonzero(np.abs(path.row - np.rint(path.row)) < 1e-9)


def changed_lines(old: bytes, new: bytes) -> tuple[list[str], list[str]]:
    """Lines that went, and lines that came."""
    a, b = old.decode("latin-1").split("\n"), new.decode("latin-1").split("\n")
    if len(b) == len(a) + 1:  # the marker alone came
        at = next(k for k, line in enumerate(b) if MARKER in line)
        pairs = [p for p in zip(a, b[:at] + b[at + 1 :], strict=True) if p[0] != p[1]]
        return [p[0] for p in pairs], [b[at], *(p[1] for p in pairs)]
    diff = list(difflib.unified_diff(a, b, n=0))[2:]
    return [d[1:] for d in diff if d[0] == "-"], [d[1:] for d in diff if d[0] == "+"]


_MARK = re.compile(
    rb"^[^\r\n]*compensated by toolpath-compensator[^\r\n]*\r?\n"
    rb"|^    :  !compensated by ;\r?\n    :  !toolpath-compensator ;\r?\n",
    re.M,
)


def without_marker(text: bytes) -> bytes:
    """A rewritten program without its marker, which has to be there once: a comment, or two remarks of Fanuc."""
    before, after = _MARK.split(text)
    assert b"toolpath-compensator" not in before + after
    return before + after
