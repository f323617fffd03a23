"""Filter in place: a program comes back with other poses, and which of them it needs."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from compensator.cell.placement import Placement
from compensator.program.export import program_of, program_poses, refuse_lost_axes
from compensator.program.filtered_program import TURNED, FilteredProgram, verify_filtered
from compensator.program.maker import MadeProgram, ProgramMaker
from compensator.solve.compensation import Compensation
from compensator.solve.upright import largest_tilt, without_tilt
from compensator.solve.verify import Verified
from toolpaths.columns import MadeColumn, blocks, give_back
from toolpaths.errors import WriteError
from toolpaths.files import refuse_own
from toolpaths.finding import WARNING, Finding
from toolpaths.frame import Frame
from toolpaths.languages.table import Language
from toolpaths.program_files import ProgramFiles
from toolpaths.rotation import quaternion_from_matrix, slerp_quaternion
from toolpaths.toolpath import CUT, Toolpath
from toolpaths.writing.program import Program

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]

SHARE = 0.5  # of sampling.chord that the path between two written poses may miss the solve


@dataclass(frozen=True)
class FilterInPlace(ProgramMaker):
    """The source itself, with other poses.

    Attributes:
        source: the files of the source.
        beside: names of those besides the main one that hold moves.
        rows: ``row`` of the poses that its reader gave.
        stamp: what the head of the program tells.
    """

    source: ProgramFiles
    rows: Floats
    language: Language
    beside: tuple[str, ...] = ()
    stamp: tuple[str, ...] = ()
    in_place = True

    @property
    def file(self) -> Path:
        """The main file of the source."""
        return self.source.main

    def check(self, placement: Placement, toolpath: Toolpath, program: Path) -> None:
        """Names and words of the source stay: so its other files keep their names, and its folder is refused."""
        refuse_lost_axes(placement, self.language, program)
        if self.beside and program.resolve().parent == self.file.resolve().parent:
            shown = ", ".join(self.beside[:3]) + (" ..." if len(self.beside) > 3 else "")
            raise WriteError(
                f"{program}: other files of the program change, too ({shown}); they are written beside it under their "
                "own names. Name a program in another folder"
            )

    def write(self, c: Compensation, staged: Path) -> FilteredProgram:
        source = self.file.read_bytes()
        left: tuple[Finding, ...] = ()
        if not self.language.filter.says_turns(source):
            c, left = without_tilt(c), _left_tilted(c, self.file)
        index = needed_poses(c, self.rows)
        program = replace(program_of(c, poses=_as_written(c)), wrench=None, stamp=self.stamp)  # no program tells it
        program = _taken(program, index)
        give_back()
        row = c.path.toolpath.row[index]
        rewritten = self.language.rewrite(
            source, program, row=row, path=self.file, machine=c.job.placement.machine, others=self.source.others
        )
        staged.write_bytes(rewritten.text)
        files = [staged]
        for name, data in rewritten.beside:
            files.append(staged.with_suffix(name) if name.startswith(".") else staged.with_name(name))
            if files[-1] in files[:-1]:
                raise WriteError(f"{staged.name}: a file of the program has this name, give the main one another")
            files[-1].write_bytes(data)
        found = (*rewritten.changes, *left, *_unused_events(c.job.placement, self.file))
        return FilteredProgram(
            tuple(files), found, result=c, program=program, row=row, language=self.language, kept=rewritten.kept
        )

    def verify(self, made: MadeProgram, shown: Path) -> Verified:
        if not isinstance(made, FilteredProgram):
            raise TypeError(f"{made} was not written by a filter")
        return verify_filtered(made, shown)


def filter_of(
    files: ProgramFiles, source: Toolpath, language: Language, stamp: tuple[str, ...] = ()
) -> FilterInPlace | None:
    """The filter for ``files``, read as ``source``; None where another language is to be written.

    Args:
        stamp: what the head of the program shall tell.

    Raises:
        WriteError: the program holds what no filter can keep; names the line.
    """
    if source.language != language.name or not language.filtered:
        return None
    language.filter.check(files.main.read_bytes(), files.main)
    with_moves = [] if source.file is None else np.unique(source.file[source.file > 0]).tolist()
    beside = [Path(source.sources[k]) for k in with_moves]
    for path in beside:
        refuse_own(path, language.name)
    names = tuple(path.name for path in beside)
    return FilterInPlace(source=files, rows=source.row, language=language, beside=names, stamp=stamp)


def _unused_events(placement: Placement, toolpath: Path) -> tuple[Finding, ...]:
    """[program.events] is for programs that are written anew."""
    if not placement.program.events:
        return ()
    what = "the file keeps its own words for the machine: [program.events] of the cell is not used"
    return (Finding(WARNING, str(toolpath), what),)


def _left_tilted(c: Compensation, toolpath: Path) -> tuple[Finding, ...]:
    """What a program without words for the tool's axis leaves."""
    off, k = largest_tilt(c)
    if off <= TURNED:
        return ()
    what = f"the deflection tilts the tool by up to {np.degrees(off):.2g} deg, which a file without tool vectors "
    remedy = "Positions are corrected; write a program in the robot's language to have the tilt corrected, too"
    return (Finding(WARNING, c.path.toolpath.where(k), what + "cannot take back", remedy),)


def needed_poses(c: Compensation, rows: Floats) -> Index:
    """Poses that have to stand in the program: those of the source, and of the others those without which the straight
    way between them misses the solve."""
    toolpath = c.path.toolpath
    cut = toolpath.kind == CUT
    source = np.isin(toolpath.row, rows)
    keep = source & (cut | np.concatenate([cut[1:], [False]]))
    p, q = _places_and_turns(_as_written(c))
    bound = SHARE * c.job.placement.sampling.chord * 1e-3
    while True:
        kept = np.flatnonzero(keep)
        rest = np.flatnonzero(cut & ~keep)
        if not len(rest):
            break
        segment = np.searchsorted(kept, rest) - 1
        off = _missed(toolpath.row, p, q, a=kept[segment], k=rest, b=kept[segment + 1], bound=bound)
        order = np.lexsort((-off, segment))
        worst = order[np.concatenate([[True], np.diff(segment[order]) != 0])]
        worst = worst[off[worst] > 1.0]
        if not len(worst):
            break
        keep[rest[worst]] = True
    return np.flatnonzero(keep)


def _missed(row: Floats, p: Floats, q: Floats, *, a: Index, k: Index, b: Index, bound: float) -> Floats:
    """(M,) how far pose k lies off the straight way from pose a to pose b, in units of what is allowed."""
    t = (row[k] - row[a]) / (row[b] - row[a])
    off = np.linalg.norm(p[k] - p[a] - t[:, None] * (p[b] - p[a]), axis=1)
    way = slerp_quaternion(q[a], q[b], t)
    turned = 2.0 * np.sqrt(np.maximum(0.0, 1.0 - np.minimum(np.sum(way * q[k], axis=1) ** 2, 1.0)))
    return np.asarray(np.maximum(off / bound, turned / TURNED))


def _as_written(c: Compensation) -> Frame:
    """(N) TCP in the work object: commands at cuts; rapids stay where the source has them."""
    nominal, cut = program_poses(c, corrected=False), c.cutting

    def change(commanded: Frame, rows: Index) -> Frame:
        stays, here = nominal.take(rows), cut[rows]
        rotation = np.where(here[:, None, None], commanded.rotation, stays.rotation)
        return Frame(rotation, np.where(here[:, None], commanded.origin, stays.origin))

    return program_poses(c).mapped(change)


def _places_and_turns(frames: Frame) -> tuple[Floats, Floats]:
    """(N, 3) m and quaternions (N, 4) of N frames."""
    place, turn = np.empty((frames.count, 3)), np.empty((frames.count, 4))
    for b in blocks(frames.count):
        some = frames.take(b)
        place[b], turn[b] = some.origin, quaternion_from_matrix(some.rotation)
    return place, turn


def _taken(program: Program, index: Index) -> Program:
    """Some poses of a program, without its comments."""
    n = len(program)
    if len(index) == n:
        return replace(program, comments=())
    arrays = {f.name: getattr(program, f.name) for f in fields(program) if f.name not in ("workobject", "start_joints")}
    arrays |= {name: _of(arrays[name]) for name in ("joints", "nominal_joints") if arrays[name] is not None}
    per_pose: dict[str, Any] = {
        name: value.rows(index) if isinstance(value, MadeColumn) else value[index]
        for name, value in arrays.items()
        if isinstance(value, np.ndarray | MadeColumn) and len(value) == n
    }
    return replace(program, **per_pose, comments=())


def _of(values: Floats) -> MadeColumn:
    """A column that is kept elsewhere."""
    return MadeColumn(len(values), lambda rows: values[rows])
