"""What the second reader of each robot language finds in a program, in one form, with robodk's angle formulas."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import robodk.robomath as robomath

from tests.oracles import fanuc_reader, inform_reader, krl_reader, rapid_reader, urscript_reader, val3_reader


@dataclass
class Line:
    """A straight move.

    Attributes:
        pose: (4, 4) mm of the TCP in the base.
        tool: (4, 4) mm of the TCP in the flange, or the number of the tool where the language holds no data.
        speed: mm/s.
        reach: mm of rounding at its end; 0: stands there; NaN: the controller chooses.
    """

    pose: np.ndarray
    tool: np.ndarray | int
    speed: float
    reach: float


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

    return [
        Line(frame(m.wobj[3]) @ frame(m.target), frame(m.tool[1]), m.speed[0], 0.0 if m.zone[0] else max(m.zone[1:3]))
        for m in moves
        if m.word == "MoveL"
    ]


def krl(files: list[Path]) -> list[Line]:
    def frame(p: dict) -> np.ndarray:
        return _rows(robomath.KUKA_2_Pose([p[k] for k in "XYZABC"]))

    out = []
    for m in krl_reader.read(files[0]).moves:
        if m.word == "LIN":
            reach = m.state["$APO.CDIS"] if m.approximate == "C_DIS" else 0.0
            pose = frame(m.state["$BASE"]) @ frame(m.target)
            out.append(Line(pose, frame(m.state["$TOOL"]), m.state["$VEL.CP"] * 1e3, reach))
    return out


def fanuc(files: list[Path]) -> list[Line]:
    out = []
    for m in fanuc_reader.read(files[0]).moves:
        if m.word == "L":
            pose = robomath.Fanuc_2_Pose(m.frame) * robomath.Fanuc_2_Pose([m.position[k] for k in "XYZWPR"])
            reach = 0.0 if m.termination == "FINE" else math.nan
            out.append(Line(_rows(pose), _rows(robomath.Fanuc_2_Pose(m.tool)), m.value, reach))
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
        Line(work @ frame(m.target), frame(m.tool), m.mdesc["tmax"], m.mdesc["leave"])
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


#: Language of a robot controller -> its second reader.
READERS: dict[str, Callable[[list[Path]], list[Line]]] = {
    "rapid": rapid, "krl": krl, "fanuc": fanuc, "urscript": urscript, "val3": val3, "inform": inform,
}  # fmt: skip
