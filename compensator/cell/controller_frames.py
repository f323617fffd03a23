"""The frames that a controller measures from, where a URDF has them: what is taken without a word, and what to write.

Of a URDF the link ``base``, else the root, and the last moving link are taken; positions and tools that are read off
the controller may be from frames that stand elsewhere.
"""

from __future__ import annotations

from collections.abc import Iterable

from stiffness.robot.controller_frame import ControllerFrame
from stiffness.robot.robot import Robot
from stiffness.session.session import Session
from toolpaths.finding import NOTE, WARNING, Finding

CELL, SESSION, TRACE = "cell", "session", "cell of the trace"


def tip_findings(robot: Robot, source: str, file: str) -> tuple[Finding, ...]:
    """A warning where ``file`` does not tell which frame tools are measured from, and that may be another.

    Args:
        source: where it is said. file: one of ``CELL``, ``SESSION``, ``TRACE``.
    """
    frame = robot.flange_frame
    if frame is None or not frame.away:
        return ()
    what = f"tools are taken as measured from {robot.tip!r}, the last moving link of the URDF; {frame}"
    remedy = (
        f"Are they measured from there, as controllers do, write tip = \"{frame.name}\" in {file} and model; if not, "
        f"tip = \"{robot.tip}\" in the {file} says so"
    )
    return (Finding(WARNING, source, what, remedy, kind="cell" if file == CELL else "measurement"),)


def base_findings(robot: Robot, source: str, file: str) -> tuple[Finding, ...]:
    """The same of the frame that positions are measured from."""
    frame = robot.base_frame
    if frame is None or not frame.away:
        return ()
    what = f"positions in the base are taken as measured from {robot.base!r}, {_as_taken(robot)}; {frame}"
    remedy = (
        f"Are they read off the controller, which measures from there, write base = \"{frame.name}\" in {file} and "
        f"model{_and_mount(frame, file)}; if not, base = \"{robot.base}\" in the {file} says so"
    )
    return (Finding(WARNING, source, what, remedy, kind="cell" if file == CELL else "measurement"),)


def session_frame_findings(sessions: Iterable[Session]) -> tuple[Finding, ...]:
    """The same of sessions and traces."""
    out = list[Finding]()
    for s in sessions:
        file = SESSION if s.path is None else TRACE
        out += (*tip_findings(s.robot, s.source, file), *base_findings(s.robot, s.source, file))
    return tuple(out)


def new_cell_findings(name: str, robot: Robot) -> tuple[Finding, ...]:
    """What `init` says of the frames that it takes part and tools of a URDF as measured from.

    Args:
        robot: of the file ``name``, neither base nor tip asked for.
    """
    if not name.endswith(".urdf"):
        return ()
    return (_new_base(name, robot), _new_tip(name, robot))


def _new_base(name: str, robot: Robot) -> Finding:
    frame = robot.base_frame
    if frame is None:
        what = f"the URDF has neither base nor wbase: the part is taken as measured from {robot.base!r}, its root"
        remedy = "Is that where the controller measures from? If not, name the link with base, in cell and model"
        return Finding(WARNING, name, what, remedy, kind="cell")
    said = f"base = \"{frame.name}\": the part is taken as measured from this frame of the URDF, its controller's base"
    if not frame.on_axis:
        remedy = "Few controllers have such a base: compare a pose of the arm with what its display shows"
        return Finding(WARNING, name, f"{said}, whose z is not along axis 1", remedy, kind="cell")
    if frame.mount is not None:
        remedy = f"Does the arm stand like that, give [mount] rpy = {_numbers(frame.mount)}: gravity is -z of the world"
        return Finding(WARNING, name, f"{said}, and is tilted in the root of it", remedy, kind="cell")
    return Finding(NOTE, name, f"{said}; seen from {robot.base!r}, {frame}" if frame.away else said, kind="cell")


def _new_tip(name: str, robot: Robot) -> Finding:
    frame = robot.flange_frame
    if frame is None:
        what = f"the URDF has neither tool0 nor a flange: tools are taken as measured from {robot.tip!r}"
        remedy = "Is that where the controller measures them from? If not, name the link with tip, in cell and model"
        return Finding(WARNING, name, what, remedy, kind="cell")
    said = f"tip = \"{frame.name}\": tools are taken as measured from this frame of the URDF"
    if not frame.on_axis:
        remedy = "No controller has such a flange: give [tool] rpy, so that z points out of the tool, and compare"
        return Finding(WARNING, name, f"{said}, whose z is not the axis of the last joint", remedy, kind="cell")
    return Finding(NOTE, name, f"{said}; seen from {robot.tip!r}, {frame}", kind="cell")


def _and_mount(frame: ControllerFrame, file: str) -> str:
    """Gravity goes by the base that is named, so that one that is tilted in the URDF needs its mount."""
    if frame.mount is None or file == SESSION:
        return ""
    return f", and [mount] rpy = {_numbers(frame.mount)} in the {file}"


def _numbers(values: Iterable[float]) -> str:
    return "[" + ", ".join(f"{v:g}" for v in values) + "]"


def _as_taken(robot: Robot) -> str:
    return "the link of this name" if robot.base == "base" else "the root of the URDF"
