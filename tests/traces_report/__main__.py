"""python -m tests.traces_report [--only TEXT] [--flow ...] [--keep FOLDER] [--out FILE]"""

from __future__ import annotations

import argparse
import pickle
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from tests.traces_report.case import FLOWS, Row, run
from tests.traces_report.causes import scenarios
from tests.traces_report.judge import misses
from tests.traces_report.table import markdown

HEAD = "<!-- made by python -m tests.traces_report: do not edit below -->\n"


def main(arguments: Sequence[str] | None = None) -> None:
    """Run what was asked for, one case after the other; print the tables, or put them below the head of a page."""
    asked = _parser().parse_args(arguments)
    with tempfile.TemporaryDirectory() as folder:
        text = markdown(_rows(asked, Path(asked.keep or folder)))
    if not asked.out:
        print(text)
        return
    page = Path(asked.out)
    words = page.read_text(encoding="utf-8").partition(HEAD)[0] if page.exists() else "# Traces report\n\n"
    page.write_text(f"{words}{HEAD}\n{text}", encoding="utf-8")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m tests.traces_report", description=__doc__)
    parser.add_argument("--only", default="", help="cases whose kind and name contain this text")
    parser.add_argument("--flow", nargs="+", choices=FLOWS, default=FLOWS, help="where the model at hand comes from")
    parser.add_argument("--keep", help="folder of rows that were made: they are not made again")
    parser.add_argument("--made", action="store_true", help="only rows that --keep has: none is made")
    parser.add_argument("--out", help="page to write; default: print")
    return parser


def _rows(asked: argparse.Namespace, keep: Path) -> list[Row]:
    keep.mkdir(parents=True, exist_ok=True)
    out = []
    for scenario in scenarios():
        for flow in asked.flow:
            name = f"{scenario.kind} {scenario.name} {flow}"
            within = flow == "sheet" and any(c.effect == "joint-stiffness" for c in scenario.causes)
            if asked.only not in name or within:  # a data sheet leaves so much open: nothing has moved
                continue
            kept = keep / f"{name.replace(' ', '_')}.row"
            if asked.made and not kept.exists():
                continue
            if not kept.exists():
                seed = int(name.split()[2]) + 10 * FLOWS.index(flow) if not scenario.causes else 1
                kept.write_bytes(pickle.dumps(run(scenario, flow, keep, seed=seed)))
            row: Row = pickle.loads(kept.read_bytes())  # own file
            wrong = "; ".join(misses(row)) or "met"
            print(f"{name}: {row.verdict}, {wrong} ({row.seconds:.0f} s)", file=sys.stderr, flush=True)
            out.append(row)
    return out


if __name__ == "__main__":
    main()
