"""ModalState: the modal words of a G-code file that are in force, and where the tool is."""

from __future__ import annotations

import math

from toolpaths.frame import Vector
from toolpaths.languages.gcode.canned_cycle import CannedCycle
from toolpaths.languages.gcode.codes import CYCLES, TIP_CONTROLS, G
from toolpaths.languages.gcode.feed import GcodeFeed
from toolpaths.languages.gcode.origin import Origin
from toolpaths.machine import Machine
from toolpaths.reading.rotary_state import RotaryState
from toolpaths.reading.track import Track
from toolpaths.toolpath import Toolpath

UP: Vector = (0.0, 0.0, 1.0)
LOST: Vector = (math.nan, math.nan, math.nan)


class ModalState:
    """Modal words in force and where the tool is; positions in m in the work object, nan where not known."""

    def __init__(self, source: str, machine: Machine | None) -> None:
        self.track = Track(source, "gcode")
        self.at = LOST if machine is None or machine.start is None else machine.start
        self.axis = UP
        self.motion: G | None = None
        self.normal = 2
        self.unit: float | None = None
        self.relative = self.absolute_centre = self.tip = False
        self.back = False  # G98
        self.tool = 0
        self.feed, self.cycle = GcodeFeed(), CannedCycle()
        self.origin = Origin(machine.systems if machine else None)
        self.rotary = RotaryState(machine)

    def choose_motion(self, motion: G | None) -> None:
        """G0 to G3, a canned cycle, or None for G80."""
        self.motion = motion
        if motion not in CYCLES:
            self.cycle.end()

    def choose_units(self, unit: float, feed_given: bool) -> None:
        """G20, G21."""
        if self.unit not in (None, unit):
            self.cycle.forget()
            if not feed_given:
                self.feed.forget()  # controllers differ in what an F from before a change of units means
        self.unit = unit

    def choose_distance(self, *, relative: bool) -> None:
        """G90, G91."""
        if relative != self.relative:
            self.cycle.forget()
        self.relative = relative

    def choose_plane(self, normal: int) -> None:
        """G17, G18, G19: the index of the axis normal to the plane."""
        self.normal = normal

    def choose_centre(self, *, absolute: bool) -> None:
        """G90.1, G91.1."""
        self.absolute_centre = absolute

    def choose_return(self, *, to_start: bool) -> None:
        """G98, G99."""
        self.back = to_start

    def choose_tool(self, number: int) -> None:
        """T, or M6 where the file has that."""
        self.tool = number

    def choose_system(self, name: str) -> None:
        """G54 and its like."""
        used = len(self.track) > 0 or any(v == v for v in self.at)
        try:
            self.origin.choose(name, used)
        except ValueError as problem:
            raise ValueError(
                str(problem), "Post with one of them, or declare their offsets in [machine] of the cell."
            ) from None
        self.cycle.forget()

    def choose_length(self, g: G) -> None:
        """G43, G43.4, G43.5, G49."""
        self.tip = g in TIP_CONTROLS

    def toolpath(self, chord: float) -> Toolpath:
        """The poses in the work object."""
        return self.rotary.in_work(self.track.toolpath(chord), chord)

    def scale(self) -> float:
        """m of one length unit of the file."""
        if self.unit is None:
            raise ValueError("no units: neither G21 nor G20 before it", "Add G21 (mm) or G20 (inch) on top.")
        return self.unit
