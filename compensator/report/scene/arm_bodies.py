"""The arm as bodies: the shapes of its links, capsules along those whose shape is not known."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from compensator.report.scene.drawn_body import DrawnBody
from compensator.report.scene.shape_mesh import shape_mesh
from compensator.report.scene.solids import SolidMesh, capsule, joined
from compensator.scene.body import Body
from stiffness.robot.robot import Robot

Floats = npt.NDArray[np.float64]

BASE_COLOUR, LINK_COLOUR, WRIST_COLOUR = "#4b545c", "#e08a2c", "#8a949c"
THICK, THIN = 0.052, 0.016  # radius of the first and of the last link, of the reach


def arm_bodies(robot: Robot, known: Sequence[Body]) -> list[DrawnBody]:
    """The links; ``known``: bodies of a job, of which those of links are taken. A link without any gets capsules."""
    bodies = []
    for body in known:
        if body.role == "link":
            k = body.carrier if isinstance(body.carrier, int) else 0
            mesh = shape_mesh(body.shape).moved(body.placement.rotation, body.placement.origin)
            bodies.append(DrawnBody(mesh, k, "arm", _colour(robot, k)))
    there = {body.frame for body in bodies}
    return [*bodies, *(body for body in capsule_arm(robot) if body.frame not in there)]


def _colour(robot: Robot, k: int) -> str:
    return BASE_COLOUR if k == 0 else LINK_COLOUR if k <= robot.n // 2 else WRIST_COLOUR


def capsule_arm(robot: Robot) -> list[DrawnBody]:
    """Links 0..n in their own axes: along its joint's axis first, then across to the next joint."""
    reach = arm_length(robot)
    bodies = []
    for k in range(robot.n + 1):
        share = k / max(robot.n, 1)
        radius = reach * (THICK + (THIN - THICK) * share)
        bodies.append(DrawnBody(_link(robot, k, radius), k, "arm", _colour(robot, k)))
    return bodies


def arm_length(robot: Robot) -> float:
    """m, of the links stretched out from the second joint."""
    links = np.array([ends(robot, k) for k in range(1, robot.n + 1)])
    return max(float(np.linalg.norm(links[:, 1] - links[:, 0], axis=1).sum()), 0.1)


def ends(robot: Robot, k: int) -> tuple[Floats, Floats]:
    """Where link ``k`` begins and ends: its joint and the next one (the tip), in its axes, m."""
    inner, outer = np.zeros(3), np.zeros(3)
    if k > 0:
        after = robot.after[k - 1]
        inner = -after[:3, :3].T @ after[:3, 3]
    if k < robot.n:
        outer = robot.before[k][:3, 3]
    return inner, outer


def _link(robot: Robot, k: int, radius: float) -> SolidMesh:
    inner, outer = ends(robot, k)
    axis = np.array([0.0, 0.0, 1.0]) if k == 0 else robot.after[k - 1][:3, :3].T @ robot.axis[k - 1]
    elbow = inner + axis * ((outer - inner) @ axis)
    parts = [capsule(a, b, radius) for a, b in ((inner, elbow), (elbow, outer)) if np.linalg.norm(b - a) > 0.3 * radius]
    drum = 0.5 * radius * axis
    return joined([*parts, capsule(inner - drum, inner + drum, radius)])
