"""What is checked of a block before it counts: words that exclude each other, letters that belong to other words."""

from __future__ import annotations

import math

from toolpaths.languages.gcode.codes import ARCS, COMPENSATIONS, CYCLES, GROUP, LONE, TIP_CONTROLS, G
from toolpaths.languages.gcode.words import Words

MOVING = frozenset("XYZIJKRABC")
LENGTHS = TIP_CONTROLS | {G.TOOL_LENGTH, G.TOOL_LENGTH_OFF}
OWN_P = frozenset((G.DWELL, G.TILTED_PLANE, G.OFFSETS_SET))
WITH_P = frozenset((G.BLENDING, G.SYSTEM_MORE, G.SMOOTHING_LEVEL, G.LOOK_AHEAD, G.ACCURACY))
WITH_Q = frozenset((G.BLENDING, G.SMOOTHING))


def check_groups(gs: list[G]) -> None:
    """One word of a modal group in a block."""
    names = [GROUP[g] for g in gs]
    for name in names:
        if names.count(name) > 1:
            words = " ".join(g.word for g in gs if GROUP[g] == name)
            raise ValueError(f"{words}: two words for {name} in one block")


def check_lone(gs: list[G], values: Words) -> None:
    """Words that stand without coordinates."""
    for g in set(gs).intersection(LONE):
        if not values.keys().isdisjoint(MOVING) or (g is G.SMOOTHING_LEVEL and "P" not in values):
            why = "a spline; post arcs or lines" if g is G.SMOOTHING_LEVEL else "with coordinates it is not read"
            raise ValueError(f"{g.word}: {why}")


def check_letters(values: Words, gs: list[G], single: G | None, motion: G) -> None:
    """Letters that mean something only beside another word."""
    keys = values.keys()
    if G.SMOOTHING in gs and ("Q" not in keys or not keys.isdisjoint(MOVING - {"R"})):
        raise ValueError("G5.1: a spline; post arcs or lines")
    if keys.isdisjoint("HPQLD"):
        return
    if "D" in keys and COMPENSATIONS.isdisjoint(gs):
        raise ValueError(f"D{values['D']:g} without G41 or G42")
    if "H" in keys and not LENGTHS.intersection(gs):
        raise ValueError(f"H{values['H']:g} without G43")
    cycle = motion in CYCLES and single is None
    turns = motion in ARCS and single is None
    if "P" in keys and not (single in OWN_P or cycle or turns or WITH_P.intersection(gs)):
        raise ValueError(f"P{values['P']:g}: read only with G2, G3, G4, G54.1, G64 and canned cycles")
    if "Q" in keys and not (cycle or WITH_Q.intersection(gs)):
        raise ValueError(f"Q{values['Q']:g}: read only with G64, G5.1, G73 and G83")
    if "L" in keys and not cycle and single is not G.OFFSETS_SET:
        raise ValueError(f"L{values['L']:g}: read only with canned cycles and M98")


def check_zeros(values: Words) -> None:
    """G10 L2 with zeros declares what holds anyway: the origin is that of the work object."""
    if values.get("L") != 2 or not values.keys() <= set("LPXYZABCRN") or any(values.get(c, 0) for c in "XYZABCR"):
        raise ValueError("G10: it writes offsets into the controller; read is G10 L2 with zeros",
                         "Declare offsets in [machine.systems] of the cell, and take it out.")  # fmt: skip


def tool_number(value: float) -> int:
    """T as a whole number."""
    if not 0 <= value < 1e9 or value != math.floor(value):
        raise ValueError(f"T{value:g}: a whole number from 0 on is expected")
    return int(value)


def cut_off(percent: bool, turns: bool, last: str) -> str:
    """Why a file without an end looks as if a part of it were missing; empty: it does not.

    Args:
        percent: it begins with %.
        turns: the spindle turns at its end.
        last: its last line.
    """
    if percent:
        return "it begins with '%' but does not end with one"
    if turns:
        return "it ends without M2, M30 or M5 while the spindle turns"
    return "it ends without M2 or M30, and without a line end" if last.strip() else ""
