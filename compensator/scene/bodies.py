"""Bodies of a job: links, tools, stock, part and what the cell puts around them, for collisions and pictures."""

from __future__ import annotations

from dataclasses import dataclass

from compensator.cell.job import Job
from compensator.cell.placement import Placement
from compensator.scene.body import BASE, WORKOBJECT, WORLD, Body, Carrier
from compensator.scene.link_bodies import link_bodies
from compensator.scene.stock_bodies import stock_bodies
from compensator.scene.table_shape import table_shape
from compensator.scene.tool_bodies import tool_bodies
from stiffness.robot.robot import Robot

CARRIERS: dict[str, Carrier] = {"base": WORLD, "workobject": WORKOBJECT, "robot": BASE}


@dataclass(frozen=True)
class Bodies:
    """All bodies of a job.

    Attributes:
        missing: what of the robot has no shape, in words; source: where the shapes that it has come from.
    """

    all: tuple[Body, ...]
    missing: str = ""
    source: str = ""


def bodies_of(job: Job) -> Bodies:
    """The bodies of a job.

    Raises:
        CellError: a mesh is refused.
    """
    return bodies_at(job.arm.robot, job.placement)


def bodies_at(robot: Robot, placement: Placement) -> Bodies:
    """The bodies of a robot at a placement.

    Raises:
        CellError: a mesh is refused.
    """
    around = placement.surroundings
    links = link_bodies(robot, [around.folder / p for p in around.settings.packages])
    scene = []
    for entry in around.scene:
        shape, inside = table_shape(entry, around.folder)
        frame, carrier = entry.placed().then(inside), CARRIERS[entry.frame]
        scene.append(Body(entry.name, carrier, shape, frame, role="scene", sacrificial=entry.sacrificial))
    everything = (*links.bodies, *tool_bodies(placement), *stock_bodies(placement), *scene)
    return Bodies(everything, links.missing, robot.shapes.source)
