"""Print what a JSON summary of ``compensator compensate`` says, for terminals and logs alike."""

from __future__ import annotations

import json
import sys
from pathlib import Path


def main() -> None:
    """Show the file named on the command line."""
    report = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    print(f"{report['n_poses']} poses, {report['n_cut']} of them cutting,", end=" ")
    print(f"{report['inserted_poses']} put in at flank changes")
    print("predicted TCP error, mm         mean     95 %      max")
    for name, key in (("nominal poses commanded", "before"), ("program as written", "after")):
        e = report["predicted_error_mm"][key]
        print(f"  {name:<26}{e['mean']:9.4f}{e['p95']:9.4f}{e['max']:9.4f}")
    print(f"largest correction {report['max_correction_mm']:.3f} mm, {len(report['reversals'])} joint reversals")
    for note in report["notes"]:
        print(f"  note: {note}")


if __name__ == "__main__":
    main()
