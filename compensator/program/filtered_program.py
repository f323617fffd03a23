"""A program filtered in place: what was written, read back from the disk and run through the model again."""

from __future__ import annotations

from array import array
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from compensator.cell.external_axes import in_frame, moved_workobject
from compensator.errors import SolveError
from compensator.path.pose_text import place
from compensator.program.maker import MadeProgram
from compensator.program.robot_program import with_joint_poses
from compensator.solve.compensation import Compensation
from compensator.solve.joint_state import equilibria
from compensator.solve.verify import PRINTED, Verified, moved_on_axes
from toolpaths.columns import blocks, give_back
from toolpaths.files import read_program
from toolpaths.frame import Frame
from toolpaths.languages.table import Language
from toolpaths.made_frames import MadeFrames, with_others
from toolpaths.program_files import ProgramFiles
from toolpaths.rotation import matrix_from_unit_quaternion, quaternion_from_matrix, slerp_quaternion
from toolpaths.toolpath import CUT, Toolpath
from toolpaths.writing.program import Program

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]

TURNED = 2e-4  # rad that the way between two written poses may be turned off the solve
FINER = 0.05  # share of the chord with which arcs of the written program are read


@dataclass(frozen=True, repr=False)
class FilteredProgram(MadeProgram):
    """A rewritten program on the disk.

    Attributes:
        program: the poses that were written. row: (M,) theirs, in the rows of the source.
        language: what it is written in.
        kept: files of the source that did not have to be written.
    """

    program: Program
    row: Floats
    language: Language
    kept: tuple[Path, ...] = ()

    @property
    def poses(self) -> Index:
        return np.flatnonzero(np.isin(self.result.path.toolpath.row, self.row))

    def verified(self) -> MadeProgram:
        return _Verified(self.files, self.findings, self.result, self.poses)


@dataclass(frozen=True, repr=False)
class _Verified(MadeProgram):
    """Of a rewritten program, what is asked for once it is verified."""

    stand: Index

    @property
    def poses(self) -> Index:
        return self.stand


def verify_filtered(done: FilteredProgram, names: Path) -> Verified:
    """Read the rewritten program and let the model deflect it, at every pose that was solved.

    Args:
        names: path of the program as the user will see it.

    Raises:
        SolveError: the file does not hold what was solved.
    """
    c = done.result
    chord = FINER * c.job.placement.sampling.chord * 1e-3
    files = ProgramFiles(done.files[0], (*done.files[1:], *done.kept) or None, done.language)
    read = read_program(files, chord=chord, machine=c.job.placement.machine, shown=str(names))
    read = with_joint_poses(c.job.placement, c.job.arm.robot, in_frame(read, c.path.toolpath.setting))
    give_back()
    row, pose = _aligned(done, read)
    toolpath, cut = c.path.toolpath, c.cutting
    printed = _between(done, read, row, pose)
    if on_axes := moved_workobject(c.job.placement, toolpath):
        printed = moved_on_axes(on_axes, printed)
    q, off = _joint_angles(c, printed)
    error, start = np.empty(len(c)), c.job.placement.start
    for rows, found, _ in equilibria(c.job.arm, start, toolpath, q=q, wrench=c.wrench, guess=c.state):
        target = np.where(cut[rows, None], c.target.take(rows).origin, c.path.tcp.take(rows).origin)
        error[rows] = np.linalg.norm(found.position - target, axis=1)
    return Verified(error, off)


def _joint_angles(c: Compensation, printed: Frame) -> tuple[Floats, float]:
    """(N, n) rad of poses (N) in the work object, at cuts as the controller finds them, and how far, m, the TCP of
    a cut is from the solved one."""
    q, off, toolpath, inverse = c.path.q.copy(), 0.0, c.path.toolpath, c.job.planner.inverse
    cuts = np.flatnonzero(c.cutting)
    for b in blocks(len(cuts), None if inverse.labelled else len(cuts)):
        rows = cuts[b]
        tcp, some = c.job.placement.workobject.then(printed.take(rows)), toolpath.take(rows)
        batch = inverse.along(some, tcp, c.path.branch[rows], c.command.q[rows])
        if not batch.ok.all():
            k = int(np.argmin(batch.ok))
            raise SolveError(f"{place(some, k)}: the written pose has no joint angles: {batch.why(k)}")
        q[rows] = batch.q
        off = max(off, float(np.linalg.norm(tcp.origin - c.printed.take(rows).origin, axis=1).max()))
    return q, off


def _aligned(done: FilteredProgram, read: Toolpath) -> tuple[Floats, Index]:
    """(K,) rows of the source, and the pose of ``read`` that stands there, for every written pose that cuts and the
    pose that each cut starts from."""
    rows, poses = array("d"), array("q")
    written = done.program
    end = np.abs(done.row - np.rint(done.row)) < 1e-9  # others need not stand there: an arc may still pass them
    ends = np.flatnonzero(np.abs(read.row - np.rint(read.row)) < 1e-9)
    cutting = read.kind[ends] == CUT
    starts = np.concatenate([cutting[1:], [False]])
    there = ends[cutting | starts]
    if len(there) == len(written) and _stand_there(read, there, written):
        return done.row, there
    at = 0
    for k in there.tolist():
        while at < len(written):
            near = read.kind[k] != CUT or np.linalg.norm(read.position[k] - written.position[at]) <= PRINTED
            if near and read.kind[k] == written.kind[at]:
                break
            if end[at]:
                raise SolveError(f"{place(read, k)}: the program prints another pose than the one that was solved")
            at += 1
        if at == len(written):
            raise SolveError(f"{place(read, k)}: this pose was not solved")
        rows.append(done.row[at])
        poses.append(k)
        at += 1
    if at != len(written):
        raise SolveError(f"{read.source}: {len(written) - at} poses are missing in the program")
    return np.array(rows), np.array(poses, dtype=np.intp)


def _stand_there(read: Toolpath, poses: Index, written: Program) -> bool:
    """Whether ``poses`` of a program that was read are all of ``written``, one for one."""
    off = np.linalg.norm(read.position[poses] - written.position, axis=1)
    near = (read.kind[poses] != CUT) | (off <= PRINTED)
    return bool(np.all(near & (read.kind[poses] == written.kind)))


def _between(done: FilteredProgram, read: Toolpath, row: Floats, pose: Index) -> Frame:
    """(N) commanded TCP (work object) of the written program at every solved pose."""
    position, rotation = read.position, _rotations(read, row, pose, done)
    rapid = pose[read.kind[pose] != CUT]
    if len(rapid):  # as in the source; those of joint moves are not poses
        at = np.searchsorted(done.row, row[read.kind[pose] != CUT])
        position = position.copy()
        position[rapid] = done.program.position[at]
        rotation = with_others(rotation, rapid, rotation=done.program.rotation[at])
    rows = np.interp(np.arange(len(read)), pose, row)
    first = np.concatenate([[0], pose[:-1]])
    for start, end in zip(first.tolist(), pose.tolist(), strict=True):
        if end - start > 1 and read.kind[end] == CUT:  # points of an arc
            a, b = rows[start], rows[end]
            rows[start + 1 : end] = a + (b - a) * (read.row[start + 1 : end] - read.row[start])
    used = np.zeros(len(read), dtype=bool)
    used[pose] = True
    used[read.kind == CUT] = True
    at_used = np.flatnonzero(used)
    rows, wanted = rows[at_used], done.result.path.toolpath.row

    def made(chosen: Index) -> Frame:
        b = np.clip(np.searchsorted(rows, wanted[chosen] - 1e-12), 1, len(rows) - 1)
        t = np.clip((wanted[chosen] - rows[b - 1]) / np.maximum(rows[b] - rows[b - 1], 1e-12), 0.0, 1.0)
        ends, which = np.unique(np.concatenate([at_used[b - 1], at_used[b]]), return_inverse=True)
        q, p = quaternion_from_matrix(rotation.take(ends).rotation), position[ends]
        first, last = which[: len(b)], which[len(b) :]
        mixed = p[first] + t[:, None] * (p[last] - p[first])
        return Frame(matrix_from_unit_quaternion(slerp_quaternion(q[first], q[last], t)), mixed)

    return MadeFrames(len(wanted), made)


def _rotations(read: Toolpath, row: Floats, pose: Index, done: FilteredProgram) -> Frame:
    """(K) turned as read; where the language gives the tool axis alone, its turn is that of the solve."""

    def turned_as_read(rows: Index) -> Floats:
        some = np.empty((len(rows), 4)) if read.quaternion is None else read.quaternion[rows]
        known = np.isfinite(some[:, :1])
        return matrix_from_unit_quaternion(np.where(known, some, np.array([1.0, 0.0, 0.0, 0.0])))

    def turned_as_solved(rows: Index) -> Floats:
        at = np.searchsorted(done.row, np.interp(rows, pose, row), side="left")
        solved = done.program.rotation[np.minimum(at, len(done.row) - 1)]
        z = -read.axis[rows]
        x = solved[:, :, 0] - z * np.sum(solved[:, :, 0] * z, axis=1, keepdims=True)
        x /= np.linalg.norm(x, axis=1, keepdims=True)
        return np.stack([x, np.cross(z, x), z], axis=2)

    turned = turned_as_solved if read.quaternion is None else turned_as_read
    return MadeFrames(len(read), lambda rows: Frame(turned(rows), np.zeros((len(rows), 3))))
