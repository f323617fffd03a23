"""A session that is still to be measured: session.toml ready to fill, samples.csv with empty readings."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from stiffness.model.model import ComplianceModel
from stiffness.planning.plan import Plan
from stiffness.session.file import Reflector
from stiffness.statics.tool import Tool
from toolpaths.rotation import rpy_from_matrix

Floats = npt.NDArray[np.float64]
MM = 1e3
WRENCH = ("fx", "fy", "fz", "mx", "my", "mz")


def postures_of(plan: Plan) -> Floats:
    """(S, n) rad of every set-up, in their order."""
    return np.asarray(plan.postures.q[plan.candidates.posture[plan.chosen]])


def samples_text(plan: Plan) -> str:
    """A row per set-up, state and reflector; x, y, z are empty, the wrench is the planned one."""
    pool, n = plan.candidates, plan.postures.q.shape[1]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    joints = [f"q{k + 1}" for k in range(n)]
    approached = [f"approach{k + 1}" for k in range(n)]
    writer.writerow(["setup", "state", *joints, *approached, "reflector", "x", "y", "z", *WRENCH])
    for setup, c in enumerate(plan.chosen, 1):
        q = [f"{v + 0.0:.4f}" for v in np.degrees(plan.postures.q[pool.posture[c]])]
        approach = plan.postures.approach[pool.posture[c]].astype(int).tolist()
        for state, share in enumerate(plan.loading.steps):
            load = [f"{v + 0.0:.4f}" for v in pool.wrench[c] * share]
            for reflector in plan.design.reflectors:
                writer.writerow([setup, state, *q, *approach, reflector.name, "", "", "", *load])
    return text.getvalue()


def session_text(plan: Plan, tool: Tool, model: ComplianceModel, *, robot: str, samples: str) -> str:
    """session.toml with the reflectors, the tool and the instruments that the plan was made for.

    Args:
        robot, samples: as the file names them.
    """
    mass = tool.mass or None
    seen = plan.loading.instruments
    lines = [
        "# Written by `compensator plan`: every key is in docs/sessions.md. To do before `compensator identify`:",
        f"# 1. {samples}: put in x, y, z as the tracker reads them, row by row; strike out rows that were not read.",
        "# 2. Its fx ... mz are the PLANNED loads on the robot: overwrite them with what the sensor reads.",
        "# 3. Here: where the reflectors really sit, what your instruments do, whether the tracker is registered.",
        'schema = "measurement-session/1"',
        f"robot = {_quoted(robot)}",
        f"samples = {_quoted(samples)}",
        *(f"{key} = {_quoted(value)}" for key, value in (("base", model.base), ("tip", model.tip)) if value),
        f'gravity = "{model.gravity}"',
        "registered = false  # true: x, y, z are in the base of the robot, not in the frame of the tracker",
        "",
        "[units]",
        'length = "mm"',
        'angle = "deg"',
        "",
        "[wrench]",
        'frame = "base"',
        'about = "tcp"',
        "",
        "[tool]",
        f"xyz = {_listed(tool.position * MM)}",
        f"rpy = {_listed(np.degrees(rpy_from_matrix(tool.rotation)))}",
        *([] if mass is None else [f"mass = {mass:g}"]),
        *([] if mass is None or tool.com is None else [f"com = {_listed(tool.com * MM)}"]),
        "",
        *(line for r in plan.design.reflectors for line in _reflector(r)),
        "[instruments]  # standard deviation of a single reading",
        f"tracker = {seen.tracker * MM:g}  # mm per axis",
        f"force = {seen.force:g}  # N per axis",
        f"torque = {seen.torque:g}  # N*m per axis",
        "",
    ]
    return "\n".join(lines)


def stop_words(plan: Plan) -> tuple[str, ...]:
    """What the robot shows at every set-up."""
    pool = plan.candidates
    out = []
    for setup, c in enumerate(plan.chosen, 1):
        fx, fy, fz = (f"{v + 0.0:.0f}" for v in pool.wrench[c][:3] * plan.loading.steps.max())
        out.append(f"set-up {setup}: unloaded, then {fx} {fy} {fz} N")
    return tuple(out)


def _reflector(r: Reflector) -> Sequence[str]:
    return (
        f"[reflectors.{_quoted(r.name)}]",
        f"link = {r.link}",
        f"position = {_listed(r.position * MM)}",
        f"exact = {'true' if r.exact else 'false'}",
        "",
    )


def _listed(values: Floats) -> str:
    return str([round(float(v), 6) + 0.0 for v in values])


def _quoted(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
