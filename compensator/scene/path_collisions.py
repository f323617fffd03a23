"""Collisions along a path: what touches, what comes near, and what is not looked at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.cell.external_axes import moved_workobject, rail_shift
from compensator.cell.job import Job
from compensator.errors import PathError
from compensator.path.pose_text import place
from compensator.scene.bodies import Bodies, bodies_of
from compensator.scene.body import WORKOBJECT, WORLD, Body
from compensator.scene.collider import Collider
from compensator.scene.pairs import Pair, pairs_of
from compensator.scene.path_walk import Approach, ArmPath, PathWalk
from toolpaths.finding import ERROR, NOTE, WARNING, Finding
from toolpaths.frame import Frame
from toolpaths.toolpath import CUT, Toolpath

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

NEAREST = 5  # pairs whose distance is measured even where they do not come near
ALONG = np.cos(np.radians(8.0))  # a rapid nearer to the tool axis draws the cutter out of what it has cut


@dataclass(frozen=True, repr=False)
class PathCollisions:
    """What was found.

    Attributes:
        bodies: all of them. toolpath: whose poses are meant. approaches: of every pair that was looked at.
        findings: errors, warnings, and what is not looked at. checked: False where the cell asks for no check.
    """

    bodies: Bodies
    toolpath: Toolpath
    approaches: tuple[Approach, ...]
    findings: tuple[Finding, ...]
    checked: bool = True

    def __repr__(self) -> str:
        return f"PathCollisions({len(self.approaches)} pairs, {len(self.contacts)} touch)"

    @property
    def contacts(self) -> tuple[Approach, ...]:
        """Pairs that touch."""
        return tuple(a for a in self.approaches if a.contacts)

    def names(self, approach: Approach) -> tuple[str, str]:
        """Of the bodies of a pair, the one on the arm first."""
        all_ = self.bodies.all
        return all_[approach.pair.outer].name, all_[approach.pair.inner].name

    def refuses(self, approach: Approach) -> bool:
        """Whether a contact is an error."""
        return is_certain(self.bodies.all, approach.pair)

    def refuse_contacts(self) -> None:
        """Refuse a path on which something touches.

        Raises:
            PathError: names the first pose, its line and the two bodies, and how many more there are.
        """
        errors = [f for f in self.findings if f.level == ERROR]
        if errors:
            listed = "".join(f"\n  {f}" for f in errors)
            raise PathError(f"{self.toolpath.source}: the path collides:{listed}")


def collisions_along(job: Job, toolpath: Toolpath, q: Floats, bodies: Bodies | None = None) -> PathCollisions:
    """Look for collisions of an arm along a path.

    Args:
        q: (N, n) rad, the angles that are commanded. bodies: of the job; None: they are read.

    Raises:
        CellError: a mesh is refused, or a body that is declared as neighbour is not there.
    """
    placement = job.placement
    settings = placement.surroundings.settings
    if not settings.check:
        what = "collisions are not looked for: the cell says [collisions] check = false"
        return PathCollisions(Bodies(()), toolpath, (), (Finding(NOTE, placement.source, what),), checked=False)
    bodies, way = bodies or bodies_of(job), arm_path(job, toolpath, q)
    pairs = pairs_of(
        bodies.all, job.arm.robot, settings, placement.source, on_rail=WORLD in way.moving, on_table=way.table_turns
    )
    collider = Collider(job.arm.robot, bodies.all, pairs)
    walk = PathWalk(collider, way, margin=settings.margin / 1e3, step=settings.step / 1e3)
    active = [(pair, _active(pair, toolpath)) for pair in collider.pairs]
    found = [walk.approach(pair, moves) for pair, moves in active if moves.any()]
    order = sorted(range(len(found)), key=lambda k: found[k].bound)
    measured = {k for n, k in enumerate(order) if n < NEAREST or found[k].near}
    found = [walk.measured(a) if k in measured else a for k, a in enumerate(found)]
    result = PathCollisions(bodies, toolpath, tuple(found), ())
    findings = (*_meetings(result, settings.margin), *_not_checked(job, bodies))
    return PathCollisions(bodies, toolpath, result.approaches, findings)


def is_certain(bodies: Sequence[Body], pair: Pair) -> bool:
    """Whether a contact is one: where arm and tool touch each other in rough outlines, their radii decide."""
    inner, outer = bodies[pair.inner], bodies[pair.outer]
    return not (inner.on_arm and (inner.approximate or outer.approximate))


def collider_of(job: Job, *, on_rail: bool = False, on_table: bool = False) -> Collider:
    """Ready to be asked at which postures of a job there is a contact that is an error.

    Args:
        on_rail: a rail of the cell moves the base. on_table: a table turns the part along the path.

    Raises:
        CellError: as ``collisions_along``.
    """
    bodies, robot, placement = bodies_of(job).all, job.arm.robot, job.placement
    settings = placement.surroundings.settings
    pairs = pairs_of(bodies, robot, settings, placement.source, on_rail=on_rail, on_table=on_table)
    return Collider(robot, bodies, [p for p in pairs if is_certain(bodies, p)])


def arm_path(job: Job, toolpath: Toolpath, q: Floats) -> ArmPath:
    """The way of the arm, and of what rail and table move."""
    placement, moving = job.placement, dict[str, Frame]()
    moved, shift = moved_workobject(placement, toolpath), rail_shift(placement, toolpath)
    if moved is not None:
        moving[WORKOBJECT] = placement.workobject.then(moved)
    if shift is not None:
        moving[WORLD] = Frame(np.broadcast_to(np.eye(3), (len(toolpath), 3, 3)), shift)
    return ArmPath(q, placement.workobject, moving)


def _active(pair: Pair, toolpath: Toolpath) -> Bools:
    """(N,) the moves on which a pair counts."""
    active = np.ones(len(toolpath), dtype=np.bool_)
    if pair.tool is not None:
        active &= toolpath.tool == pair.tool
    if pair.cut:
        step = np.diff(toolpath.on_part, axis=0, prepend=toolpath.on_part[:1])
        length = np.linalg.norm(step, axis=1)
        out = np.sum(step * toolpath.axis_on_part, axis=1) >= ALONG * length
        active &= (toolpath.kind != CUT) & ~out
    return active


def _meetings(found: PathCollisions, margin: float) -> list[Finding]:
    """An error for every pair that touches, a warning for every one that comes near."""
    out = []
    for a in found.approaches:
        first, second = found.names(a)
        outlines = [found.bodies.all[k].approximate for k in (a.pair.inner, a.pair.outer)]
        rough = " (rough outlines)" if any(outlines) else ""
        if a.contacts:
            level = ERROR if found.refuses(a) else WARNING
            what = f"{first} and {second} touch{rough}"
            remedy = "Move the part, turn or tilt the tool, or choose another [start]; where they may touch, say so in "
            remedy += "[collisions] neighbours"
            places = tuple(place(found.toolpath, k) for k in a.contacts)
            several = places if len(places) > 1 else ()
            out.append(Finding(level, places[0], what, remedy, count=len(places), places=several))
        elif a.near and a.least is not None:
            what = f"{first} comes within {a.least[0] * 1e3:.1f} mm of {second}{rough}; the margin is {margin:g} mm"
            out.append(Finding(WARNING, place(found.toolpath, a.least[1]), what, "See [collisions] margin"))
    return out


def _not_checked(job: Job, bodies: Bodies) -> list[Finding]:
    """What has no shape, or only a rough one; told in full where the cell has a scene."""
    robot, around = job.arm.robot, job.placement.surroundings
    out = []
    if around.scene and any(b.approximate and b.role == "link" for b in bodies.all):
        what = f"its links are rough capsules: {robot.shapes.source}"
        out.append(Finding(NOTE, robot.name, what, "A URDF with meshes is exact"))
    lines = [b.name for b in bodies.all if b.approximate and b.role == "cutter"]
    if around.scene and lines:
        what = "it is taken as a line from the flange to the TCP"
        out.append(Finding(NOTE, f"tool {', '.join(lines)}", what, "Say what it looks like in [[tool.bodies]]"))
    if not bodies.missing:
        return out
    level = WARNING if around.scene else NOTE
    has = any(b.role == "link" for b in bodies.all)
    of = f"not all links of {robot.name} have a shape: {bodies.missing}"
    what = of if has else f"{robot.name} has no shapes: {bodies.missing}; collisions of its links are not looked for"
    return [*out, Finding(level, robot.name, what, "See docs/collisions.md")]
