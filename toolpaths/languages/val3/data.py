"""The data of a VAL3 application (.dtx): frame, tools, joint positions, movement descriptors, points. mm and deg."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain

import numpy as np
import numpy.typing as npt

from toolpaths.frame import Frame
from toolpaths.rotation import staubli_from_matrix
from toolpaths.toolpath import CUT
from toolpaths.writing.blending import blending, steps_within
from toolpaths.writing.lines import joint_moves
from toolpaths.writing.numbers import number, printed
from toolpaths.writing.program import Floats, Program

#: Rounding, ``leave`` = ``reach``, m, rising.
_DISTANCES = (5e-6, 1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 5e-3)

#: The arm keeps the configuration that the joint move to the start gave it.
_CONFIG = 'shoulder="ssame" elbow="esame" wrist="wsame"'
_POINT = (
    f'      <Value key="%d" x="%.4f" y="%.4f" z="%.4f" rx="%.5f" ry="%.5f" rz="%.5f" {_CONFIG} fatherId="fWork[0]" />\n'
)
_HEAD = (
    '<?xml version="1.0" encoding="utf-8"?>\n'
    '<Database xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" '
    'xmlns="http://www.staubli.com/robotics/VAL3/Data/2">\n  <Datas>\n'
)


@dataclass(frozen=True)
class Val3Part:
    """The moves of one program.

    Attributes:
        block: its poses.
        speeds: (mm/s, step of rounding) of each movement descriptor.
        index: (N of the block,) the descriptor of each move.
    """

    block: slice
    speeds: tuple[tuple[float, int], ...]
    index: npt.NDArray[np.intp]


@dataclass(frozen=True)
class Val3Data:
    """What the moves of an application refer to: numbers of the tools, parts."""

    tools: tuple[int, ...]
    parts: tuple[Val3Part, ...]


def data(program: Program, per: int) -> Val3Data:
    """Movement descriptors of every part of ``per`` moves: each distinct pair of speed and rounding once."""
    speed = np.round(np.where(program.kind == CUT, program.feed, program.rapid_speed) * 1e3, 5)
    step = steps_within(blending(program).radius, _DISTANCES)
    parts = []
    for block in program.blocks(per):
        pairs = np.column_stack((speed[block], step[block]))
        rows, index = np.unique(pairs, axis=0, return_inverse=True)
        parts.append(Val3Part(block, tuple((float(v), int(k)) for v, k in rows), index.reshape(-1)))
    return Val3Data(tuple(sorted({int(t) for t in np.unique(program.tool)})), tuple(parts))


def data_text(program: Program, words: Val3Data) -> Iterator[str]:
    """The .dtx file."""
    yield _HEAD
    frame = _placed(program.workobject, "world[0]")
    yield _array("fWork", "frame", [frame])
    for n in words.tools:
        tool = program.tools[n]
        yield _array(f"tTool{n}", "tool", [_placed(tool.frame, "flange[0]")])
    starts = [] if program.start_joints is None else [program.start_joints]
    yield _array("jStart", "jointRx", [_joints(q) for q in (*starts, *program.joints[list(start_index(program))])])
    yield _array("mStart", "mdesc", [_mdesc(program.rapid_speed * 1e3, 0, 20)])
    for i, part in enumerate(words.parts, 1):
        yield _array(f"mMove{i:03d}", "mdesc", [_mdesc(v, k, 100) for v, k in part.speeds])
        yield _open(f"pMove{i:03d}", "pointRx", part.block.stop - part.block.start)
        yield from _points(program, part.block)
        yield "    </Data>\n"
    yield "  </Datas>\n</Database>\n"


def start_index(program: Program) -> dict[int, int]:
    """Pose that a joint move goes to -> its place in jStart."""
    first = 0 if program.start_joints is None else 1
    return {pose: first + k for k, pose in enumerate((0, *joint_moves(program)))}


def _points(program: Program, block: slice) -> Iterator[str]:
    for b in program.blocks(4096, block.start, block.stop):
        keys = range(b.start - block.start, b.stop - block.start)
        position = printed(program.position[b] * 1e3, 4)
        angles = printed(np.degrees(staubli_from_matrix(program.rotation[b])), 5)
        rows = zip(keys, *position.T.tolist(), *angles.T.tolist(), strict=True)
        yield _POINT * len(keys) % tuple(chain.from_iterable(rows))


def _open(name: str, kind: str, size: int) -> str:
    return f'    <Data name="{name}" access="private" xsi:type="array" type="{kind}" size="{size}">\n'


def _array(name: str, kind: str, values: Iterable[str]) -> str:
    lines = [f'      <Value key="{i}" {value} />\n' for i, value in enumerate(values)]
    return _open(name, kind, len(lines)) + "".join(lines) + "    </Data>\n"


def _placed(frame: Frame, father: str) -> str:
    values = (*(frame.origin * 1e3), *np.degrees(staubli_from_matrix(frame.rotation)))
    digits = (4, 4, 4, 6, 6, 6)
    pairs = zip(("x", "y", "z", "rx", "ry", "rz"), values, digits, strict=True)
    return " ".join(f'{k}="{number(float(v), d)}"' for k, v, d in pairs) + f' fatherId="{father}"'


def _joints(q: Floats) -> str:
    return " ".join(f'j{i}="{a:.6f}"' for i, a in enumerate(printed(np.degrees(q), 6).tolist(), 1))


def _mdesc(speed: float, step: int, percent: int) -> str:
    """accel, decel and joint speed in percent, Cartesian speeds in mm/s and deg/s, rounding in mm."""
    blend = "Cartesian" if step else "off"
    r = number(_DISTANCES[step - 1] * 1e3, 3) if step else "0"
    return (
        f'accel="100" vel="{percent}" decel="100" tmax="{number(speed, 5)}" rmax="500" '
        f'blend="{blend}" leave="{r}" reach="{r}"'
    )
