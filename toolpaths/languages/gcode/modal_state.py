"""ModalState: the modal words of a G-code file that are in force, and where the tool is."""

from __future__ import annotations

import math

from toolpaths.frame import Frame, Vector
from toolpaths.languages.gcode.canned_cycle import CannedCycle
from toolpaths.languages.gcode.codes import BY_DIAMETER, CYCLES, TIP_CONTROLS, G
from toolpaths.languages.gcode.cutter_compensation import CutterCompensation
from toolpaths.languages.gcode.feed import GcodeFeed
from toolpaths.languages.gcode.origin import Origin
from toolpaths.languages.gcode.tilted_plane import tilted_plane
from toolpaths.languages.gcode.words import Words
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
        self.plane: Frame | None = None  # tilted working plane (G68.2), in the work object
        self.in_plane = False  # G53.1 has turned the tool into it
        self.compensation: CutterCompensation | None = None
        self.beside: dict[str, float] = {}  # A, B, C that stand beside G68.2, deg
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
        if self.plane is not None:
            raise ValueError(f"{name} under G68.2", "Write G69 before it.")
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

    def tilt(self, values: Words) -> None:
        """G68.2."""
        if self.plane is not None:
            raise ValueError("G68.2 on top of G68.2", "Write G69 between them.")
        if self.rotary.letters or self.tip or self.compensation:
            raise ValueError("G68.2 with rotary axes, tool vectors or cutter compensation")
        self.plane = tilted_plane(values, self.scale(), self.origin.shift)
        self.in_plane, self.at = False, LOST
        self.cycle.forget()

    def turn_tool(self) -> None:
        """G53.1."""
        if self.plane is None:
            raise ValueError("G53.1 without G68.2 before it")
        self.in_plane = True

    def stand(self, values: Words, *, home: bool) -> str:
        """A, B, C in a file that tilts its planes: G53.1 turns the axes, so they are remarks; taken from the block."""
        words = {c: values.pop(c) for c in "ABC" if c in values}
        if not home and (self.motion is not G.RAPID or not values.keys().isdisjoint("XYZIJKR")):
            raise ValueError("rotary words beside G68.2: read only as rapids in a block of their own")
        self.beside |= dict.fromkeys(words, 0.0) if home else words
        return " ".join(f"{c}{v:g}" for c, v in words.items())

    def untilt(self) -> None:
        """G69."""
        if self.plane is not None:
            self.plane, self.in_plane, self.at = None, False, LOST
            self.cycle.forget()

    def compensate(self, g: G, values: Words) -> None:
        """G40, G41, G42, G41.1, G42.1."""
        if g is G.CUTTER_COMPENSATION_OFF:
            self.compensation = None
            return
        if self.compensation is not None:
            raise ValueError(f"{g.word} while cutter compensation is on", "Write G40 before it.")
        if self.normal != 2 or self.plane is not None or self.tip or self.rotary.used:
            raise ValueError(f"{g.word}: cutter compensation is read in G17 alone, without tilted axes")
        radius = self._radius(g, values)
        left = g in (G.CUTTER_LEFT, G.CUTTER_LEFT_BY_DIAMETER)
        self.compensation = CutterCompensation(self.track, radius, left=left) if radius > 0 else None

    def _radius(self, g: G, values: Words) -> float:
        """m."""
        register = values.get("D")
        if g in BY_DIAMETER:
            if register is None or not register >= 0:
                raise ValueError(f"{g.word} needs D, the diameter of the cutter")
            return register * self.scale() / 2
        number = self.tool if register is None else register
        if number == 0:
            return 0.0
        radii = self.rotary.machine.radii if self.rotary.machine else {}
        if number != math.floor(number) or int(number) not in radii:
            problem = f"{g.word} D{number:g}: cutter compensation by a radius that is not in the file"
            remedy = (f"Declare it in the cell, [machine.radii] {number:g} = mm (0 where CAM gave the path of the "
                      "cutter's centre, 'wear'), or let CAM compensate ('in computer').")  # fmt: skip
            raise ValueError(problem, remedy)
        return radii[int(number)]

    def shift_in_force(self) -> Vector:
        """What is added to coordinates of the file, m."""
        return self.origin.shift if self.plane is None else (0.0, 0.0, 0.0)

    def scale(self) -> float:
        """m of one length unit of the file."""
        if self.unit is None:
            raise ValueError("no units: neither G21 nor G20 before it", "Add G21 (mm) or G20 (inch) on top.")
        return self.unit
