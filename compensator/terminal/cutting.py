"""What the terminal shows of a material that was made of measured forces."""

from __future__ import annotations

from compensator.tasks.cutting import MadeMaterial
from compensator.terminal.screen import print_written, screen, table


def show_material(done: MadeMaterial) -> None:
    """A row per coefficient."""
    console, r = screen(), done.report
    if console is None:
        return
    rows = table("", "value", "standard deviation", "unit", right=(1, 2), title="cutting force")
    for name, value in r["coefficients"].items():
        unit = "N/mm" if name.endswith("e") else "N/mm2"
        shown = ("not determined", "") if value is None else (f"{value:.4g}", f"{r['sd'][name]:.2g}")
        rows.add_row(name, *shown, unit)
    console.print(rows)
    print_written(console, done.files)
