"""The load that crosses a place of the undeflected arm: for figures, not for the statics."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from compensator.report.views.diagnosis import Geometry
from stiffness.robot.robot import STANDARD_GRAVITY
from stiffness.session.session import Session

Floats = npt.NDArray[np.float64]


def place_wrench(session: Session, g: Geometry, place: int) -> Floats:
    """(N, 6) N and N*m about the origin of a link, in its axes: load, payload and, where the controller does not take
    them off, the weights of what lies outward."""
    s = session.samples
    every = np.arange(len(s))
    tool = g.rotation[:, -1] @ session.tool.rotation
    turn = np.where(s.load.in_tool[:, None, None], tool, np.eye(3))
    force, moment = _turned(turn, s.load.wrench[:, :3]), _turned(turn, s.load.wrench[:, 3:])
    point = g.origin[every, s.load.point_link] + _turned(g.rotation[every, s.load.point_link], s.load.point)
    outward = (s.load.link >= place)[:, None]
    total = np.where(outward, force, 0.0)
    about = np.where(outward, moment + np.cross(point - g.origin[:, place], force), 0.0)
    com = np.zeros(3) if session.tool.com is None else session.tool.com
    hung = [(session.robot.n, com, s.payload)]
    if session.gravity == "uncompensated":
        hung.append((session.robot.n, com, np.full(len(s), session.tool.mass or 0.0)))
        if session.robot.mass is not None and session.robot.com is not None:
            links = range(max(place, 1), session.robot.n + 1)
            hung += [(k, session.robot.com[k - 1], np.full(len(s), session.robot.mass[k - 1])) for k in links]
    for link, at, mass in hung:
        weight = mass[:, None] * np.array(STANDARD_GRAVITY)
        where = g.origin[:, link] + g.rotation[:, link] @ at
        total, about = total + weight, about + np.cross(where - g.origin[:, place], weight)
    back = np.swapaxes(g.rotation[:, place], 1, 2)
    return np.hstack([_turned(back, total), _turned(back, about)])


def _turned(rotation: Floats, vector: Floats) -> Floats:
    return np.asarray(np.einsum("nij,nj->ni", rotation, vector))
