"""The collisions of a path in a JSON report."""

from __future__ import annotations

from compensator.report.json.text import MM, Report
from compensator.scene.path_collisions import PathCollisions

NEAREST = 5  # pairs that are listed whether they come near or not


def collisions_report(found: PathCollisions) -> Report:
    """What was looked at, what touches and what comes near; poses count from 0, lines are those of the source."""
    touching, rest = found.contacts, [a for a in found.approaches if a.least is not None]
    nearest = sorted(rest, key=lambda a: a.least or (0.0, 0))
    listed = [a for k, a in enumerate(nearest) if a.near or k < NEAREST]
    lines = found.toolpath.line
    return {
        "checked": found.checked,
        "n_bodies": len(found.bodies.all),
        "n_pairs": len(found.approaches),
        "n_looks": sum(a.looks for a in found.approaches),
        "contacts": [
            {
                "bodies": list(found.names(a)),
                "pose": a.contacts[0],
                "source_line": int(lines[a.contacts[0]]),
                "count": len(a.contacts),
                "refused": found.refuses(a),
            }
            for a in touching
        ],
        "nearest": [
            {
                "bodies": list(found.names(a)),
                "distance_mm": a.least[0] * MM,
                "pose": a.least[1],
                "source_line": int(lines[a.least[1]]),
                "within_margin": bool(a.near),
            }
            for a in listed
            if a.least is not None
        ],
        "outlines": found.bodies.source,
        "not_checked": found.bodies.missing,
    }
