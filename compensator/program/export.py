"""A compensation as a new robot program."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from compensator.cell.external_axes import (
    axes_in_program,
    external_findings,
    moved_workobject,
    workobject_in_program,
)
from compensator.cell.placement import Placement
from compensator.path.pose_text import place
from compensator.path.tool_set import ONE_TOOL
from compensator.program.machine_orders import orders
from compensator.program.maker import MadeProgram, ProgramMaker
from compensator.program.tool_changes import change_findings
from compensator.solve.compensation import Compensation
from compensator.solve.verify import Verified, verify
from toolpaths.columns import MadeColumn, blocks
from toolpaths.files import write_program
from toolpaths.finding import ERROR, WARNING, Finding, refuse_errors
from toolpaths.frame import Frame
from toolpaths.languages.table import Language
from toolpaths.tool_frame import ToolFrame
from toolpaths.toolpath import CUT, Toolpath
from toolpaths.writing.checks import without_axes
from toolpaths.writing.part_carrier import PartCarrier, carrier_findings
from toolpaths.writing.program import Program

MM_MIN = 1.0 / 60000.0  # m/s


@dataclass(frozen=True)
class Export(ProgramMaker):
    """A program made of nothing but the commands.

    Attributes:
        external: what is lost of the external axes of the source.
        stamp: what the head of the program tells.
    """

    language: Language
    external: tuple[Finding, ...] = ()
    stamp: tuple[str, ...] = ()
    in_place = False

    @classmethod
    def of(cls, placement: Placement, source: Toolpath, language: Language, stamp: tuple[str, ...]) -> Export:
        """For a toolpath as it was read."""
        return cls(language, external_findings(placement, source, language), stamp)

    def check(self, placement: Placement, toolpath: Toolpath, program: Path) -> None:
        orders(toolpath, placement.program.events, placement.source)
        refuse_lost_axes(placement, self.language, program)
        given = placement.program.name
        found = self.language.writer.name_findings(given or program.stem, program, len(toolpath))
        wrong = [replace(f, level=ERROR) if f.place == "name" and given else f for f in found]
        refuse_errors(str(program), [f for f in wrong if f.level == ERROR])

    def write(self, c: Compensation, staged: Path) -> MadeProgram:
        program = replace(program_of(c, name=staged.stem), stamp=self.stamp)
        program = replace(program, findings=(*program.findings, *self.external))
        written = write_program(program, staged, self.language.name, staged=True)
        return MadeProgram(written.files, written.findings, c)

    def verify(self, made: MadeProgram, shown: Path) -> Verified:
        return verify(made.result, made.files[0], self.language.name)


def refuse_lost_axes(placement: Placement, language: Language, program: Path) -> None:
    """Refuse to choose places of axes that a language has no words for, or of a table that may turn on the way without
    what the language tells of it.

    Raises:
        WriteError: names the axes and the languages that have them.
    """
    if not language.external_axes:
        free = [name for name, axis in placement.external.items() if axis.free]
        refuse_errors(str(program), without_axes(free, language.name))
    for name, axis in placement.external.items():
        if axis.turns:
            found = carrier_findings(_carrier(placement, name), language.part_unit, language.name)
            refuse_errors(str(program), [*found])


def _carrier(placement: Placement, name: str) -> PartCarrier:
    axis = placement.external[name]
    direction, center = np.array(axis.direction), np.array(axis.center) / 1e3
    return PartCarrier(name, axis.unit, axis.unit_frame(), direction=direction, center=center)


def program_poses(c: Compensation, *, corrected: bool = True) -> Frame:
    """(N) TCP in the work object: what ``program_of`` writes."""
    return _in_work(c.job.placement, c.path.toolpath, c.printed if corrected else c.path.tcp)


def program_of(
    c: Compensation, *, corrected: bool = True, name: str = "", poses: Frame | None = None
) -> Program:
    """The commands of a path in the work object, with everything a controller has to know.

    Args:
        name: of the program, where the cell gives none.
        corrected: False writes the nominal poses, as ``preview`` shows them.
        poses: (N) that stand in the program instead; their rotations are made where they are asked for.
    """
    arm, placement, path, inverse = c.job.arm, c.job.placement, c.path, c.job.planner.inverse
    toolpath = path.toolpath
    joints = c.command.q if corrected else path.q
    nominal = _in_work(placement, toolpath, path.tcp)
    made = _made(program_poses(c, corrected=corrected)) if poses is None else poses
    table = None if toolpath.ways is None else toolpath.ways.table
    feed, findings = _feed(placement, toolpath)
    ordered = orders(toolpath, placement.program.events, placement.source)
    return Program(
        name=placement.program.name or name,
        position=made.origin,
        rotation=made.rotation if poses is None else MadeColumn(len(c), lambda rows: made.take(rows).rotation),
        joints=joints,
        feed=feed,
        findings=(*findings, *change_findings(c, joints, ordered)),
        kind=toolpath.kind,
        tool=np.full_like(toolpath.tool, ONE_TOOL) if arm.tools.any_number else toolpath.tool,
        line=toolpath.line,
        tools={
            k: ToolFrame(t.name, Frame(t.rotation, t.position), t.mass or None, t.com if t.mass else None)
            for k, t in arm.tools.by_number.items()
        },
        workobject=workobject_in_program(placement, toolpath),
        external=axes_in_program(placement, toolpath),
        carrier=None if table is None else _carrier(placement, table.name),
        rapid_speed=placement.program.rapid_feed * MM_MIN,
        configuration=inverse.inverse.configuration(joints).astype(np.int32) if inverse.labelled else None,
        start_joints=placement.start,
        comments=tuple((e.pose, e.word) for e in toolpath.events if e.pose < len(toolpath) or e.commands),
        orders=ordered,
        robot=arm.robot.name,
        source=toolpath.source,
        nominal_position=MadeColumn(len(c), lambda rows: nominal.take(rows).origin),
        nominal_rotation=MadeColumn(len(c), lambda rows: nominal.take(rows).rotation),
        nominal_joints=path.q,
        wrench=c.load.unchanged,
        deflection=_deflection(c, corrected=corrected),
    )


def _in_work(placement: Placement, toolpath: Toolpath, tcp: Frame) -> Frame:
    """TCP frames (N) in the base, as a program has them: in the work object, with the external axes where they are."""
    to_work = Frame.of(np.asarray(np.linalg.inv(placement.workobject.matrix), dtype=np.float64))
    on_axes = moved_workobject(placement, toolpath)
    if on_axes is None:
        return tcp.mapped(lambda some, rows: to_work.then(some))
    return tcp.mapped(lambda some, rows: to_work.then(some).relative_to(on_axes.take(rows)))


def _made(frames: Frame) -> Frame:
    """N frames, all made in one go."""
    rotation, origin = np.empty((frames.count, 3, 3)), np.empty((frames.count, 3))
    for b in blocks(frames.count):
        some = frames.take(b)
        rotation[b], origin[b] = some.rotation, some.origin
    return Frame(rotation, origin)


def _deflection(c: Compensation, *, corrected: bool) -> MadeColumn:
    """(N, 3) m predicted at the command, base axes."""
    tcp, target, before, printed = c.path.tcp, c.target, c.before, c.printed
    if corrected:
        return MadeColumn(len(c), lambda rows: target.take(rows).origin - printed.take(rows).origin)
    return MadeColumn(len(c), lambda rows: before[rows] - tcp.take(rows).origin)


def _feed(placement: Placement, toolpath: Toolpath) -> tuple[npt.NDArray[np.float64], tuple[Finding, ...]]:
    feed = np.where(toolpath.kind == CUT, toolpath.feed, np.nan)
    missing = (toolpath.kind == CUT) & ~(feed > 0)
    if not missing.any():
        return feed, ()
    default = placement.program.default_feed
    feed[missing] = default * MM_MIN
    what = f"no feed in the toolpath at {int(missing.sum())} cutting poses: {default:g} mm/min taken"
    remedy = "Give feeds in the toolpath, or program.default_feed in the cell"
    return feed, (Finding(WARNING, place(toolpath, int(np.argmax(missing))), what, remedy),)
