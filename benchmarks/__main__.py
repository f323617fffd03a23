"""``python -m benchmarks``: what the product does per second, as ratios measured in one run."""

from __future__ import annotations

import argparse
import json
import os
import platform
from collections.abc import Callable, Iterator
from importlib.metadata import version
from pathlib import Path

# one BLAS thread, as the command line has it
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from benchmarks import (
    commands,
    cut,
    diagnose,
    identify,
    paths,
    place,
    poses,
    reading,
    stages,
    start,
    table,
    traces,
    turns,
)

PARTS = ("start", "paths", "poses", "commands", "identify", "diagnose", "reading", "stages", "cut", "traces", "place")
PARTS += ("turns", "filter")


def main() -> None:
    """Run the parts asked for, print the table, write JSON where asked."""
    options = _options()
    sizes = (10_000, 100_000, commands.LARGE) if options.large else (10_000, 100_000)
    parts: dict[str, Callable[[], Iterator[table.Row]]] = {
        "start": start.run,
        "paths": paths.run,
        "poses": poses.run,
        "commands": lambda: commands.run(sizes),
        "identify": identify.run,
        "diagnose": diagnose.run,
        "reading": reading.run,
        "stages": stages.run,
        "cut": cut.run,
        "traces": traces.run,
        "place": place.run,
        "turns": turns.run,
        "filter": lambda: commands.run_filter((100_000, commands.LARGE) if options.large else (100_000,)),
    }
    rows: list[table.Row] = []
    print(_machine())
    for name in options.parts or PARTS:
        found = list(parts[name]())
        print("\n" + table.text(found), flush=True)
        rows += found
    if options.json:
        report = {"machine": _machine(), "rows": [row.as_dict() for row in rows]}
        options.json.write_text(json.dumps(report, indent=2) + "\n")


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("parts", nargs="*", help="some of the parts; default all")
    parser.add_argument("--large", action="store_true", help="1,000,000 poses as well: minutes, gigabytes")
    parser.add_argument("--json", type=Path, help="write the rows there, too")
    options = parser.parse_args()
    for part in options.parts:
        if part not in PARTS:
            parser.error(f"unknown part {part!r}; there are {', '.join(PARTS)}")
    return options


def _machine() -> str:
    load = f", load {os.getloadavg()[0]:.1f} before" if hasattr(os, "getloadavg") else ""
    libraries = ", ".join(f"{name} {version(name)}" for name in ("casadi", "pin", "numpy"))
    return f"{platform.machine()}, {os.cpu_count()} cores{load}; Python {platform.python_version()}, {libraries}"


if __name__ == "__main__":
    main()
