"""Tool and work object of RAPID move instructions: declared in the program, or known to the controller alone."""

from __future__ import annotations

import numpy as np

from toolpaths.frame import Frame
from toolpaths.interpreting.program_text import LinkedText, Statement
from toolpaths.interpreting.robot_track import RobotTrack
from toolpaths.interpreting.values import Runtime
from toolpaths.languages.rapid.values import Value, fits, matrix
from toolpaths.tool_frame import ToolFrame
from toolpaths.toolpath import Floats

_LIGHT = 2e-3  # kg; ABB's own tool0 weighs 1 g: no mass is given


class DeclaredFrames:
    """The tools and work objects of one run."""

    def __init__(self, program: LinkedText, track: RobotTrack) -> None:
        self.program, self._track = program, track
        self._tools: dict[str, int] = {}

    def tool(self, s: Statement, name: str, tool: Value) -> int:
        """The number of a tool, counted from 1 in the order of use; another frame is another tool."""
        key = f"{name.lower()} {tool!r}"
        if key in self._tools:
            return self._tools[key]
        number = self._tools[key] = len(self._tools) + 1
        if isinstance(tool, Runtime):
            return number
        if not fits("tooldata", tool):
            self.program.refuse(s.start, f"{s.word}: {name} is no tooldata")
        if tool[0] is not True:
            problem = f"{name} is a tool that stands still (robhold FALSE)"
            self.program.refuse(s.start, problem, "The arm has to hold it.")
        try:
            frame = matrix(tool[1])
        except ValueError as e:
            self.program.refuse(s.start, f"{name}: {e}")
        mass = tool[2][0] if tool[2][0] > _LIGHT else None
        com = None if mass is None else np.array(tool[2][1]) * 1e-3
        self._track.tools[number] = ToolFrame(name, Frame.of(frame), mass, com)
        return number

    def workobject(self, s: Statement, workobject: Value) -> int:
        """The number of a frame."""
        if workobject is None:
            return self._track.frame(np.eye(4))
        if isinstance(workobject, Runtime):
            return self._track.frame(None, workobject.reason)
        if not fits("wobjdata", workobject):
            self.program.refuse(s.start, f"{s.word}: WObj is no wobjdata")
        held, fixed, unit, user, thing = workobject
        if held:
            self.program.refuse(s.start, f"{s.word}: a work object that is held by the arm (robhold TRUE)")
        try:
            if not fixed:  # on a table: where that stands is the cell's to say, and the user frame the controller's
                return self._track.frame_on(unit, matrix(thing), f"{unit!r} {thing!r}")
            frame: Floats = matrix(user) @ matrix(thing)
        except ValueError as e:
            self.program.refuse(s.start, f"{s.word}: work object: {e}")
        return self._track.frame(frame)
