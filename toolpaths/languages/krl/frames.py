"""Tool and base of KRL motion lines: by number, by value, or known to the controller alone."""

from __future__ import annotations

import numpy as np

from toolpaths.frame import Frame
from toolpaths.interpreting.program_text import Statement
from toolpaths.interpreting.robot_track import RobotTrack
from toolpaths.interpreting.values import ExpressionError, OnUnit, Runtime
from toolpaths.languages.krl.expressions import POSE, Value, frame
from toolpaths.languages.krl.names import KrlNames
from toolpaths.languages.krl.program import KrlProgram
from toolpaths.tool_frame import ToolFrame
from toolpaths.toolpath import Floats


class MountedFrames:
    """$TOOL and $BASE of one run."""

    def __init__(self, program: KrlProgram, names: KrlNames, track: RobotTrack) -> None:
        self.program, self.names, self._track = program, names, track
        self._numbers: dict[str, int | None] = {"$TOOL": 0, "$BASE": None}
        self._tools: dict[str, int] = {}

    def by_number(self, name: str, number: int | None) -> None:
        """$TOOL or $BASE is that of a number from here on, or of none."""
        self._numbers[name] = number

    def _frame(self, s: Statement, name: str, own: Value) -> tuple[int | None, Value]:
        """Number and value of $TOOL or $BASE, of this line or as set before."""
        if own is None:
            variable = self.names.get(name)
            value = Runtime(f"{name}, which is not set") if variable is None else variable.value
            return self._numbers[name], value
        if not isinstance(own, float):
            return None, own
        return int(own), self.names.look_up(f"{name[1:]}_DATA[{own:g}]") if own else dict.fromkeys(POSE, 0.0)

    def tool(self, s: Statement, own: Value) -> int:
        """The number of the tool in use; ``own`` is that of the line itself, else None."""
        number, value = self._frame(s, "$TOOL", own)
        load = self.names.get("$LOAD")
        key = f"{number} {value!r} {load.value if load else None!r}"
        if key not in self._tools:
            taken = set(self._tools.values())
            if number is None or (number in taken and not isinstance(value, Runtime)):
                number = next(n for n in range(1, len(taken) + 3) if n not in taken)
            self._tools[key] = number
            if isinstance(value, dict):
                pose = self._matrix(s, value)
                name = self.names.get(f"TOOL_NAME[{number}]")
                shown = name.value.strip('"') if name and isinstance(name.value, str) else f"tool {number}"
                mass, com = _load(load.value if load else None)
                self._track.tools[number] = ToolFrame(shown, Frame.of(pose), mass, com)
        return self._tools[key]

    def base(self, s: Statement, own: Value) -> int:
        """The number of the base in use."""
        number, value = self._frame(s, "$BASE", own)
        if isinstance(value, dict):
            return self._track.frame(self._matrix(s, value))
        if isinstance(value, OnUnit):
            return self._track.frame_on(value.unit, np.array(value.pose), value.key)
        return self._track.frame(None, f"{number}" if number is not None else getattr(value, "reason", ""))

    def _matrix(self, s: Statement, value: dict[str, Value]) -> Floats:
        try:
            return frame(value)
        except ExpressionError as e:
            self.program.refuse(s.start, str(e))


def _load(value: Value) -> tuple[float | None, Floats | None]:
    """kg and m of $LOAD; None where it gives none."""
    if not isinstance(value, dict) or not isinstance(value.get("M"), float) or value["M"] <= 0.0:
        return None, None
    cm = value.get("CM")
    if not isinstance(cm, dict) or not all(isinstance(cm.get(k), float) for k in "XYZ"):
        return None, None
    return value["M"], np.array([cm[k] for k in "XYZ"]) * 1e-3
