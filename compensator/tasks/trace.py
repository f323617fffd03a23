"""What `trace` does, from a file of a measuring device to a trace/1 file and its samples."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from compensator.devices.completion import completed, nominal_points
from compensator.devices.device_text import device_text
from compensator.devices.order import TraceOrder, refuse_incomplete
from compensator.devices.program_rows import program_rows
from compensator.devices.readings import SURFACE
from compensator.devices.samples import SampleTable, samples_of
from compensator.devices.selection import selected
from compensator.devices.table import device_of
from compensator.devices.trace_toml import trace_toml
from compensator.errors import CompensatorError, DeviceError
from compensator.report.json.findings import findings_report
from compensator.report.json.text import as_json
from compensator.report.json.trace import trace_report
from compensator.tasks.outputs import Outputs
from compensator.tasks.run_files import STDOUT, writes
from compensator.tasks.say import Say, quiet
from compensator.tasks.strict import refuse_warnings
from stiffness.text_file import toml_table
from toolpaths.finding import WARNING, Finding, of_kind

BESIDE = "samples.csv"
TOUCHED = "probe-results"  # of a touch probe
USUAL = {"cell": "cell.toml", "program": "run.csv"}


@dataclass(frozen=True, repr=False)
class TraceMade:
    """The samples of a trace, its JSON report, one sentence for people, and the files that were written."""

    samples: SampleTable
    report: dict[str, Any]
    sentence: str
    files: tuple[Path, ...]


@writes("output", "samples", "json")
def trace_file(
    file: Path,
    output: Path,
    *,
    order: TraceOrder,
    cell: Path | None = None,
    program: Path | None = None,
    samples: Path | None = None,
    read_as: str | None = None,
    columns: Sequence[str] = (),
    nominals: Path | None = None,
    json: Path | None = None,
    strict: bool = False,
    say: Say = quiet,
) -> TraceMade:
    """A file of a device in, a trace out.

    Args:
        file: of the device. output: trace/1 file. samples: csv; None: ``samples.csv`` beside the trace.
        order: what the file does not tell.
        cell, program: that ran; None: cell.toml and run.csv beside the trace.
        read_as: name of the device. columns: NAME=HEADING of a csv. nominals: csv of nominal points.

    Raises:
        CompensatorError, StiffnessError: refused by file and line; no output is left behind.
    """
    if output == STDOUT and samples is None:
        raise CompensatorError("-: a trace is two files; name one, or give --samples FILE.csv beside it")
    say(f"reading {file.name}")
    source = device_text(file, _mapping(columns))
    device = device_of(source, read_as)
    given = device.read(source)
    chosen = selected(given, order.group, order.point)
    to_mm = refuse_incomplete(chosen, order)
    if nominals is not None and chosen.kind != SURFACE:
        raise DeviceError(f"{file}: --nominals: its readings are {chosen.kind}, no surface points; leave it out")
    table = None if nominals is None else nominal_points(device_text(nominals))
    whole = completed(chosen, table, to_mm)
    _refuse_other_schema(cell)
    made = samples_of(whole, order, to_mm, None if program is None else program_rows(device_text(program)))
    places = {key: _beside(output, path, USUAL[key]) for key, path in (("cell", cell), ("program", program))}
    found = [*whole.findings, *made.findings, *_absent(output, places)]
    report = trace_report(device.name, made, order, read=len(given), to_mm=to_mm)
    report["findings"] = findings_report(of_kind("device", found))
    refuse_warnings(report, strict)
    text = trace_toml(
        kind=made.kind,
        order=order,
        touched=device.name == TOUCHED,
        samples=BESIDE if samples is None else _beside(output, samples, BESIDE),
        lead=[f"made by `compensator trace` from {file.name}, {device.title}"],
        **places,
    )
    files = _written(output, samples, trace=text, rows=made.csv(), json=json, report=report)
    sentence = f"{device.title}: {len(made)} {made.kind} of {len(given)} readings"
    return TraceMade(made, report, sentence, files)


def _mapping(columns: Sequence[str]) -> dict[str, str]:
    out: dict[str, str] = {}
    for text in columns:
        name, mark, heading = text.partition("=")
        if not (mark and name.strip() and heading.strip()):
            raise DeviceError(f"--column {text}: expected NAME=HEADING, such as x=X_mm, or NAME=NUMBER")
        if name.strip() in out:
            raise DeviceError(f"--column {text}: {name.strip()} is given twice")
        out[name.strip()] = heading.strip()
    return out


def _beside(output: Path, path: Path | None, usual: str) -> str:
    """A path as the trace names it: relative to its folder."""
    if path is None or output == STDOUT:
        return usual if path is None else path.as_posix()
    return Path(os.path.relpath(path.resolve(), output.resolve().parent)).as_posix()


def _absent(output: Path, places: Mapping[str, str]) -> Iterator[Finding]:
    folder = Path() if output == STDOUT else output.parent
    for key, name in places.items():
        if not (folder / name).is_file():
            what = f"{key} = {name!r}: there is no such file beside the trace"
            yield Finding(WARNING, str(output), what, f"Put it there, or give --{key}")


def _refuse_other_schema(cell: Path | None) -> None:
    """A model may be missing in the cell of a trace: it is checked where the trace is used."""
    if cell is not None:
        toml_table(str(cell), cell, DeviceError, schema="cell/1")


def _written(
    output: Path, samples: Path | None, *, trace: str, rows: str, json: Path | None, report: dict[str, Any]
) -> tuple[Path, ...]:
    with Outputs() as outputs:
        with outputs.writing(output, ".toml") as staged:
            staged.write_bytes(trace.encode())
            beside = staged.with_name(BESIDE)
            if samples is None:
                beside.write_bytes(rows.encode())
        files = outputs.add(staged, output, (beside,) if samples is None else ())
        if samples is not None:
            outputs.text(samples, rows)
            files = (*files, samples)
        if json:
            outputs.text(json, as_json(report))
            files = (*files, json)
        outputs.commit()
    return files
