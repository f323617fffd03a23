"""What the terminal shows of a stiffness map."""

from __future__ import annotations

from compensator.tasks.stiffness_map import Mapped
from compensator.terminal.screen import print_written, screen, table

_ROWS = (
    ("smallest stiffness", "stiffness_min", "n_per_um", "N/µm"),
    ("largest stiffness", "stiffness_max", "n_per_um", "N/µm"),
    ("largest deflection", "deflection_max", "mm", "mm"),
    ("most moved by K_c", "kc_shift_max", "um", "µm"),
    ("largest nu_p", "nu_p_max", "ratio", ""),
    ("largest nu_r", "nu_r_max", "urad", "µrad"),
)


def show_map(done: Mapped) -> None:
    """Extremes of a map, what is blank, what the result does not know."""
    console, r = screen(), done.report
    if console is None:
        return
    console.print(
        f"{r['n_postures']} postures: {r['n_ok']} ok, {r['n_limit']} beyond a limit, {r['n_singular']} singular, "
        f"{r['n_no_equilibrium']} without equilibrium",
        highlight=False,
    )
    extremes = table("", "value", "at, deg")
    for name, key, unit, shown in _ROWS:
        place = ", ".join(f"{a:g}" for a in r[key]["q_deg"])
        extremes.add_row(name, f"{r[key][unit]:.4g} {shown}", place)
    console.print(extremes)
    print_written(console, done.files)
