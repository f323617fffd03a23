"""What the second reader of each robot language finds in a program, in one form, with robodk's angle formulas."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import robodk.robomath as robomath

from tests.oracles import fanuc_reader, inform_reader, krl_reader, rapid_reader, urscript_reader, val3_reader
from toolpaths.files import write_program
from toolpaths.languages.table import writing
from toolpaths.writing.program import Program


@dataclass
class Line:
    """A straight move.

    Attributes:
        pose: (4, 4) mm of the TCP in the base.
        tool: (4, 4) mm of the TCP in the flange, or the number of the tool where the language holds no data.
        speed: mm/s.
        reach: mm of rounding at its end; 0: stands there; NaN: the controller chooses.
        local: (4, 4) mm of the TCP in the work object, where the program has it so.
    """

    pose: np.ndarray
    tool: np.ndarray | int
    speed: float
    reach: float
    local: np.ndarray | None = None


def _rows(pose: robomath.Mat) -> np.ndarray:
    return np.array(pose.rows)


def _at(xyz: list, pose: robomath.Mat) -> np.ndarray:
    out = _rows(pose)
    out[:3, 3] = xyz
    return out


def rapid(files: list[Path]) -> list[Line]:
    moves, _ = rapid_reader.read(files[0])

    def frame(pose: list) -> np.ndarray:
        return _at(pose[0], robomath.quaternion_2_pose(pose[1]))

    out = []
    for m in moves:
        if m.word == "MoveL":
            local, reach = frame(m.target), 0.0 if m.zone[0] else max(m.zone[1:3])
            out.append(Line(frame(m.wobj[3]) @ local, frame(m.tool[1]), m.speed[0], reach, local))
    return out


def krl(files: list[Path]) -> list[Line]:
    def frame(p: dict) -> np.ndarray:
        return _rows(robomath.KUKA_2_Pose([p[k] for k in "XYZABC"]))

    out = []
    for m in krl_reader.read(files[0]).moves:
        if m.word == "LIN":
            reach = m.state["$APO.CDIS"] if m.approximate == "C_DIS" else 0.0
            local = frame(m.target)
            pose = frame(m.state["$BASE"]) @ local
            out.append(Line(pose, frame(m.state["$TOOL"]), m.state["$VEL.CP"] * 1e3, reach, local))
    return out


def fanuc(files: list[Path]) -> list[Line]:
    out = []
    for m in fanuc_reader.read(files[0]).moves:
        if m.word == "L":
            local = robomath.Fanuc_2_Pose([m.position[k] for k in "XYZWPR"])
            pose = robomath.Fanuc_2_Pose(m.frame) * local
            reach = 0.0 if m.termination == "FINE" else math.nan
            out.append(Line(_rows(pose), _rows(robomath.Fanuc_2_Pose(m.tool)), m.value, reach, _rows(local)))
    return out


def urscript(files: list[Path]) -> list[Line]:
    """The files are run one after the other; the reader's own rotation vectors are scipy's."""

    def millimetres(pose: np.ndarray) -> np.ndarray:
        return np.block([[pose[:3, :3], pose[:3, 3:] * 1e3], [pose[3:]]])

    moves = [m for f in files for m in urscript_reader.read(f).moves if m.word == "movel"]
    return [Line(millimetres(m.target), millimetres(m.tcp), m.v * 1e3, m.r * 1e3) for m in moves]


def val3(files: list[Path]) -> list[Line]:
    app = val3_reader.read(files[0].with_suffix(".pjx"))

    def frame(p: dict) -> np.ndarray:
        return _rows(robomath.Staubli_2_Pose([p[k] for k in ("x", "y", "z", "rx", "ry", "rz")]))

    work = frame(app.data["fWork"][1][0])
    return [
        Line(work @ frame(m.target), frame(m.tool), m.mdesc["tmax"], m.mdesc["leave"], frame(m.target))
        for m in app.moves
        if m.word == "movel"
    ]


def inform(files: list[Path]) -> list[Line]:
    out = []
    for m in inform_reader.read(files[0]).moves:
        if m.word == "MOVL":
            pose = _rows(robomath.Motoman_2_Pose([*m.position.xyz, *m.position.angles]))
            out.append(Line(pose, m.position.tool, m.speed, 0.0 if m.level == 0 else math.nan))
    return out


#: Language of a robot controller -> what else it does than moves: halts, messages, instructions.
OTHER: dict[str, Callable[[list[Path]], list]] = {
    "rapid": lambda files: rapid_reader.read(files[0])[1],
    "krl": lambda files: ["HALT"] * krl_reader.read(files[0]).halts,
    "fanuc": lambda files: ["PAUSE"] * fanuc_reader.read(files[0]).pauses,
    "urscript": lambda files: [said for f in files for said in urscript_reader.read(f).popups],
    "val3": lambda files: val3_reader.read(files[0].with_suffix(".pjx")).said,
    "inform": lambda files: inform_reader.read(files[0]).pauses,
}
#: Language of a robot controller -> its second reader.
READERS: dict[str, Callable[[list[Path]], list[Line]]] = {
    "rapid": rapid, "krl": krl, "fanuc": fanuc, "urscript": urscript, "val3": val3, "inform": inform,
}  # fmt: skip


def moves_of(program: Program, file: Path) -> list[Line]:
    """The program written to ``file``, as its controller reads it; nothing may warn."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        written = write_program(program, file)
    language = writing(file)
    assert language is not None
    return READERS[language.name](list(written.files))


def in_base(program: Program) -> np.ndarray:
    """(N, 4, 4) mm: where the controller has to have the TCP."""
    poses = np.tile(np.eye(4), (len(program), 1, 1))
    poses[:, :3, :3], poses[:, :3, 3] = program.rotation, program.position
    poses = program.workobject.matrix @ poses
    poses[:, :3, 3] *= 1e3
    return poses
