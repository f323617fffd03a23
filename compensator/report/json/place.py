"""The JSON report of ``place``."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from compensator.place.best import LISTED, Place, ranking
from compensator.place.candidates import COLUMNS
from compensator.place.judge import BEYOND, COLLIDES, GOOD, NUMBERS, OUT
from compensator.place.study import Study
from compensator.report.json.findings import findings_report
from compensator.report.json.text import Report
from toolpaths.finding import NOTE, WARNING, Finding

SCHEMA = "place-summary/1"


def place_report(columns: dict[str, Any], tried: Sequence[Place], study: Study, *, resumed: int) -> Report:
    """Counts, the best placements, and which of them was followed along the whole path."""
    count = Counter(columns["status"])
    order = ranking(columns)
    return {
        "schema": SCHEMA,
        "study": study.key,
        "n_placements": len(columns["status"]),
        "n_poses": len(study.path),
        "n_turns": len(study.turns),
        "n_tasks": len(study.batches),
        "n_tasks_resumed": resumed,
        "status": {name: count.get(name, 0) for name in (GOOD, COLLIDES, BEYOND, OUT)},
        "ranked": [_row(columns, int(k)) for k in order[:LISTED]],
        "whole_path": [{"index": int(columns["index"][p.row]), "holds": p.holds, "why": p.why} for p in tried],
        "findings": findings_report([
            *_findings(columns, tried, len(order)), *_held_in_ranking(study), *study.arm.findings
        ]),
    }


def _row(columns: dict[str, Any], k: int) -> Report:
    names = ("index", *COLUMNS, *NUMBERS)
    return {name: _plain(columns[name][k]) for name in names}


def _plain(value: Any) -> Any:
    value = value.item() if isinstance(value, np.generic) else value
    return None if isinstance(value, float) and not np.isfinite(value) else value


def _findings(columns: dict[str, Any], tried: Sequence[Place], good: int) -> list[Finding]:
    if not good:
        counted = Counter(c for c in columns["collision"] if c)
        common = f"; most often {counted.most_common(1)[0][0]} touch" if counted else ""
        what = f"none of {len(columns['status']):,} placements is reachable and free of collisions{common}"
        return [Finding(WARNING, "", what, "Widen --box, or allow more --turns", kind="path")]
    out = []
    for place in tried:
        if not place.holds:
            what = f"placement {columns['index'][place.row]} is good at the poses of the study, not along the whole"
            out.append(Finding(NOTE, "", f"{what} path: {place.why}", kind="path"))
    if tried and not any(p.holds for p in tried):
        what = "none of the ten best placements serves the whole path"
        out.append(Finding(WARNING, "", what, "Take more --poses or a finer --box", kind="path"))
    return out


def _held_in_ranking(study: Study) -> list[Finding]:
    key = study.placement.solve.along_path
    if not key:
        return []
    what = (
        f"{key}: placements are ranked by turns that stay the same along the path and upright "
        "tools; what the key asks for is chosen at the best of them only, along the whole path, and their cell keeps it"
    )
    return [Finding(NOTE, study.placement.source, what, kind="path")]
