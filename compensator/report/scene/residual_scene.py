"""The scene of a measurement: the arm as it stood in every set-up, an arrow per reading, before and after."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.report.scene.arm_bodies import arm_bodies, arm_length
from compensator.report.scene.drawn_body import DrawnBody
from compensator.report.scene.flanks import WITHOUT
from compensator.report.scene.packing import packed
from compensator.report.scene.scene import SCHEMA, Scene, first_factor, limits, rows34
from compensator.report.scene.solids import capsule
from compensator.scene.link_bodies import link_bodies
from stiffness.robot.robot import Robot
from toolpaths.frame import Frame

Floats = npt.NDArray[np.float64]

MOST_SETUPS = 400
SPHERE, REFLECTOR_COLOUR = 0.008, "#1c2126"  # radius of a reflector, of the arm's length
MM = 1e3


@dataclass(frozen=True, repr=False, eq=False)
class ArmReadings:
    """Readings of one session, in the base.

    Attributes:
        q: (N, n) rad. links: (N, n + 1) of the undeflected arm.
        setup, reflector: (N,) numbers. link: (N,) that the reflector is on.
        at: (N, 3) m, where the reflector is. before, after: (N, 3) m, residuals.
        sound: (N,) readings that count.
    """

    q: Floats
    links: Frame
    setup: npt.NDArray[np.int64]
    reflector: npt.NDArray[np.int64]
    link: npt.NDArray[np.int64]
    at: Floats
    before: Floats
    after: Floats
    sound: npt.NDArray[np.bool_]

    def __repr__(self) -> str:
        return f"ArmReadings({len(self.q)} readings)"


@dataclass(frozen=True)
class _Setup:
    session: int
    rows: npt.NDArray[np.intp]


def residual_scene(robot: Robot, sessions: Sequence[ArmReadings], *, refined: bool = True) -> Scene:
    """A station per set-up, the largest residuals first.

    Args:
        refined: whether there is an ``after``.
    """
    setups = _largest(sessions)
    first = [s.rows[0] for s in setups]
    frames = np.array([rows34(sessions[s.session].links)[k] for s, k in zip(setups, first, strict=True)])
    nominal = np.concatenate([frames, frames[:, -1:]], axis=1)  # no tool: the TCP is the flange
    still = np.zeros_like(nominal)
    names = ("at", "before", "after")
    at, before, after = (np.concatenate([getattr(sessions[s.session], name)[s.rows] for s in setups]) for name in names)
    after_side = {"after": packed(still)} if refined else {}
    longest = float(np.percentile(np.linalg.norm(before, axis=1), 95))
    return {
        "schema": SCHEMA,
        "robot": robot.name,
        "source": "",
        "links": robot.n + 2,
        "reach": arm_length(robot),
        "factor": first_factor(longest, 2.0 * arm_length(robot)),
        "worst": 0,
        "bodies": [body.as_dict() for body in [*arm_bodies(robot, link_bodies(robot).bodies), *_reflectors(sessions)]],
        "stations": {
            "count": len(setups),
            "title": [_title(sessions, s, refined) for s in setups],
            "tool": [s.session for s in setups],
            "nominal": packed(nominal),
            "before": packed(still),
            **after_side,
            "work": packed(np.eye(3, 4)),
            "moves": False,
        },
        "residuals": {
            "first": np.cumsum([0, *(len(s.rows) for s in setups)]).tolist(),
            "at": packed(at),
            "before": packed(before),
            **({"after": packed(after)} if refined else {}),
        },
        "joints": {
            "limits": limits(robot),
            "q": packed(np.degrees([sessions[s.session].q[k] for s, k in zip(setups, first, strict=True)])),
            "lamps": packed(np.full((len(setups), robot.n), WITHOUT), np.int8),
        },
        "findings": [],
    }


def mean_residuals(sessions: Sequence[ArmReadings]) -> tuple[float, float]:
    """m: mean length of the residuals of all readings that count, before and after."""
    sizes = (
        np.concatenate([np.linalg.norm(getattr(s, name)[s.sound], axis=1) for s in sessions])
        for name in ("before", "after")
    )
    before, after = (float(size.mean()) if len(size) else 0.0 for size in sizes)
    return before, after


def _largest(sessions: Sequence[ArmReadings]) -> list[_Setup]:
    found = []
    for k, one in enumerate(sessions):
        for setup in np.unique(one.setup[one.sound]):
            rows = np.flatnonzero((one.setup == setup) & one.sound)
            found.append((-round(float(np.mean(one.before[rows] ** 2)), 15), k, int(setup), rows))
    ordered = sorted(found, key=lambda entry: entry[:3])[:MOST_SETUPS]
    return [_Setup(k, rows) for _, k, _, rows in ordered]


def _title(sessions: Sequence[ArmReadings], s: _Setup, refined: bool) -> str:
    one = sessions[s.session]
    size = [float(np.linalg.norm(part[s.rows], axis=1).mean()) * MM for part in (one.before, one.after)]
    session = f"session {s.session + 1}, " if len(sessions) > 1 else ""
    change = f"{size[0]:.3f} mm, {size[1]:.3f} mm after" if refined else f"{size[0]:.3f} mm"
    return f"{session}set-up {one.setup[s.rows[0]]}, {len(s.rows)} readings: residual {change}, on average"


def _reflectors(sessions: Sequence[ArmReadings]) -> list[DrawnBody]:
    """A ball per reflector on its link, shown in the set-ups of its session."""
    bodies = []
    for k, one in enumerate(sessions):
        for number in np.unique(one.reflector):
            row = int(np.flatnonzero(one.reflector == number)[0])
            link = int(one.link[row])
            here = Frame(one.links.rotation[row, link], one.links.origin[row, link]).inward(one.at[row])
            size = SPHERE * float(np.ptp(one.links.origin[row], axis=0).max())
            bodies.append(DrawnBody(capsule(here, here, size), link, "reflector", REFLECTOR_COLOUR, tool=k))
    return bodies
