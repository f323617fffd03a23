"""What the loads of a session do to the undeflected arm: for figures, not for the statics."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from compensator.report.analysis.undeflected import UndeflectedArm
from stiffness.robot.robot import STANDARD_GRAVITY
from stiffness.session.session import Session

Floats = npt.NDArray[np.float64]


def load_torque(session: Session, arm: UndeflectedArm) -> Floats:
    """(N, n) N*m: torque of load and payload about the axis z of each joint, z . ((p - o) x f + m)."""
    s = session.samples
    force, moment, point = _load(session, arm)
    hung = arm.link(-1).at(_centre_of_mass(session))
    weight = _weight(s.payload)
    out = np.zeros((len(s), session.robot.n))
    for j in range(session.robot.n):
        about = np.cross(point - arm.pivot[:, j], force) + moment
        about = np.where((s.load.link > j)[:, None], about, 0.0) + np.cross(hung - arm.pivot[:, j], weight)
        out[:, j] = np.einsum("ni,ni->n", arm.axis[:, j], about)
    return out


def place_wrench(session: Session, arm: UndeflectedArm, place: int) -> Floats:
    """(N, 6) N and N*m that cross a place (0 base ... n flange), about its origin and in its axes: load, payload and,
    where the controller does not take them off, the weights of what lies outward."""
    force, moment, point = _load(session, arm)
    at = arm.link(place)
    outward = (session.samples.load.link >= place)[:, None]
    total = np.where(outward, force, 0.0)
    about = np.where(outward, moment + np.cross(point - at.origin, force), 0.0)
    for link, com, mass in _masses(session, place):
        weight = _weight(mass)
        total, about = total + weight, about + np.cross(arm.link(link).at(com) - at.origin, weight)
    back = at.inverse()
    return np.hstack([back.along(total), back.along(about)])


def _load(session: Session, arm: UndeflectedArm) -> tuple[Floats, Floats, Floats]:
    """Force and moment of the wrench as read, and the point that they are about, (N, 3) each, in the base."""
    load = session.samples.load
    tool = arm.link(-1).rotation @ session.tool.rotation
    turn = np.where(load.in_tool[:, None, None], tool, np.eye(3))
    force, moment = ((turn @ part[:, :, None])[:, :, 0] for part in (load.wrench[:, :3], load.wrench[:, 3:]))
    return force, moment, arm.link_of_each(load.point_link).at(load.point)


def _masses(session: Session, place: int) -> list[tuple[int, Floats, Floats]]:
    """Link, centre of mass in its frame, and kg (N,) of what hangs outward of a place."""
    s, robot = session.samples, session.robot
    com = _centre_of_mass(session)
    hung = [(robot.n, com, s.payload)]
    if session.gravity == "uncompensated":
        hung.append((robot.n, com, np.full(len(s), session.tool.mass or 0.0)))
        if robot.mass is not None and robot.com is not None:
            links = range(max(place, 1), robot.n + 1)
            hung += [(k, robot.com[k - 1], np.full(len(s), robot.mass[k - 1])) for k in links]
    return hung


def _centre_of_mass(session: Session) -> Floats:
    return np.zeros(3) if session.tool.com is None else session.tool.com


def _weight(mass: Floats) -> Floats:
    """(N, 3) N in the base of masses (N,) kg."""
    return np.asarray(mass[:, None] * np.array(STANDARD_GRAVITY))
