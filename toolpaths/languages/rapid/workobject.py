"""Work objects in the words of RAPID: fixed, or on a mechanical unit that turns the part.

Sources: ABB 3HAC050917, data type wobjdata (ufprog, ufmec); 3HAC021272 "MultiMove", coordinated work objects.
"""

from __future__ import annotations

from collections.abc import Iterator

from toolpaths.external_axes import axis_number
from toolpaths.frame import Frame
from toolpaths.rotation import quaternion_from_matrix
from toolpaths.writing.names import plain
from toolpaths.writing.numbers import number
from toolpaths.writing.program import Floats, Program

LONGEST = 120  # characters of a comment


def workobject_lines(program: Program, name: str) -> Iterator[str]:
    """The work object: fixed, or on a mechanical unit, whose user frame the controller keeps where the unit is."""
    carrier, still = program.carrier, pose_text(Frame.identity())
    if carrier is None:
        yield f'  TASK PERS wobjdata {name}:=[FALSE,TRUE,"",{pose_text(program.workobject)},{still}];\n'
        return
    axis, unit = f"eax_{'abcdef'[axis_number(carrier.axis) or 0]}", carrier.unit
    for text in (
        f"{axis} turns the part while it cuts: mechanical unit {unit}, coordinated.",
        f"The controller has to have {unit} active, {axis} its axis, and its user",
        f"frame, with {axis} at 0, in the world here:",
        pose_text(carrier.stands),
    ):
        yield f"  ! {plain(text, LONGEST)}\n"
    on_unit = pose_text(carrier.on_unit(program.workobject))
    yield f'  TASK PERS wobjdata {name}:=[FALSE,FALSE,"{unit}",{still},{on_unit}];\n'


def pose_text(frame: Frame) -> str:
    """A pose of RAPID: mm and a quaternion."""
    return f"[{numbers_text(frame.origin * 1e3, 4)},{numbers_text(quaternion_from_matrix(frame.rotation), 8)}]"


def numbers_text(values: Floats, digits: int) -> str:
    """Numbers in brackets."""
    return "[" + ",".join(number(float(v), digits) for v in values) + "]"
