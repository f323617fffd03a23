"""AptMotion: where the tool of an APT/CL file goes: GOTO and its like, circles, tangent arcs, drilling cycles."""

from __future__ import annotations

import math

from toolpaths.frame import Vector
from toolpaths.languages.apt.circle import AptCircle, circle, sweep
from toolpaths.languages.apt.drill_cycle import SAME, DrillCycle, at_hole, cycle, hole
from toolpaths.languages.apt.feed import AptFeeds
from toolpaths.languages.apt.frames import CamFrames, point, vector
from toolpaths.languages.apt.machine_commands import commands_of
from toolpaths.languages.apt.moved_arc import MovedArcs
from toolpaths.languages.apt.tangent_arc import direction, tlon
from toolpaths.languages.apt.tool import AptTool
from toolpaths.languages.apt.words import UNIT_TOLERANCE, AptStatement, numbers, refusal
from toolpaths.reading.source_text import comment_word
from toolpaths.reading.track import CUT_MARK, RAPID_MARK, Track

UPRIGHT: Vector = (0.0, 0.0, 1.0)
SAME_AXIS = 1e-6
MOST_DRILLED = 1_000_000  # poses that cycles may add: a short file must not fill the memory


class AptMotion:
    """The tool of one file; positions in the file's length unit."""

    def __init__(self, source: str) -> None:
        self.source = source
        self.track = Track(source, "apt")
        self.feeds, self.frames, self.tool = AptFeeds(source, self.track.spindle), CamFrames(source), AptTool(source)
        self.axis, self.axis_stale = UPRIGHT, False  # in the frame in force
        self.at: Vector | None = None  # in the first frame, as what follows
        self.at_axis = UPRIGHT
        self.rapid = False
        self.circle: tuple[AptStatement, AptCircle] | None = None
        self.moved_arcs = MovedArcs(source)
        self.way: tuple[AptStatement, Vector] | None = None  # INDIRV, in the frame in force
        self.cycle: DrillCycle | None = None
        self.unclosed: AptStatement | None = None  # what ended a cycle without CYCLE/OFF
        self.fusion = False  # the stock post of Fusion 360
        self.before: tuple[Vector | None, Vector] = None, UPRIGHT  # place and axis when the cycle began
        self.drilled = 0
        self.paths = self.open = False  # the file has paths (NX), and one is open

    def _goto(self, s: AptStatement) -> None:
        values = numbers(s, (3, 6), self.source)
        axis = self._axis(s, values[3:])
        frame = self.frames.way
        self._go(s, point(frame, (values[0], values[1], values[2])), vector(frame, axis))

    def _go(self, s: AptStatement, end: Vector, axis: Vector) -> None:
        """To ``end`` in the first frame: straight, along the circle announced, or into a hole."""
        self._no_way()
        self._inside(s)
        if self.cycle:
            self._drill(s, self.cycle, end, axis)
            return
        if self.circle:
            self._arc(s, end, axis)
        self._move(s, end, axis, rapid=self.rapid)
        self.rapid, self.circle = False, None

    def _inside(self, s: AptStatement) -> None:
        if self.paths and not self.open:
            raise refusal(self.source, s, "a move outside a path", "Is TOOL PATH missing, or the file cut?")

    def _move(self, s: AptStatement, end: Vector, axis: Vector, *, rapid: bool) -> None:
        if self.unclosed and not rapid:
            before = f"no CYCLE/OFF before line {self.unclosed.line}, neither CYCLE nor FEDRAT after it"
            problem = f"{before}: whether a hole is drilled here is not known"
            raise refusal(self.source, s, problem, "Write CYCLE/OFF behind the last hole, and the CYCLE of this one.")
        feed = math.nan if rapid else self.feeds.now(s, self.cycle.rate if self.cycle else None)
        self.track.moves.extend((*end, *axis, feed))
        self.track.marks.extend((RAPID_MARK if rapid else CUT_MARK, self.tool.number, s.line))
        self.at, self.at_axis = end, axis

    def _axis(self, s: AptStatement, values: list[float]) -> Vector:
        """The tool axis: ``values``, or where there are none the one in force."""
        if values:
            norm = math.hypot(*values)
            if not abs(norm - 1.0) <= UNIT_TOLERANCE:
                raise refusal(self.source, s, f"the tool axis has length {norm:.6g}, 1 expected")
            self.axis, self.axis_stale = (values[0] / norm, values[1] / norm, values[2] / norm), False
        elif self.axis_stale:
            problem = "no tool axis, and the one from before belongs to another path or frame"
            raise refusal(self.source, s, problem, "Output i, j, k with the first GOTO of each path.")
        return self.axis

    def _start(self, s: AptStatement) -> None:
        self._no_cycle(s)
        if self.circle:
            raise refusal(self.source, s, "a start between a circle and its end")
        self.rapid = True
        self._goto(s)

    def _home(self, s: AptStatement) -> None:
        if not s.minor:
            raise refusal(self.source, s, "the place of home is not in the file", "Write GOHOME/x,y,z.")
        self._start(s)

    def _relative(self, s: AptStatement) -> None:
        """GODLTA/dx,dy,dz with or without i,j,k, or GODLTA/d along the tool axis."""
        self._no_cycle(s)
        if self.at is None:
            raise refusal(self.source, s, "a relative move, but no GOTO before it says from where")
        values = numbers(s, (1, 3, 6), self.source)
        axis, frame = self._axis(s, values[3:]), self.frames.way
        x, y, z = values[:3] if len(values) > 1 else (values[0] * a for a in axis)
        delta, axis = vector(frame, (x, y, z)), vector(frame, axis)
        self._go(s, (self.at[0] + delta[0], self.at[1] + delta[1], self.at[2] + delta[2]), axis)

    def _rapid(self, s: AptStatement) -> None:
        if s.minor:
            raise refusal(self.source, s, "only the plain RAPID (for the next GOTO) is read")
        self._no_cycle(s)
        if self.circle:
            raise refusal(self.source, self.circle[0], "RAPID between a circle and its end")
        self.rapid = True

    def _circle(self, s: AptStatement) -> None:
        self._no_cycle(s)
        if self.circle:
            raise refusal(self.source, self.circle[0], "no GOTO follows with the end of the circle")
        if self.rapid:
            raise refusal(self.source, s, "RAPID between a circle and its end")
        found = self.moved_arcs.read(s, fusion=self.fusion) if s.word == "MOVARC" else circle(s, self.source)
        if self.at is None:
            raise refusal(self.source, s, "a circle, but no GOTO before it says where it starts")
        self.circle = (s, found)

    def _arc(self, s: AptStatement, end: Vector, axis: Vector) -> None:
        if self.circle is None or self.at is None:
            return
        begun, found = self.circle
        if math.dist(axis, self.at_axis) > SAME_AXIS:
            raise refusal(self.source, begun, "the tool axis turns along a circle", "Output GOTO points.")
        arc = sweep(begun, arc=found, start=self.at, end=end, frame=self.frames.way, source=self.source)
        self.moved_arcs.note(begun, found, arc[2])
        self.track.arc(*arc)

    def _direction(self, s: AptStatement) -> None:
        self._no_cycle(s)
        if self.circle or self.rapid:
            raise refusal(self.source, s, "an arc between RAPID or CIRCLE and the GOTO that belongs to it")
        self.way = s, direction(s, self.source)

    def _tlon(self, s: AptStatement) -> None:
        """An arc with its end."""
        if self.way is None:
            raise refusal(self.source, s, "no INDIRV before it says which way round", "Output GOTO points.")
        if self.at is None:
            raise refusal(self.source, s, "an arc, but no GOTO before it says where it starts")
        self._inside(s)
        axis, frame = self._axis(s, []), self.frames.way
        if math.dist(vector(frame, axis), self.at_axis) > SAME_AXIS:
            raise refusal(self.source, s, "the tool axis turns along a circle", "Output GOTO points.")
        arc = tlon(s, way=self.way[1], axis=axis, start=self.at, frame=frame, source=self.source)
        self.track.arc(*arc[1:])
        self._move(s, arc.end, self.at_axis, rapid=False)
        self.way = None

    def _no_way(self) -> None:
        if self.way:
            raise refusal(self.source, self.way[0], "TLON,GOFWD does not follow", "Output GOTO points.")

    def _cycle(self, s: AptStatement) -> None:
        self._no_way()
        if self.circle or self.rapid:
            raise refusal(self.source, s, "a cycle between RAPID or CIRCLE and the GOTO that belongs to it")
        if s.minor in (["OFF"], ["INIT"], ["CLEAR"]):  # the last two of SolidWorks CAM, before the cycle itself
            self.cycle = self.unclosed = None
            return
        self.unclosed = None
        self.cycle = cycle(s, self.feeds, nx=self.paths, bottoms=self.fusion)
        self.before = self.at, self.at_axis
        self._event(s)

    def _drill(self, s: AptStatement, found: DrillCycle, point: Vector, axis: Vector) -> None:
        known = self.at is not None and math.dist(axis, self.at_axis) <= SAME_AXIS
        before = self.before[0] if math.dist(axis, self.before[1]) <= SAME_AXIS else None
        begun = len(self.track)
        found = at_hole(s, found, point=point, axis=axis, source=self.source)
        for step in hole(found, point=point, axis=axis, at=self.at if known else None, before=before):
            if self.at is None or math.dist(self.at, step.end) > SAME or not known:
                self._move(s, step.end, axis, rapid=step.rapid)
                known = True
            if step.bottom and found.dwell:
                self._event(AptStatement("DELAY", found.dwell, s.line))
        self.drilled += len(self.track) - begun
        if self.drilled > MOST_DRILLED:
            raise refusal(self.source, s, f"the cycles make more than {MOST_DRILLED} poses", "Check the step.")

    def _next_operation(self, s: AptStatement) -> None:
        """SolidWorks CAM leaves CYCLE/OFF out before some operations; each begins with TRNTYP/WORLD."""
        if self.cycle and self.frames.world:
            self.cycle, self.unclosed = None, s

    def _no_cycle(self, s: AptStatement) -> None:
        self._no_way()
        if self.cycle:
            problem = "a drilling cycle is in force: whether a hole is drilled here is not known"
            raise refusal(self.source, s, problem, "CYCLE/OFF is missing before this line?")

    def _event(self, s: AptStatement) -> None:
        commands = commands_of(s, self.track.spindle, self.tool.number)
        self.track.event(comment_word(str(s)), s.line, *commands)
