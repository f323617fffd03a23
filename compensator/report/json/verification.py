"""The JSON report of ``verify``: the verdict about a finished program, and what it rests on."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.program.changed_lines import ChangedLine
from compensator.program.provenance import ProgramHead, Provenance
from compensator.report.json.findings import findings_report
from compensator.report.json.path import statistics
from compensator.report.json.text import MM, Report
from toolpaths.finding import ERROR, WARNING, Finding

Floats = npt.NDArray[np.float64]

SCHEMA = "verification/1"
CONFIRMED, EDITED, OTHER = "confirmed", "edited since it was written", "not what was predicted"
SAME = 1e-3  # mm: the micrometre that summaries show
LISTED = 20  # changed lines of a report


@dataclass(frozen=True)
class Standing:
    """A program on the disk.

    Attributes:
        head: what it tells. now: hashes of what was read for it now.
        sealed: whether it is as it was written; None: it has no seal.
        lines: by which it differs from the program that is written now.
    """

    head: ProgramHead
    now: Provenance
    sealed: bool | None
    lines: tuple[ChangedLine, ...]

    @property
    def others(self) -> tuple[str, ...]:
        """Inputs that are not those that the head tells."""
        names = ("version", "cell", "model", "toolpath")
        told = ((name, getattr(self.head, name), getattr(self.now, name)) for name in names)
        return tuple(name for name, before, now in told if before is not None and before != now)

    @property
    def edited(self) -> bool:
        """By hand: its seal is broken, or without a seal it is not what the same inputs give."""
        return self.sealed is False or (self.sealed is None and bool(self.lines))


def verification_report(
    program: str, standing: Standing, *, error: Floats | None, predicted: Floats, why: str = ""
) -> Report:
    """The report.

    Args:
        error: (K,) m at each cutting pose, of the program on the disk; None: it cannot be told, and ``why``.
        predicted: (K,) m, of the program that is written now.
    """
    largest = None if error is None else float(error.max()) * MM
    told = standing.head.error
    expected = float(predicted.max()) * MM if told is None else told
    agrees = largest is not None and largest <= expected + SAME
    verdict = EDITED if standing.edited else CONFIRMED if agrees else OTHER
    found = [*_edits(program, standing), *_changed_inputs(standing), *_errors(program, largest, expected, why)]
    return {
        "schema": SCHEMA,
        "program": program,
        "verdict": verdict,
        "predicted_error_mm": {
            "head": told,
            "program": None if error is None else statistics(error),
            "written_now": statistics(predicted),
        },
        "provenance": standing.now.as_dict(),
        "other_inputs": list(standing.others),
        "sealed": standing.sealed,
        "n_changed_lines": len(standing.lines),
        "changed_lines": [
            {"file": c.file, "line": c.line, "written": c.written, "stands": c.stands}
            for c in standing.lines[:LISTED]
        ],
        "findings": findings_report(found),
    }


def _edits(program: str, s: Standing) -> Iterator[Finding]:
    if not s.edited:
        return
    if not s.lines:
        what = "the seal does not fit: a comment of its head, or an end of a line was changed"
        yield Finding(ERROR, program, what, "Write the program again", kind="program")
    if s.others:  # its lines differ for that reason, too
        what = f"was edited by hand; where cannot be told, because {' and '.join(s.others)} changed, too"
        yield Finding(ERROR, program, what, "Write the program again", kind="program")
        return
    for c in s.lines[:LISTED]:
        what = f"written was {c.written.strip()!r}, now there stands {c.stands.strip()!r}"
        yield Finding(ERROR, f"{c.file}:{c.line}", what, "Write the program again", kind="program")
    if len(s.lines) > LISTED:
        yield Finding(ERROR, program, f"{len(s.lines) - LISTED} more lines were changed", kind="program")


def _changed_inputs(s: Standing) -> Iterator[Finding]:
    for name in s.others:
        what = f"{name} is {getattr(s.now, name)}, the program was written with {getattr(s.head, name)}"
        yield Finding(WARNING, "", what, "Write the program again with what is true now", kind="cell")
    if s.head.cell is None:
        what = "the program has no head that tells what it was made from (a csv has no comments)"
        yield Finding(WARNING, "", what, kind="program")


def _errors(program: str, largest: float | None, expected: float, why: str) -> Iterator[Finding]:
    if largest is None:
        yield Finding(ERROR, program, f"its poses cannot be simulated: {why}", kind="program")
    elif largest > expected + SAME:
        what = f"the predicted error is {largest:.4f} mm, when it was written it was {expected:.4f} mm"
        yield Finding(ERROR, program, what, kind="program")
