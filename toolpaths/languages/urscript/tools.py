"""The tools of a URScript program: set_tcp and set_payload."""

from __future__ import annotations

import numpy as np

from toolpaths.frame import Frame
from toolpaths.interpreting.robot_track import RobotTrack
from toolpaths.languages.urscript.expressions import UrPose, Value
from toolpaths.tool_frame import ToolFrame
from toolpaths.toolpath import Floats


class UrTools:
    """Numbers 1, 2, ... of the pairs of TCP and payload that moves are made with; 0 before the first set_tcp."""

    def __init__(self, track: RobotTrack) -> None:
        self._track = track
        self._tcp: UrPose | None = None
        self._load: tuple[float | None, Floats | None] = (None, None)
        self._known: dict[tuple[object, ...], int] = {}
        self._number: int | None = 0

    def tcp(self, pose: UrPose) -> None:
        """From here on the TCP is at ``pose`` in the flange frame."""
        self._tcp, self._number = pose, None

    def payload(self, mass: float, com: Value | None) -> None:
        """From here on the load is ``mass`` kg with its centre at ``com``, a list of three m, in the flange frame."""
        known = isinstance(com, list) and len(com) == 3 and all(type(v) is float for v in com)
        self._load = (mass, np.array(com, dtype=np.float64) if known else None)
        self._number = None

    def number(self) -> int:
        """The tool of the next move; the track gets its frame and load."""
        if self._number is None:
            self._number = 0 if self._tcp is None else self._found(self._tcp)
        return self._number

    def _found(self, tcp: UrPose) -> int:
        mass, com = self._load
        key = (tcp.numbers, mass, None if com is None else tuple(com.tolist()))
        number = self._known.setdefault(key, len(self._known) + 1)
        self._track.tools[number] = ToolFrame(f"TCP {number}", Frame.of(tcp.matrix()), mass, com)
        return number
