"""Trace: a measurement of a program that ran, read from files of schema ``trace/1`` as a session of path readings.

All checks stand at this door. What comes out is in SI and in the base: commands and programmed wrenches of all rows,
and the readings with the rows that they were taken at.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from compensator.cell.cell_file import Cell, load_cell
from compensator.errors import TraceError
from compensator.trace.made_by import at_rows, with_contacts
from compensator.trace.program_rows import RunsWith, read_program
from compensator.trace.stream import with_rows
from compensator.trace.thinning import thinned
from compensator.trace.trace_file import BallbarTable, TraceFile, read_trace_file
from compensator.trace.trace_samples import TraceSamples, read_trace_samples
from stiffness.errors import RobotError
from stiffness.memory.last_direction import last_direction
from stiffness.robot.load import load_robot
from stiffness.robot.robot import Robot
from stiffness.session.file import Instruments, Reflector, SessionTool
from stiffness.session.loads import Loads
from stiffness.session.path_trace import FAR, CommandedRows, PathTrace, first_signs
from stiffness.session.samples import Samples
from stiffness.session.session import Session
from stiffness.session.table import read_table
from stiffness.statics.tool import Tool
from stiffness.text_file import file_bytes

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

STRETCHES = 20  # equal parts of a path by length, a fifth of which is held out
FEW = 200  # readings of a run: with fewer there are half as many stretches
AS_FAST = (0.5, 2.0)  # times the programmed feed: readings of an arm at rest are ten times as slow, or more
OF_THE_DEVICE = ("start_angle", "overshoot", "data_arc")
NOMINAL = 20.0  # deg C, at which lengths hold (ISO 1)


def load_trace(path: str | Path) -> Session:
    """Read a trace with its cell, its program and its samples.

    ``gravity`` and ``reference_temperature`` that the cell does not give are those of the model that the trace is
    compared with: ``in_terms_of`` puts them in.

    Raises:
        TraceError, CellError, SessionError: names file, row, column, value and what to do.
    """
    file = read_trace_file(path)
    cell = load_cell(file.folder / file.cell, model_needed=False)
    robot, tool = _robot(cell), _tool(file, cell)
    if file.approach is not None and len(file.approach) != robot.n:
        raise TraceError(f"{file.source}: approach has {len(file.approach)} numbers, expected {robot.n}: one per joint")
    if cell.workobject.xyz is None:
        raise TraceError(f"{file.source}: {cell.source} has no [workobject]: the frame that the program is written in")
    workobject = cell.workobject.frame()
    start = None if cell.start is None else np.radians(cell.start.joints)
    given = RunsWith(
        robot=robot, tool=tool, workobject=workobject, start=start, approach=file.approach, dry=file.dry
    )
    rows, program_sha = read_program(str(file.folder / file.program), file.folder / file.program, given)
    label = str(file.folder / file.samples)
    raw = file_bytes(f"{file.source}: samples = {file.samples!r}", file.folder / file.samples, TraceError)
    samples = read_trace_samples(read_table(label, raw), file.kind, rows, file.instrument.noise / 1e3)
    count = len(samples)
    samples, by_shape, matched = _matched(file, cell, samples=samples, rows=rows, label=label)
    samples = samples.take(thinned(at_rows(samples), samples.run, rows))
    path_trace = _path(file, cell, rows=rows, samples=samples, count=count)
    if matched:
        # a place that the shape tells has no lag that could show
        path_trace = replace(
            path_trace, notes=(*path_trace.notes, matched), lagging=path_trace.lagging and not by_shape
        )
    digest = hashlib.sha256(raw).hexdigest()
    return Session(
        source=file.source,
        samples_file=label,
        sha256={"session": program_sha, "samples": digest},
        robot=robot,
        robot_name=_beside(cell, file),
        base=cell.base,
        tip=cell.tip,
        gravity=cell.gravity or "uncompensated",
        registered=file.registered,
        reference_temperature=None,
        tool=SessionTool(
            name=tool.name,
            rotation=tool.rotation,
            position=tool.position,
            mass=tool.mass if tool.com is not None or tool.mass else None,
            com=tool.com,
        ),
        wrench_frame=None,
        wrench_about=None,
        reflectors=(Reflector(name="tcp", link=robot.n, position=tool.position, exact=True, group=None),),
        instruments=Instruments(file.instrument.noise / 1e3, None, 0.0, 0.0),
        purposes={},
        samples=_samples(file, cell, read=samples, path=path_trace, tool=tool),
        not_numeric=samples.not_numeric,
        path=path_trace,
    )


def _matched(
    file: TraceFile, cell: Cell, *, samples: TraceSamples, rows: CommandedRows, label: str
) -> tuple[TraceSamples, bool, str]:
    """Samples with their rows, whether the shape of the path told these, and a note on how they were found."""
    if samples.index is not None:
        return samples, False, ""
    if file.kind == "surface":
        made, note = with_contacts(samples, rows, cell, label)
        return made, False, note
    if file.instrument.latency is not None:
        raise TraceError(
            f"{file.source}: instrument.latency is of time against index, and {label} has no index: take it out"
        )
    stream = with_rows(samples, rows, label, registered=file.registered)
    return stream.samples, not stream.by_feed, stream.note


def _robot(cell: Cell) -> Robot:
    try:
        return load_robot(cell.robot, folder=cell.folder, base=cell.base, tip=cell.tip)
    except RobotError as e:
        raise TraceError(f"{cell.source}: robot = {cell.robot!r}: {e}") from e


def _tool(file: TraceFile, cell: Cell) -> Tool:
    if cell.tool is not None:
        return cell.tool.tool()
    if len(cell.tools) == 1:
        return next(iter(cell.tools.values())).tool()
    what = "no [tool]" if not cell.tools else f"tools {', '.join(map(str, cell.tools))}, and a csv program calls none"
    raise TraceError(f"{file.source}: {cell.source} has {what}: give the one [tool] that the program ran with")


def _beside(cell: Cell, file: TraceFile) -> str:
    """The robot as a file beside the trace would name it."""
    there = cell.folder / cell.robot
    return Path(os.path.relpath(there, file.folder)).as_posix() if there.exists() else cell.robot


def _path(file: TraceFile, cell: Cell, rows: CommandedRows, samples: TraceSamples, count: int) -> PathTrace:
    index = at_rows(samples)
    travelled = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(rows.position, axis=0), axis=1))])
    length = rows.at(travelled, index)
    bar = file.ballbar or BallbarTable(center=(0.0, 0.0, 0.0), radius=100.0)
    workobject = cell.workobject.frame()
    surface = file.kind == "surface"
    return PathTrace(
        kind=file.kind,
        rows=rows,
        index=index,
        run=samples.run,
        length=length,
        stretch=_stretch(length, samples.run),
        gravity=cell.mount.gravity_in_base(),
        normal=workobject.along(samples.normal) if surface else np.zeros((len(samples), 3)),
        point=workobject.at(samples.read[:, :3]) if surface else np.zeros((len(samples), 3)),
        centre=np.array(bar.center) / 1e3,
        radius=bar.radius / 1e3,
        calibrated=bar.calibrated,
        length_sd=bar.length_sd / 1e3,
        probe_sd=0.0 if file.probe is None or file.probe.calibrated else file.probe.offset_sd / 1e3,
        dry=file.dry,
        latency=file.instrument.latency,
        lagging=file.instrument.latency is None and _in_motion(rows, samples),
        process=cell.process.names(),
        gravity_told=cell.gravity is not None,
        given=count,
        sources={},
        notes=_notes(file, rows, count, len(samples)),
    )


def _in_motion(rows: CommandedRows, samples: TraceSamples) -> bool:
    """Whether readings have a time, and follow each other as fast as the feed: then a lag shows in them."""
    if samples.index is None or not np.isfinite(samples.time).all() or not np.isfinite(rows.feed).any():
        return False
    order = np.lexsort((samples.time, samples.run))
    index, same = samples.index[order], np.diff(samples.run[order]) == 0
    way = np.linalg.norm(np.diff(rows.at(rows.position, index), axis=0), axis=1)
    took = np.diff(samples.time[order])
    feed = rows.feed[np.ceil(index[1:]).astype(np.int64)]
    told = same & (took > 0) & (way > 0) & np.isfinite(feed)
    if not told.any():
        return False
    ratio = float(np.median(way[told] / took[told] / feed[told]))
    return AS_FAST[0] < ratio < AS_FAST[1]


def _stretch(length: Floats, run: Ints) -> Ints:
    """(N,) which of equal parts of the path, by length, a reading lies in."""
    most = max(np.bincount(np.unique(run, return_inverse=True)[1]))
    parts = STRETCHES if most >= FEW else STRETCHES // 2
    low, high = float(length.min()), float(length.max())
    share = (length - low) / max(high - low, 1e-12)
    return np.minimum((share * parts).astype(np.int64), parts - 1)


def _notes(file: TraceFile, rows: CommandedRows, given: int, taken: int) -> tuple[str, ...]:
    notes = []
    if taken < given:
        notes.append(
            f"{file.source}: {taken} of {given} samples take part: evenly along the path and all about the turning "
            "points of the joints; what is left out lies between neighbours of the same flanks"
        )
    if not rows.first.any():
        notes.append(
            f"{file.source}: from where the arm came to row 0 is not known: the cell has no [start], the trace no "
            "approach; the flanks of joints are not known before their first turning point"
        )
    return (*notes, *_device_notes(file))


def _device_notes(file: TraceFile) -> list[str]:
    """What the device tells of its run and no sample needs."""
    told = {} if file.ballbar is None else {k: getattr(file.ballbar, k) for k in OF_THE_DEVICE}
    listed = ", ".join(f"{key} = {value:g}" for key, value in told.items() if value is not None)
    if not listed:
        return []
    return [f"{file.source}: [ballbar] {listed} deg, as the device has it: samples count by index, none is cut off"]


def _samples(file: TraceFile, cell: Cell, read: TraceSamples, path: PathTrace, tool: Tool) -> Samples:
    count, n, rows = len(read), path.rows.q.shape[1], path.rows
    part = path.stretch.max() + 1
    run = np.unique(path.run, return_inverse=True)[1]
    position = np.zeros((count, 3))
    if path.scalar:
        position[:, 0] = read.read[:, -1] + _growth(file)
    else:
        position[:] = read.read
    warm = np.where(np.isfinite(read.temperature), read.temperature, np.nan)
    if cell.temperature is not None:
        warm = np.where(np.isfinite(warm), warm, cell.temperature)
    links = np.full(count, n)
    return Samples(
        line=read.line,
        setup=run * part + path.stretch,
        state=1 + np.argsort(np.lexsort((path.index, run))).astype(np.int64),
        repeat=np.zeros(count, dtype=np.int64),
        block=np.zeros(count, dtype=np.int64),
        q=rows.at(rows.q, path.index),
        reflector=np.zeros(count, dtype=np.int64),
        position=position,
        sd=np.hypot(read.sd[:, None], read.along),
        approach=_approach(rows, path.index),
        step=np.full((count, n), np.nan),
        payload=np.zeros(count),
        time=read.time,
        temperature=warm,
        load=Loads(
            wrench=rows.at(rows.wrench, path.index),
            link=links,
            in_tool=np.zeros(count, dtype=bool),
            point=np.tile(tool.position, (count, 1)),
            point_link=links.copy(),
            at=np.full(count, -1),
        ),
        extra=_columns(read.extra, path),
    )


def _growth(file: TraceFile) -> float:
    """m by which a ball-bar is longer than at 20 deg C: what it shows is that much less than the distance."""
    bar = file.ballbar
    if bar is None or bar.temperature is None or bar.expansion_per_k is None:
        return 0.0
    return bar.radius / 1e3 * bar.expansion_per_k * (bar.temperature - NOMINAL)


def _approach(rows: CommandedRows, index: Floats) -> Ints:
    """(N, n) sign of the last rotation of every joint."""
    move = np.concatenate([FAR * first_signs(rows)[None], np.diff(rows.q, axis=0)])
    at = np.minimum(np.ceil(index).astype(np.int64), len(rows) - 1)
    return last_direction(move)[at].astype(np.int64)


def _columns(extra: Mapping[str, Floats], path: PathTrace) -> dict[str, Floats]:
    """What a residual may follow beside what a session has: further columns of the samples, and those of the path."""
    rows = path.rows
    out = {"arc-length": path.length * 1e3}
    feed = rows.feed[np.minimum(np.ceil(path.index).astype(np.int64), len(rows) - 1)]
    if np.isfinite(feed).any():
        out["feed_mm_min"] = feed * 6e4
    return {**out, **extra}
