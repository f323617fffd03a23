"""What `place` does: placements of the work object, judged on local processes or a cluster, and the best of them."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from compensator.cell.arm import load_arm
from compensator.cell.cell_file import Cell, load_cell
from compensator.errors import CellError, CompensatorError
from compensator.place.address import host_and_port
from compensator.place.best import Place, cell_table, first_places, seen_from
from compensator.place.candidates import Candidates, box, listed
from compensator.place.parts import Parts, pyarrow, rows_of
from compensator.place.study import Study, study_of
from compensator.place.workers import Done, on_cluster, on_processes
from compensator.report.json.place import place_report
from compensator.report.json.text import as_json
from compensator.solve.planned import sampled
from compensator.tasks.compensate import files_of, read_input
from compensator.tasks.outputs import Outputs
from compensator.tasks.run_files import STDOUT, writes
from compensator.tasks.say import Say, quiet
from compensator.tasks.strict import refuse_warnings
from stiffness.text_file import toml_table

TURNS, POSES = 12, 200
FEWEST = 10  # poses


@dataclass(frozen=True, repr=False)
class Placed:
    """What the task made: columns of the study, the JSON report, the files."""

    columns: dict[str, Any]
    report: dict[str, Any]
    files: tuple[Path, ...]


@writes("output", "png", "best", "json")
def place_file(
    toolpath: Path | Sequence[Path],
    cell: Path,
    output: Path,
    *,
    read_as: str | None = None,
    within: str | None = None,
    places: Path | None = None,
    turns: int = TURNS,
    poses: int = POSES,
    workers: int | None = None,
    scheduler: str | None = None,
    png: Path | None = None,
    best: Path | None = None,
    json: Path | None = None,
    strict: bool = False,
    say: Say = quiet,
) -> Placed:
    """Study where the work object may stand.

    Args:
        within: a box of placements, as ``candidates.box`` reads it; places: or a csv of them.
        turns: about the tool axis. poses: of the path that each placement is judged at.
        workers: local processes; None: one for each core. scheduler: address of a Dask scheduler, in their place.
        best: cell file with the best placement.

    Raises:
        ToolpathError, StiffnessError, CompensatorError: refused; parts that are done stay for the next run.
    """
    _check(output, turns=turns, poses=poses)
    if scheduler is not None:
        host_and_port(scheduler)
    pyarrow()
    began = time.monotonic()
    given, table = read_input(files_of(toolpath, read_as), cell, say), load_cell(cell)
    arm, path = load_arm(table), sampled(given.job.placement, given.path)
    candidates = _candidates(table, within, places)
    say(f"{len(candidates.poses):,} placements of {len(path):,} poses")
    study = study_of(
        arm, given.job, path, candidates, turns=turns, poses=poses, inputs=given.provenance.as_dict()
    )  # fmt: skip
    parts = Parts(output, study.key)
    parts.refuse_other()
    left = [b for b in study.batches if not parts.path(b).exists()]
    for batch, found in _done(study, left, workers=workers, scheduler=scheduler):
        parts.write(batch, rows_of(candidates, batch, found))
        say(f"placement {batch.stop:,} of {len(candidates.poses):,}")
    joined = parts.joined(study.batches)
    columns = {name: joined.column(name).to_numpy() for name in joined.column_names}
    say("following the whole path at the best placements")
    tried = list(first_places(arm, given.job, given.path, columns))
    report = place_report(columns, tried, study, resumed=len(study.batches) - len(left))
    report["provenance"], report["seconds"] = given.provenance.as_dict(), round(time.monotonic() - began, 3)
    refuse_warnings(report, strict)
    with Outputs() as outputs:
        with outputs.writing(output) as staged:
            pyarrow().parquet.write_table(joined, staged)
        outputs.add(staged, output)
        if png:
            _draw(outputs, png, columns, tried)
        if best:
            outputs.text(best, _best_cell(cell, best, columns, tried))
        if json:
            outputs.text(json, as_json(report))
        outputs.commit()
    parts.clear()
    return Placed(columns, report, tuple(f for f in (output, png, best, json) if f))


def _check(output: Path, *, turns: int, poses: int) -> None:
    if output == STDOUT:
        raise CompensatorError("-o -: a study is collected in parts beside its file: name a file")
    if not 1 <= turns <= 72:
        raise CompensatorError(f"--turns {turns}: expected 1 to 72; 12 are 30 deg apart")
    if poses < FEWEST:
        raise CompensatorError(f"--poses {poses}: at least {FEWEST}")


def _candidates(cell: Cell, within: str | None, places: Path | None) -> Candidates:
    if (within is None) == (places is None):
        raise CompensatorError("give either --box, such as x=1200:1800:13,y=-400:400:9, or --list, a csv of placements")
    return box(within, cell.workobject) if within is not None else listed(places or Path())


def _done(study: Study, left: Sequence[range], *, workers: int | None, scheduler: str | None) -> Iterator[Done]:
    if scheduler is not None:
        return on_cluster(study, left, scheduler)
    return on_processes(study, left, workers or os.cpu_count() or 1)


def _draw(outputs: Outputs, png: Path, columns: dict[str, Any], tried: Sequence[Place]) -> None:
    from compensator.report.figures.place import draw

    with outputs.writing(png) as staged:
        draw(columns, [p.row for p in tried if p.holds], staged)
    outputs.add(staged, png)


def _best_cell(cell: Path, target: Path, columns: dict[str, Any], tried: Sequence[Place]) -> str:
    """Text of the new cell, whose files are named as seen from ``target``.

    Raises:
        CompensatorError: no placement holds.
    """
    import tomli_w

    holds = [p.row for p in tried if p.holds]
    if not holds:
        why = f": {tried[0].why}" if tried else ""
        raise CompensatorError(f"no placement of the study serves the whole path, so that there is no best cell{why}")
    raw = toml_table(str(cell), cell, CellError, schema="cell/1")
    head = f"# {cell.name} at the best placement of `compensator place`; comments of the original are left out.\n"
    return head + tomli_w.dumps(seen_from(cell_table(raw, columns, holds[0]), cell.parent, target.parent))
