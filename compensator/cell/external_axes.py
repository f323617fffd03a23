"""External axes that the cell declares: a rail that carries the robot, a table that carries the part.

Within a move they go evenly from end to end, while the tool goes straight in the work object. The solve sees every pose
from the robot's base, as if rail and table stood at 0; programs get the poses back as their work object has them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from compensator.cell.placement import Placement
from compensator.cell.placement_tables import ExternalAxisTable
from toolpaths.axis_ways import AxisWays, TurningTable
from toolpaths.errors import ToolpathError
from toolpaths.external_axes import SAME, axis_number, cut_places, places, unmodelled, whole_moves
from toolpaths.finding import ERROR, NOTE, WARNING, Finding
from toolpaths.frame import Frame
from toolpaths.languages.table import Language
from toolpaths.resample import MOST_POSES, in_parts
from toolpaths.rotation import matrix_about, matrix_from_unit_quaternion, quaternion_from_matrix
from toolpaths.toolpath import CUT, Setting, Toolpath, tool_axis
from toolpaths.writing.program import ExternalAxis

Floats = npt.NDArray[np.float64]


def seen_from_base(placement: Placement, toolpath: Toolpath) -> Toolpath:
    """The poses of a program as the robot's base sees them.

    Raises:
        ToolpathError: the turning of a table makes too many poses.
    """
    toolpath = _followed(placement, toolpath)
    found = moved_workobject(placement, toolpath)
    if found is None or toolpath.quaternion is None:
        return toolpath
    return _placed(toolpath, found.then(Frame(matrix_from_unit_quaternion(toolpath.quaternion), toolpath.position)))


def as_programmed(placement: Placement, toolpath: Toolpath) -> Toolpath:
    """The poses of joint angles, which the robot's base sees, as the program has them."""
    found, setting = moved_workobject(placement, toolpath), toolpath.setting
    if found is None or setting is None or toolpath.quaternion is None or not setting.joints:
        return toolpath
    rows = np.isin(toolpath.row, [float(r) for r in setting.joints])[:, None]
    known = np.where(np.isfinite(toolpath.quaternion[:, :1]), toolpath.quaternion, np.array([1.0, 0.0, 0.0, 0.0]))
    back = Frame(matrix_from_unit_quaternion(known), toolpath.position).relative_to(found)
    position = np.where(rows, back.origin, toolpath.position)
    quaternion = np.where(rows, quaternion_from_matrix(back.rotation), toolpath.quaternion)
    return replace(toolpath, position=position, quaternion=quaternion, axis=tool_axis(quaternion))


def _placed(toolpath: Toolpath, poses: Frame) -> Toolpath:
    quaternion = quaternion_from_matrix(poses.rotation)
    return replace(toolpath, position=poses.origin, quaternion=quaternion, axis=tool_axis(quaternion))


def moved_workobject(placement: Placement, toolpath: Toolpath) -> Frame | None:
    """(N) the work object as it stands at every pose, in the work object with all axes at 0; None: it stays there.

    As if rail and table stood at 0, the base sees a pose of the program at ``moved_workobject(...).then(pose)``.
    """
    return _moved(placement, _stands(placement, toolpath), len(toolpath))


def _moved(placement: Placement, stands_at: Mapping[str, Floats], n: int) -> Frame | None:
    """As ``moved_workobject``, of axes at (n,) mm or deg."""
    axes = _axes(placement.external, stands_at)
    if not axes:
        return None
    turn, shift = np.broadcast_to(np.eye(3), (n, 3, 3)), np.zeros((n, 3))
    for name, axis in axes.items():
        stands = stands_at[name]
        if axis.carries == "robot":
            shift = shift - stands[:, None] * 1e-3 * np.array(axis.direction)
        else:
            center = np.array(axis.center) * 1e-3
            more = matrix_about(np.array(axis.direction), np.radians(stands))
            turn, shift = more @ turn, np.einsum("nij,nj->ni", more, shift - center) + center
    r, p = placement.workobject.rotation, placement.workobject.origin
    return Frame(r.T @ turn @ r, (turn @ p + shift - p) @ r)


def rail_shift(placement: Placement, toolpath: Toolpath) -> Floats | None:
    """(N, 3) m: how the floor stands at every pose, as the base sees it, with rails at 0; None: no rail moves it."""
    stands = _stands(placement, toolpath)
    rails = {name: a for name, a in _axes(placement.external, stands).items() if a.carries == "robot"}
    if not rails:
        return None
    ways = [np.outer(stands[n], a.direction) for n, a in rails.items()]
    return np.asarray(-1e-3 * np.sum(ways, axis=0))


def on_ways(placement: Placement, toolpath: Toolpath, chosen: Mapping[str, Floats]) -> Toolpath:
    """A CAM path as the robot's base sees it with axes at ``chosen``, name -> (N,) mm or deg at its poses."""
    rails = [(v, placement.external[name].direction) for name, v in chosen.items() if _is_rail(placement, name)]
    drift = -1e-3 * np.sum([np.outer(v, d) for v, d in rails], axis=0) if rails else np.zeros((len(toolpath), 3))
    work = placement.workobject
    table = next((_turning(work, n, placement.external[n]) for n, v in chosen.items() if _turns(placement, n, v)), None)
    ways = AxisWays(toolpath.row, dict(chosen), drift @ work.rotation, table)
    path = replace(toolpath, ways=ways)
    moved = moved_workobject(placement, path)
    if moved is None:
        return path
    if toolpath.quaternion is not None:
        return _placed(path, moved.then(Frame(matrix_from_unit_quaternion(toolpath.quaternion), toolpath.position)))
    return replace(path, position=moved.at(toolpath.position), axis=moved.along(toolpath.axis))


def _turns(placement: Placement, name: str, stands: Floats) -> bool:
    """Whether a table turns along the path."""
    return not _is_rail(placement, name) and bool(np.ptp(stands) > 0)


def _turning(work: Frame, name: str, axis: ExternalAxisTable) -> TurningTable:
    return TurningTable(name, np.array(axis.direction) @ work.rotation, work.inward(np.array(axis.center) * 1e-3))


def _is_rail(placement: Placement, name: str) -> bool:
    return placement.external[name].carries == "robot"


def axes_in_program(placement: Placement, toolpath: Toolpath) -> tuple[ExternalAxis, ...]:
    """Where chosen axes stand, in the order of their numbers."""
    stands = {} if toolpath.ways is None else toolpath.ways.at(toolpath.row)
    units = {name: "mm" if _is_rail(placement, name) else "deg" for name in stands}
    return tuple(ExternalAxis(n, units[n], stands[n]) for n in sorted(stands, key=lambda n: axis_number(n) or 0))


def workobject_in_program(placement: Placement, toolpath: Toolpath) -> Frame:
    """The work object that a new program has: where tables that were set for it hold it; rails carry the robot, and a
    table that turns on the way is at 0."""
    stands = {} if toolpath.ways is None else toolpath.ways.at(toolpath.row[:1])
    turned = _moved(placement, {n: v for n, v in stands.items() if _is_set(placement, toolpath, n)}, 1)
    return placement.workobject if turned is None else placement.workobject.then(turned.take(0))


def _is_set(placement: Placement, toolpath: Toolpath, name: str) -> bool:
    """Whether an axis is a table that stays where it is, so that the controller need not know of it."""
    table = None if toolpath.ways is None else toolpath.ways.table
    return not _is_rail(placement, name) and (table is None or table.name != name)


def printed_axes(placement: Placement, toolpath: Toolpath, printed: Floats) -> tuple[Frame, Frame, Floats]:
    """Chosen axes where a program has them, (N, K) mm or deg.

    Returns:
        As ``moved_workobject``, what the program's poses are in, whose work object no table turns but one that turns on
        the way, and what the part does; and how far each pose's axes are from where they were chosen, (N,) m or rad.
    """
    axes, still = axes_in_program(placement, toolpath), Frame.identity()
    stands = {axis.name: column for axis, column in zip(axes, printed.T, strict=True)}
    set_ = {axis.name: axis.places for axis in axes if _is_set(placement, toolpath, axis.name)}
    off = [np.abs(stands[a.name] - a.places) * (1e-3 if a.unit == "mm" else np.pi / 180.0) for a in axes]
    poses, part = (_moved(placement, {**stands, **at}, len(toolpath)) or still for at in (set_, {}))
    return poses, part, np.max(off, axis=0)


def workobject_along(placement: Placement, toolpath: Toolpath) -> Frame:
    """The work object in the base; (N) of it where rail or table move it."""
    moved = moved_workobject(placement, toolpath)
    return placement.workobject if moved is None else placement.workobject.then(moved)


def _followed(placement: Placement, toolpath: Toolpath) -> Toolpath:
    """The path with points in the cuts in which a table turns: seen from the base they are no straight lines."""
    stands = _stands(placement, toolpath)
    tables = {name: a for name, a in _axes(placement.external, stands).items() if a.carries == "part"}
    if not tables or len(toolpath) < 2:
        return toolpath
    sampling, parts = placement.sampling, np.ones(len(toolpath) - 1)
    for name, axis in tables.items():
        turn = np.abs(np.diff(np.radians(stands[name])))
        reach = reach_on_table(placement, axis, toolpath)
        parts = np.maximum(parts, turn / stray_turn(placement, reach))
        parts = np.maximum(parts, turn * reach / (sampling.spacing * 1e-3))
    parts = np.where(toolpath.kind[1:] == CUT, parts, 1.0)
    if parts.sum() > MOST_POSES:
        raise ToolpathError(f"{toolpath.source}: the turning of the table makes {parts.sum():.3g} poses")
    return in_parts(toolpath, np.ceil(parts - 1e-6).astype(np.intp)) if parts.max() > 1.0 else toolpath


def reach_on_table(placement: Placement, axis: ExternalAxisTable, toolpath: Toolpath) -> Floats:
    """(N - 1,) m, how far each move gets from the center of a table."""
    lever = np.linalg.norm(placement.workobject.at(toolpath.position) - np.array(axis.center) * 1e-3, axis=1)
    return np.asarray(np.fmax(np.fmax(lever[1:], lever[:-1]), 1e-3))


def stray_turn(placement: Placement, reach: Floats) -> Floats:
    """(M,) rad that a table may turn between poses ``reach`` (M,) m from its center: [sampling] chord and angle."""
    sampling = placement.sampling
    return np.asarray(np.sqrt(8.0 * np.minimum(min(np.radians(sampling.angle), 1.0), sampling.chord * 1e-3 / reach)))


def external_findings(placement: Placement, toolpath: Toolpath, language: Language) -> tuple[Finding, ...]:
    """What another language than the program's own loses: it is written without external axes.

    No robot runs a table of numbers: there it is a warning.
    """
    if toolpath.setting is None:
        return ()
    _, cut = whole_moves(toolpath)
    out = []
    for name, (rows, _, end) in cut_places(toolpath.setting.external, cut).items():
        if (np.abs(end) > SAME).any():
            ours = declared_as(placement.external, name)
            axis = None if ours is None else placement.external[ours]
            harmless = language.table or (axis is not None and axis.carries == "nothing")
            at = int(rows[int(np.argmax(np.abs(end) > SAME))])
            where = toolpath.where(int(np.searchsorted(toolpath.row, at - 1e-9)))
            what = f"external axis {name} stands at {end[np.abs(end) > SAME][0]:g}: written without external axes"
            remedy = "write a program in the language of the source: its external axes stay as they are"
            out.append(Finding(WARNING if harmless else ERROR, where, what, remedy))
    return tuple(out)


def in_frame(read: Toolpath, source: Setting | None) -> Toolpath:
    """A program that is read again, in the work object of its source: lines put in may make another one the first."""
    ours = None if source is None else source.workobject
    theirs = None if read.setting is None else read.setting.workobject
    if ours is None or theirs is None or read.setting is None or read.quaternion is None:
        return read
    if np.allclose(ours.matrix, theirs.matrix, rtol=0.0, atol=1e-12):
        return read
    relative = Frame.of(np.linalg.inv(ours.matrix) @ theirs.matrix)
    known = np.isfinite(read.quaternion[:, :1])
    rotation = matrix_from_unit_quaternion(np.where(known, read.quaternion, [1.0, 0.0, 0.0, 0.0]))
    poses = relative.then(Frame(rotation, read.position))
    quaternion = np.where(known, quaternion_from_matrix(poses.rotation), read.quaternion)
    arcs = {k: (relative.at(p), off) for k, (p, off) in read.setting.arcs.items()}
    setting = replace(read.setting, workobject=ours, arcs=arcs)
    return replace(read, setting=setting, position=poses.origin, quaternion=quaternion, axis=tool_axis(quaternion))


def external_notes(external: Mapping[str, ExternalAxisTable], toolpath: Toolpath) -> tuple[Finding, ...]:
    """What is not known of axes that the cell does not declare: they pass through as they are."""
    if toolpath.setting is None:
        return ()
    found = unmodelled(toolpath.setting.external, whole_moves(toolpath)[1])
    return tuple(
        Finding(
            WARNING if stands.startswith("moves") else NOTE,
            toolpath.source,
            f"external axis {name} {stands}: it is not modelled, the work object is taken "
            f"where the robot's base sees it; if it carries robot or part, say so in [external.{name}]",
        )
        for name, stands in found
        if declared_as(external, name) is None
    )


def declared_as(external: Mapping[str, ExternalAxisTable], name: str) -> str | None:
    """How a cell calls an axis of a program: E1 and eax_a are two names of one; None: the cell does not declare it."""
    number = axis_number(name)
    if name in external or number is None:
        return name if name in external else None
    return next((ours for ours in external if axis_number(ours) == number), None)


def _stands(placement: Placement, toolpath: Toolpath) -> dict[str, Floats]:
    """(N,) mm or deg of every axis that the cell declares and the path tells of."""
    if toolpath.ways is not None:
        return toolpath.ways.at(toolpath.row)
    given = {} if toolpath.setting is None else toolpath.setting.external
    ours = {declared_as(placement.external, name): v for name, v in given.items()}
    return {name: places(v, toolpath.row) for name, v in ours.items() if name is not None}


def _axes(external: Mapping[str, ExternalAxisTable], stands: Mapping[str, Floats]) -> Mapping[str, ExternalAxisTable]:
    """In the order that they carry the part: the innermost table first, the outermost, then rails."""
    used = [(n, a) for n, a in external.items() if n in stands and a.carries != "nothing"]
    return dict(sorted(reversed(used), key=lambda axis: axis[1].carries == "robot"))
