"""What the terminal shows of an axis map."""

from __future__ import annotations

from compensator.report.csv.axis_map import STATUS
from compensator.tasks.axis_map import AxisMapped
from compensator.terminal.screen import print_written, screen, table

_ROWS = (("predicted deflection", "deflection_mm"), ("its standard deviation", "deflection_sd_mm"))


def show_axis_map(done: AxisMapped) -> None:
    """How much of the map is free, and the chosen turn beside the best ones."""
    console, r = screen(), done.report
    if console is None:
        return
    shares = ", ".join(f"{r['share'][w.replace(' ', '_')]:.1%} {w}" for w in STATUS.values())
    whole = len(r["turns_all_along_deg"])
    console.print(
        f"{r['n_poses']} poses x {r['n_turns']} turns: {shares}; {whole} turns serve all along", highlight=False
    )
    means = table("mean over the cut, µm", "chosen", "best constant", "best at each pose", right=range(1, 4))
    for name, key in _ROWS:
        cells = (r[key][k] for k in ("chosen", "best_constant", "best_at_each_pose"))
        means.add_row(name, *("-" if v is None else f"{v * 1e3:.1f}" for v in cells))
    console.print(means)
    print_written(console, done.files)
