"""Filter in place: which poses a rewritten program needs, writing it, and running it through the model again."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from compensator.cell.external_axes import carried, in_frame
from compensator.errors import SolveError
from compensator.path.pose_text import place
from compensator.program.export import program_of
from compensator.program.robot_program import completed
from compensator.solve.compensation import Compensation
from compensator.solve.joint_state import follow
from compensator.solve.upright import tilt, untilted
from compensator.solve.verify import PRINTED, Verified
from toolpaths.files import read_toolpath
from toolpaths.frame import Frame
from toolpaths.languages.table import Language
from toolpaths.rotation import matrix_from_unit_quaternion, quaternion_from_matrix, slerp_quaternion
from toolpaths.toolpath import CUT, Toolpath
from toolpaths.writing.program import WARNING, Finding, Program

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]

SHARE = 0.5  # of sampling.chord that the path between two written poses may miss the solve
TURNED = 2e-4  # rad that it may be turned off
FINER = 0.05  # share of the chord with which arcs of the written program are read


@dataclass(frozen=True, repr=False)
class Filtered:
    """A rewritten program on the disk.

    Attributes:
        files: staged, the program first.
        changes: what else than pose numbers changed.
        program: the poses that were written, ``row`` in the rows of the source.
        result: the commands that were written: without the tilt, where the language cannot say it.
    """

    files: tuple[Path, ...]
    changes: tuple[Finding, ...]
    program: Program
    row: Floats
    result: Compensation

    def __repr__(self) -> str:
        return f"Filtered({self.files[0].name}, {len(self.changes)} changes)"


def filtered_in_place(source: Toolpath, language: Language, toolpath: Path) -> bool:
    """Whether ``source``, read from ``toolpath``, is changed in place; not where another language is to be written.

    Raises:
        WriteError: the program holds what no filter can keep; names the line.
    """
    if source.language != language.name or not language.filtered:
        return False
    language.filter.check(toolpath.read_bytes(), toolpath)
    return True


def filter_program(c: Compensation, rows: Floats, toolpath: Path, staged: Path, language: Language) -> Filtered:
    """Write ``toolpath`` to ``staged`` with the commands of ``c``.

    Args:
        rows: ``row`` of the poses that the reader gave.
    """
    source = toolpath.read_bytes()
    left: tuple[Finding, ...] = ()
    if not language.filter.says_turns(source):
        c, left = untilted(c), _left_tilted(c, toolpath)
    index = needed_poses(c, rows)
    program, row = _taken(_as_written(c), index), c.path.toolpath.row[index]
    rewritten = language.rewrite(source, program, row, toolpath, c.job.placement.machine)
    staged.write_bytes(rewritten.text)
    files = [staged]
    for suffix, data in rewritten.beside:
        files.append(staged.with_suffix(suffix))
        files[-1].write_bytes(data)
    return Filtered(tuple(files), (*rewritten.changes, *left), program, row, c)


def _left_tilted(c: Compensation, toolpath: Path) -> tuple[Finding, ...]:
    """What a program without words for the tool's axis leaves."""
    off, k = tilt(c)
    if off <= TURNED:
        return ()
    what = f"the deflection tilts the tool by up to {np.degrees(off):.2g} deg, which a file without tool vectors "
    remedy = "Positions are corrected; write a program in the robot's language to have the tilt corrected, too"
    return (Finding(WARNING, f"{toolpath}:{int(c.path.toolpath.line[k])}", what + "cannot take back", remedy),)


def needed_poses(c: Compensation, rows: Floats) -> Index:
    """Poses that have to stand in the program: those of the source, and of the others those without which the straight
    way between them misses the solve."""
    toolpath = c.path.toolpath
    cut = toolpath.kind == CUT
    source = np.isin(toolpath.row, rows)
    keep = source & (cut | np.concatenate([cut[1:], [False]]))
    written = _as_written(c)
    p, q = written.position, quaternion_from_matrix(written.rotation)
    bound = SHARE * c.job.placement.sampling.chord * 1e-3
    while True:
        kept = np.flatnonzero(keep)
        rest = np.flatnonzero(cut & ~keep)
        if not len(rest):
            break
        segment = np.searchsorted(kept, rest) - 1
        off = _missed(toolpath.row, p, q, kept[segment], rest, kept[segment + 1], bound)
        order = np.lexsort((-off, segment))
        worst = order[np.concatenate([[True], np.diff(segment[order]) != 0])]
        worst = worst[off[worst] > 1.0]
        if not len(worst):
            break
        keep[rest[worst]] = True
    return np.flatnonzero(keep)


def _missed(row: Floats, p: Floats, q: Floats, a: Index, k: Index, b: Index, bound: float) -> Floats:
    """(M,) how far pose k lies off the straight way from pose a to pose b, in units of what is allowed."""
    t = (row[k] - row[a]) / (row[b] - row[a])
    off = np.linalg.norm(p[k] - p[a] - t[:, None] * (p[b] - p[a]), axis=1)
    way = slerp_quaternion(q[a], q[b], t)
    turned = 2.0 * np.sqrt(np.maximum(0.0, 1.0 - np.minimum(np.sum(way * q[k], axis=1) ** 2, 1.0)))
    return np.asarray(np.maximum(off / bound, turned / TURNED))


def _as_written(c: Compensation) -> Program:
    """Commands at cuts; rapids stay where the source has them."""
    program = program_of(c)
    nominal = program_of(c, corrected=False)
    cut = c.cutting
    return replace(
        program,
        position=np.where(cut[:, None], program.position, nominal.position),
        rotation=np.where(cut[:, None, None], program.rotation, nominal.rotation),
    )


def _taken(program: Program, index: Index) -> Program:
    """Some poses of a program, without its comments."""
    n = len(program)
    arrays = {f.name: getattr(program, f.name) for f in fields(program) if f.name not in ("workobject", "start_joints")}
    per_pose: dict[str, Any] = {
        name: value[index] for name, value in arrays.items() if isinstance(value, np.ndarray) and len(value) == n
    }
    return replace(program, **per_pose, comments=())


def verify_filtered(c: Compensation, done: Filtered, names: Path) -> Verified:
    """Read the rewritten program and let the model deflect it, at every pose that was solved.

    Args:
        names: path of the program as the user will see it.

    Raises:
        SolveError: the file does not say what was solved.
    """
    chord = FINER * c.job.placement.sampling.chord * 1e-3
    read = read_toolpath(done.files[0], chord=chord, machine=c.job.placement.machine, shown=str(names))
    read = completed(c.job.placement, c.job.arm.robot, in_frame(read, c.path.toolpath.setting))
    row, pose = _aligned(done, read)
    toolpath, cut = c.path.toolpath, c.cutting
    printed = _between(c, read, row, pose, done)
    if on_axes := carried(c.job.placement, toolpath):
        printed = on_axes.then(printed)
    rows = np.flatnonzero(cut)
    tcp, some = c.job.placement.workobject.then(printed).take(rows), toolpath.take(rows)
    batch = c.job.planner.inverse.along(some, tcp, c.path.branch, c.command.q[rows])
    if not batch.ok.all():
        k = int(np.argmin(batch.ok))
        raise SolveError(f"{place(some, k)}: the written pose has no joint angles: {batch.why(k)}")
    q = c.path.q.copy()
    q[rows] = batch.q
    prediction, _ = follow(c.job.arm, c.job.placement.start, toolpath, q=q, wrench=c.wrench, guess=c.state)
    target = np.where(cut[:, None], c.target.origin, c.path.tcp.origin)
    error = np.linalg.norm(prediction.position - target, axis=1)
    return Verified(error, float(np.linalg.norm(tcp.origin - c.command.position[rows], axis=1).max()))


def _aligned(done: Filtered, read: Toolpath) -> tuple[Floats, Index]:
    """(K,) rows of the source, and the pose of ``read`` that stands there, for every written pose that cuts and the
    pose that each cut starts from."""
    rows: list[float] = []
    poses: list[int] = []
    written = done.program
    end = np.abs(done.row - np.rint(done.row)) < 1e-9  # others need not stand there: an arc may still say them
    ends = np.flatnonzero(np.abs(read.row - np.rint(read.row)) < 1e-9)
    cutting = read.kind[ends] == CUT
    starts = np.concatenate([cutting[1:], [False]])
    at = 0
    for k in ends[cutting | starts].tolist():
        while at < len(written):
            near = read.kind[k] != CUT or np.linalg.norm(read.position[k] - written.position[at]) <= PRINTED
            if near and read.kind[k] == written.kind[at]:
                break
            if end[at]:
                raise SolveError(f"{place(read, k)}: the program prints another pose than the one that was solved")
            at += 1
        if at == len(written):
            raise SolveError(f"{place(read, k)}: this pose was not solved")
        rows.append(float(done.row[at]))
        poses.append(k)
        at += 1
    if at != len(written):
        raise SolveError(f"{read.source}: {len(written) - at} poses are missing in the program")
    return np.array(rows), np.array(poses, dtype=np.intp)


def _between(c: Compensation, read: Toolpath, row: Floats, pose: Index, done: Filtered) -> Frame:
    """(N) commanded TCP (work object) of the written program at every solved pose."""
    position, rotation = read.position.copy(), _rotations(read, row, pose, done)
    rapid = pose[read.kind[pose] != CUT]
    if len(rapid):  # as in the source; those of joint moves are not poses
        at = np.searchsorted(done.row, row[read.kind[pose] != CUT])
        position[rapid], rotation[rapid] = done.program.position[at], done.program.rotation[at]
    rows = np.interp(np.arange(len(read)), pose, row)
    first = np.concatenate([[0], pose[:-1]])
    for start, end in zip(first.tolist(), pose.tolist(), strict=True):
        if end - start > 1 and read.kind[end] == CUT:  # points of an arc
            a, b = rows[start], rows[end]
            rows[start + 1 : end] = a + (b - a) * (read.row[start + 1 : end] - read.row[start])
    used = np.zeros(len(read), dtype=bool)
    used[pose] = True
    used[read.kind == CUT] = True
    rows, position, q = rows[used], position[used], quaternion_from_matrix(rotation[used])
    wanted = c.path.toolpath.row
    b = np.clip(np.searchsorted(rows, wanted - 1e-12), 1, len(rows) - 1)
    t = np.clip((wanted - rows[b - 1]) / np.maximum(rows[b] - rows[b - 1], 1e-12), 0.0, 1.0)
    mixed = position[b - 1] + t[:, None] * (position[b] - position[b - 1])
    return Frame(matrix_from_unit_quaternion(slerp_quaternion(q[b - 1], q[b], t)), mixed)


def _rotations(read: Toolpath, row: Floats, pose: Index, done: Filtered) -> Floats:
    """(K, 3, 3) as read; where the language gives the tool axis alone, its turn is that of the solve."""
    if read.quaternion is not None:
        known = np.isfinite(read.quaternion[:, :1])
        return matrix_from_unit_quaternion(np.where(known, read.quaternion, np.array([1.0, 0.0, 0.0, 0.0])))
    at = np.searchsorted(done.row, np.interp(np.arange(len(read)), pose, row), side="left")
    solved = done.program.rotation[np.minimum(at, len(done.row) - 1)]
    z = -read.axis
    x = solved[:, :, 0] - z * np.sum(solved[:, :, 0] * z, axis=1, keepdims=True)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    return np.stack([x, np.cross(z, x), z], axis=2)
