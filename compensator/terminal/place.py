"""What the terminal shows of a study of placements."""

from __future__ import annotations

from compensator.tasks.place import Placed
from compensator.terminal.screen import print_written, screen, table

_SHOWN = (
    ("x", "x_mm", "{:.0f}"), ("y", "y_mm", "{:.0f}"), ("z", "z_mm", "{:.0f}"), ("yaw", "yaw_deg", "{:.0f}"),
    ("turn", "turn_deg", "{:.0f}"), ("deflection", "deflection_mean_mm", "{:.3f}"), ("sd", "sd_mm", "{:.3f}"),
    ("reversals/m", "reversals_per_m", "{:.1f}"), ("speed", "speed_share", "{:.0%}"),
    ("N/µm", "stiffness_n_per_um", "{:.2f}"), ("score", "score_mm", "{:.4f}"),
)  # fmt: skip


def show_place(done: Placed) -> None:
    """Counts and the ten best."""
    console, r = screen(), done.report
    if console is None:
        return
    counts = ", ".join(f"{n:,} {name}" for name, n in r["status"].items())
    console.print(f"{r['n_placements']:,} placements: {counts}", highlight=False)
    best = table("mm, deg", *(name for name, _, _ in _SHOWN), right=range(1, len(_SHOWN) + 1))
    for k, row in enumerate(r["ranked"], start=1):
        shown = ("-" if row[key] is None else words.format(row[key]) for _, key, words in _SHOWN)
        best.add_row(str(k), *shown)
    console.print(best)
    print_written(console, done.files)
