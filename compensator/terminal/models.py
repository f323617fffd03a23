"""What the terminal shows of a map and of a model that did not come from a session; nothing when piped."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.table import Table

from compensator.tasks.models import Made
from compensator.tasks.stiffness_map import Mapped


def show_map(done: Mapped) -> None:
    """Extremes of a map, what is blank, what the result does not know."""
    console, r = Console(markup=False), done.report
    if not console.is_terminal:
        return
    console.print(
        f"{r['n_postures']} postures: {r['n_ok']} ok, {r['n_limit']} beyond a limit, {r['n_singular']} singular, "
        f"{r['n_no_equilibrium']} without equilibrium",
        highlight=False,
    )
    table = Table()
    for head in ("", "value", "at, deg"):
        table.add_column(head)
    rows = (
        ("smallest stiffness", "stiffness_min", "n_per_um", "N/µm"),
        ("largest stiffness", "stiffness_max", "n_per_um", "N/µm"),
        ("largest deflection", "deflection_max", "mm", "mm"),
        ("most moved by K_c", "kc_shift_max", "um", "µm"),
        ("largest nu_p", "nu_p_max", "ratio", ""),
        ("largest nu_r", "nu_r_max", "urad", "µrad"),
    )
    for name, key, unit, shown in rows:
        place = ", ".join(f"{a:g}" for a in r[key]["q_deg"])
        table.add_row(name, f"{r[key][unit]:.4g} {shown}", place)
    console.print(table)
    for line in r["notes"]:
        console.print(f"  - {line}", highlight=False, style="dim")
    for file in done.files:
        console.print(f"wrote {file}", highlight=False)


def show_made(done: Made) -> None:
    """A row per joint."""
    console, r = Console(markup=False), done.report
    if not console.is_terminal:
        return
    table = Table()
    for head in ("joint", "stiffness, N*m/rad", "standard deviation", "gap, arcmin", "standard deviation"):
        table.add_column(head, justify="left" if head == "joint" else "right")
    for k, (value, sd) in enumerate(zip(r["stiffness_nm_per_rad"], r["stiffness_sd_nm_per_rad"], strict=True)):
        shown = ("not identified", "") if value is None else (f"{value:.4g}", f"{sd:.2g}")
        table.add_row(str(k + 1), *shown, _arcmin(r, "gap_rad", k), _arcmin(r, "gap_sd_rad", k))
    console.print(table)
    for k, held in enumerate(r.get("friction_in_gap", [])):
        if held:
            console.print(
                f"  - joint {k + 1}: no unloading branch: the gap is too small by what friction holds", highlight=False
            )
    for file in done.files:
        console.print(f"wrote {file}", highlight=False)


def _arcmin(report: dict[str, Any], key: str, joint: int) -> str:
    values = report.get(key)
    return "" if values is None or values[joint] is None else f"{values[joint] * 3437.746770784939:.3f}"
