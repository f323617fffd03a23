"""Findings of a report with the pose that each of them is about, so that a page can go there."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from compensator.report.json.text import Report
from compensator.report.words.findings import finding_sentences
from toolpaths.toolpath import Toolpath

_POSE = re.compile(r"\bpose (\d+)")


def finding_poses(toolpath: Toolpath, report: Report) -> Iterator[tuple[str, str, int | None]]:
    """Level, sentence, and index of the pose in ``toolpath`` (None: the whole run) of every finding."""
    for finding, sentence in zip(report["findings"], finding_sentences(report), strict=True):
        yield finding["level"], sentence, _pose(toolpath, finding)


def _pose(toolpath: Toolpath, finding: Report) -> int | None:
    """By the line of the source; where several poses have it, by the number in words, which may count other poses."""
    line, found = finding.get("source_line"), _POSE.search(str(finding["where"]))
    number = None if found is None else int(found[1])
    if line is None:
        return number if number is not None and number < len(toolpath) else None
    rows: npt.NDArray[np.intp] = np.flatnonzero(toolpath.line == line)
    if not len(rows):  # no move, such as a word for the spindle: the first move behind it
        behind = toolpath.file is None and finding["kind"] not in ("cell", "model") and line <= toolpath.line.max()
        return int(np.argmax(toolpath.line > line)) if behind else None
    return int(rows[0] if number is None else rows[np.argmin(np.abs(rows - number))])
