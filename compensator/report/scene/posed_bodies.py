"""Bodies at one pose of a path, in the base: for pictures that do not move."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.cell.external_axes import rail_shift, workobject_along
from compensator.report.scene.drawn_body import FLOOR, WORK, Kind
from compensator.report.scene.scene import job_bodies, with_tcp
from compensator.report.scene.work_bodies import work_bodies
from compensator.solve.compensation import Compensation
from compensator.solve.nominal_state import nominal_state
from toolpaths.frame import Frame

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, repr=False, eq=False)
class Posed:
    """A body where it stands: ``vertices`` (V, 3) m in the base, ``faces`` (F, 3)."""

    kind: Kind
    vertices: Floats
    faces: npt.NDArray[np.int64]
    colour: str
    opacity: float

    def __repr__(self) -> str:
        return f"Posed({self.kind}, {len(self.faces)} faces)"


def worst_pose(c: Compensation) -> int:
    """The cutting pose with the largest error, as the file stands."""
    return int(np.argmax(np.where(c.cutting, np.linalg.norm(c.error_before, axis=1), -1.0)))


def posed_bodies(c: Compensation) -> tuple[list[Posed], Floats]:
    """Arm, tool and what stands around at the worst pose, as large as they are; and the path there, (N, 3) m.

    The stock only where nothing of it was cut.
    """
    pose = np.array([worst_pose(c)])
    part, state = c.path.toolpath.take(pose), nominal_state(c).middle[pose]
    links, _ = with_tcp(c.job.arm.tools, part, *c.job.arm.links(part, c.path.q[pose], c.wrench[pose], state))
    work, shift = workobject_along(c.job.placement, part), rail_shift(c.job.placement, part)
    here = work.take(0) if work.origin.ndim > 1 else work
    frames = {k: Frame(links.rotation[0, k], links.origin[0, k]) for k in range(links.origin.shape[1])}
    frames |= {WORK: here, FLOOR: Frame(np.eye(3), np.zeros(3) if shift is None else shift[0])}
    bodies = [*job_bodies(c.job), *work_bodies(c.job.placement, c.load)]
    kinds, tool = {body.kind for body in bodies}, int(part.tool[0])
    shown = [b for b in bodies if b.tool in (None, tool) and not (b.kind == "stock" and "left" in kinds)]
    posed = [
        Posed(b.kind, frames[b.frame].at(b.mesh.vertices), b.mesh.faces, colour=b.colour, opacity=b.opacity)
        for b in shown
    ]
    along = workobject_along(c.job.placement, c.path.toolpath)
    return posed, here.at(c.path.tcp.relative_to(along).origin)
