"""The scene of a path: arm, tool, work and path as numbers that a page draws; the page holds no kinematics.

At every station a link has a 3 x 4 placement ``N`` (nominal command, rigid arm) and what deflection adds to it: ``B``
before, ``A`` with the program. The page shows ``N + f B`` for the factor ``f`` that the reader drags: linear in
the small displacements, so that links stay together, and exact at f = 1.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from compensator.cell.external_axes import rail_shift, workobject_along
from compensator.cell.job import Job
from compensator.path.tool_set import ToolSet
from compensator.report.json.text import Report
from compensator.report.scene.arm_bodies import arm_bodies, arm_length
from compensator.report.scene.drawn_body import DrawnBody
from compensator.report.scene.flanks import lamps
from compensator.report.scene.jumps import finding_poses
from compensator.report.scene.moments import Moments
from compensator.report.scene.packing import packed
from compensator.report.scene.path_colours import PathColour, path_colours
from compensator.report.scene.stations import MOST_POINTS, nearest, stations
from compensator.report.scene.tool_bodies import tool_bodies
from compensator.report.scene.work_bodies import fixture, work_bodies
from compensator.scene.bodies import bodies_of
from compensator.solve.assessment import Assessment
from compensator.solve.compensation import Compensation
from compensator.solve.nominal_state import nominal_state
from compensator.solve.turnarounds import reversals
from stiffness.memory.preload import PreloadState
from stiffness.robot.robot import Robot
from toolpaths.frame import Frame
from toolpaths.toolpath import CUT, Toolpath

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]
Scene = dict[str, Any]

SCHEMA = "scene/1"
SHOWN = 0.06  # of the arm's length: how large the largest deflection is drawn at first
STEPS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000)


def path_scene(
    c: Compensation,
    report: Report,
    after: Floats | None = None,
    *,
    judged: Assessment | None = None,
    texts: Mapping[int, str] | None = None,
) -> Scene:
    """The scene of a result.

    Args:
        after: (N,) m, error with the program as written; None: nothing is corrected.
        judged: for the band. texts: line of the source -> what stands there.
    """
    toolpath, robot = c.path.toolpath, c.job.arm.robot
    size = np.linalg.norm(c.error_before, axis=1)
    found = list(finding_poses(toolpath, report))
    worst = int(np.argmax(np.where(c.cutting, size, -1.0)))
    told = [worst, *(pose for _, _, pose in found if pose is not None)]
    wanted = [*told, *(t.pose for t in reversals(c, c.command.q))]
    rows = stations(len(c), wanted)
    before = nominal_state(c)
    points = np.union1d(stations(len(c), wanted, MOST_POINTS), rows)
    bodies = [*job_bodies(c.job), *work_bodies(c.job.placement, c.load, Moments(rows, tuple(told)))]
    return {
        "schema": SCHEMA,
        "robot": robot.name,
        "source": toolpath.source,
        "links": robot.n + 2,
        "reach": arm_length(robot),
        "factor": first_factor(float(size.max(initial=0.0)), arm_length(robot)),
        "worst": nearest(rows, worst),
        "bodies": [body.as_dict() for body in bodies],
        "stations": _stations(c, rows, after, before),
        "joints": _joints(c, rows, after is not None, before),
        "path": _path(c, points, rows, list(path_colours(c, after, judged))),
        "findings": [
            {"level": level, "text": text, "station": None if pose is None else nearest(rows, pose)}
            for level, text, pose in found
        ],
        "texts": _texts(toolpath, rows, texts or {}),
    }


def job_bodies(job: Job) -> list[DrawnBody]:
    """Arm, tools, and what the cell puts around them."""
    robot, known = job.arm.robot, bodies_of(job).all
    around = [fixture(body) for body in known if body.role == "scene"]
    return [*arm_bodies(robot, known), *tool_bodies(job.placement, known, robot.n), *around]


def first_factor(deflection: float, length: float) -> int:
    """The factor at which a deflection, m, is seen on an arm of this length, m."""
    return max((s for s in STEPS if s * deflection <= SHOWN * length), default=1)


def _stations(c: Compensation, rows: Index, after: Floats | None, before: PreloadState) -> Scene:
    """``before``: states under the nominal commands."""
    part = c.path.toolpath.take(rows)
    wrench = c.wrench[rows]
    arms = c.job.arm.links(part, c.path.q[rows], wrench, before.middle[rows])
    nominal, deflected = with_tcp(c.job.arm.tools, part, *arms)
    out: Scene = {
        "count": len(rows),
        "pose": rows.tolist(),
        "line": part.line.tolist(),
        "cut": (part.kind == CUT).astype(int).tolist(),
        "tool": part.tool.tolist(),
        "feed": [None if np.isnan(f) else round(float(f) * 60e3, 3) for f in part.feed],
        "nominal": packed(rows34(nominal)),
        "before": packed(rows34(deflected) - rows34(nominal)),
        "force": packed(wrench[:, :3]),
        "deflection": packed(c.error_before[rows]),
        **_work(c, part),
    }
    if after is not None:
        arms = c.job.arm.links(part, c.command.q[rows], wrench, c.state.middle[rows])
        _, left = with_tcp(c.job.arm.tools, part, *arms)
        out |= {
            "after": packed(rows34(left) - rows34(nominal)),
            "correction": packed(c.correction[rows]),
            "remaining": packed(after[rows]),
        }
    return out


def with_tcp(tools: ToolSet, part: Toolpath, *arms: Frame) -> list[Frame]:
    """Links 0..n (N, n + 1) and the TCP as one more."""
    called = [tools.tool(int(k)) for k in part.tool]
    tcp = Frame(np.array([t.rotation for t in called]), np.array([t.position for t in called]))
    out = []
    for arm in arms:
        tip = Frame(arm.rotation[:, -1], arm.origin[:, -1]).then(tcp)
        rotation = np.concatenate([arm.rotation, tip.rotation[:, None]], axis=1)
        out.append(Frame(rotation, np.concatenate([arm.origin, tip.origin[:, None]], axis=1)))
    return out


def rows34(frames: Frame) -> Floats:
    """(..., 3, 4)."""
    return np.asarray(frames.matrix[..., :3, :])


def _work(c: Compensation, part: Toolpath) -> Scene:
    """Work object and floor: one placement, or one per station where rail or table move them."""
    work, shift = workobject_along(c.job.placement, part), rail_shift(c.job.placement, part)
    floor = {} if shift is None else {"floor": packed(shift)}
    return {"work": packed(rows34(work)), "moves": work.origin.ndim > 1, **floor}


def _joints(c: Compensation, rows: Index, corrected: bool, before: PreloadState) -> Scene:
    """Commands against limits, and the lamps of what joints remember."""
    out: Scene = {
        "limits": limits(c.job.arm.robot),
        "q": packed(np.degrees(c.path.q[rows])),
        "lamps": packed(lamps(c.job.arm, before)[rows], np.int8),
    }
    if corrected:
        out |= {
            "commanded": packed(np.degrees(c.command.q[rows])),
            "lamps_after": packed(lamps(c.job.arm, c.state)[rows], np.int8),
        }
    return out


def limits(robot: Robot) -> list[list[float | None]]:
    """Lower and upper limit of every joint, deg; None: it has none."""
    ends = np.degrees(np.column_stack([robot.lower, robot.upper]))
    return [[round(float(v), 3) if np.isfinite(v) else None for v in pair] for pair in ends]


def _path(c: Compensation, points: Index, rows: Index, colours: list[PathColour]) -> Scene:
    """The path in the work object, and how far off the tool is there, in its axes."""
    toolpath = c.path.toolpath
    work = workobject_along(c.job.placement, toolpath.take(points))
    error = c.error_before[points]
    inward = np.einsum("...ji,...j->...i", np.broadcast_to(work.rotation, (len(points), 3, 3)), error)
    on_part = c.path.tcp.take(points).relative_to(work).origin
    return {
        "count": len(points),
        "position": packed(on_part),
        "error": packed(inward),
        "cut": packed(toolpath.kind[points] == CUT, np.uint8),
        "station": packed(np.searchsorted(rows, points, side="right") - 1, np.uint32),
        "colours": [
            {"key": k.key, "label": k.label, "joints": k.joints, "value": packed(k.value[points])} for k in colours
        ],
    }


def _texts(toolpath: Toolpath, rows: Index, texts: Mapping[int, str]) -> dict[str, str]:
    """Line -> what stands there, of the lines that the stations come from; of a program of several files none."""
    if toolpath.file is not None:
        return {}
    lines = sorted({int(line) for line in toolpath.line[rows]})
    return {str(line): texts[line] for line in lines if line in texts}
