"""The tables of docs/closed-loop.md: `python -m tests.closed_loop --out docs/closed-loop.md`, ten minutes an arm."""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from compensator.errors import CompensatorError
from stiffness.errors import StiffnessError
from tests.compensator.ill_cells import PLACES, Errors, Ill, acting, cancelled

TARGET = 0.99
WELL = 0.998  # short of that, it is looked into what limits the result
Row = dict[str, Any]


def row(scenario: str, arm: str, size: float, seed: int, flow: str) -> Row:
    """One ill cell, all of its programs run on the plant. Errors in um."""
    with tempfile.TemporaryDirectory() as folder:
        ill = Ill.make(scenario, arm, Path(folder), size=size, seed=seed, at_once=flow == "b")
        before, joints, found = ill.errors(None), ill.errors(ill.at_hand), ill.diagnosis
        refined = _tried(ill, "refined", before)
        out: Row = {
            "scenario": scenario,
            "arm": arm,
            "size": size,
            "seed": seed,
            "flow": flow,
            "verdict": found.verdict,
            "added": [f"{a.effect} {' '.join(a.where)}" for a in found.added],
            "none": _row(before),
            "joints": _row(joints),
            "refined": refined,
            "cancelled_joints": cancelled(before, joints),
            "cancelled": refined.get("cancelled", 0.0),
        }
        if out["cancelled"] < WELL:
            out |= {which: _tried(ill, which, before) for which in ("told", "quiet")}
        return out


def _tried(ill: Ill, which: str, before: Errors) -> Row:
    try:
        errors = ill.errors(getattr(ill, which))
    except (StiffnessError, CompensatorError) as e:
        return {"problem": str(e).replace(f"{ill.folder}/", "")}
    return {**_row(errors), "cancelled": cancelled(before, errors)}


def _row(e: Errors) -> Row:
    um = {"mean": e.mean, "p95": e.p95, "max": e.max, "doubtful_max": float(np.max(e.doubtful, initial=0.0))}
    return {**{k: 1e6 * v for k, v in um.items()}, "poses": e.poses, "doubtful": len(e.doubtful)}


def table(rows: Sequence[Row]) -> list[str]:
    """Markdown, a line per row."""
    head = ["ill with", "none", "joints", "refined: mean", "p95", "max", "cancelled", "limited by", "doubtful", "found"]
    out = ["| " + " | ".join(head) + " |", "| --- |" + " ---: |" * 8 + " --- |"]
    for r in rows:
        c = r["refined"]
        shown = f"{100 * r['cancelled']:.2f} %"
        if "problem" in c:
            means = [f"{r[k]['mean']:.0f}" for k in ("none", "joints")]
            out.append("| " + " | ".join([r["scenario"], *means, *["-"] * 3, "**refused**", c["problem"]]) + " | | |")
            continue
        doubt = f"{c['doubtful']} of {c['poses'] + c['doubtful']}, {c['doubtful_max']:.0f}" if c["doubtful"] else ""
        cells = [
            r["scenario"],
            f"{r['none']['mean']:.0f}",
            f"{r['joints']['mean']:.0f}",
            *(f"{c[k]:.1f}" for k in ("mean", "p95", "max")),
            shown if r["cancelled"] >= TARGET else f"**{shown}**",
            limits(r),
            doubt,
            ", ".join(r["added"]) or r["verdict"],
        ]
        out.append("| " + " | ".join(cells) + " |")
    return out


def limits(r: Row) -> str:
    """What stands between the result and all of it, where that is more than two parts in a thousand."""
    if r["cancelled"] >= WELL:
        return ""
    told, quiet = r["told"], r["quiet"]
    if "mean" not in told or "mean" not in quiet:
        return "no fit: " + (told.get("problem") or quiet.get("problem"))
    if r["cancelled"] < TARGET <= told["cancelled"]:
        return f"the diagnosis: one who is told the effect cancels {100 * told['cancelled']:.2f} %"
    if quiet["mean"] > 1.5 * r["refined"]["mean"]:
        return f"the fit: one who is told the effect leaves {told['mean']:.1f}, without noise {quiet['mean']:.1f}"
    law = quiet["mean"] / min(told["mean"], r["refined"]["mean"])
    name = "law of the effect" if law > 0.5 else "noise of the session"
    return f"{name}: readings without noise leave {quiet['mean']:.1f}"


def page(text: str, rows: Sequence[Row]) -> str:
    """The page with its tables put between the marks."""
    head, rest = text.split("<!-- table -->\n", 1)
    tail = rest.split("<!-- end -->", 1)[1]
    parts = []
    for arm in dict.fromkeys(r["arm"] for r in rows):
        some = [r for r in rows if r["arm"] == arm]
        good = sum(r["cancelled"] >= TARGET for r in some)
        parts += [f"### {arm}: {good} of {len(some)}", "", *table(some), ""]
    return head + "<!-- table -->\n" + "\n".join(parts) + "<!-- end -->" + tail


def main() -> None:
    """Run, and write the page."""
    parser = argparse.ArgumentParser(prog="python -m tests.closed_loop")
    parser.add_argument("--out", type=Path, help="the page, whose tables are replaced")
    parser.add_argument("--rows", type=Path, help="json lines: what stands there is not run again")
    parser.add_argument("--arm", action="append", choices=list(PLACES))
    parser.add_argument("--only", default="", help="part of a scenario's name")
    parser.add_argument("--size", type=float, default=5.0, help="of the ailment, in noise floors")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--flow", choices=("a", "b"), default="a", help="of a healthy session, or the ill one")
    given = parser.parse_args()
    lines = given.rows.read_text().splitlines() if given.rows and given.rows.exists() else []
    kept = [json.loads(line) for line in lines]
    done = {(r["arm"], r["scenario"], r["size"], r["seed"], r.get("flow", "a")): r for r in kept}
    rows = []
    for arm in given.arm or PLACES:
        for name in (n for n in acting() if given.only in n):
            key = (arm, name, given.size, given.seed, given.flow)
            if key not in done:
                done[key] = row(name, arm, size=given.size, seed=given.seed, flow=given.flow)
                if given.rows:
                    with given.rows.open("a") as stream:
                        stream.write(json.dumps(done[key]) + "\n")
            rows.append(done[key])
            print(*table(rows[-1:])[2:], flush=True)
    if given.out:
        given.out.write_text(page(given.out.read_text(encoding="utf-8"), rows), encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
