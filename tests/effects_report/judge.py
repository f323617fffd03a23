"""Whether a row meets the target, and what was said where it does not."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from tests.effects_report.case import KINDS, Row

CLOSE = 1.05  # after over told the truth
SURE = 3.0  # standard deviations
INTERVAL = 1.96  # of them, of 95 %
# a law of the plant that is in no catalogue, but that one effect can learn to the digit from enough postures
FITTED = ("kinematic-offset",)  # identify fits it unasked, in all places
LEARNED = {"unknown ripple": "joint-angle-error"}


def kind(row: Row) -> str:
    """Class of a scenario: clean, single, pair, unknown."""
    if not row.truth:
        return "clean"
    if any(effect == "unknown" for effect, _ in row.truth):
        return "unknown"
    return "single" if len(row.truth) == 1 else "pair"


def named(row: Row) -> list[str]:
    """What is wrong with the names; empty when every effect of the truth is there, in its place, and no other."""
    wrong, free = [], list(row.named)
    for effect, where in row.truth:
        if effect == "unknown" or (effect in FITTED and effect in row.at_hand):
            continue
        mine = next((n for n in free if n.effect == effect), None) or next(
            (n for n in free if effect in n.confused_with), None
        )
        if mine is None:
            wrong.append(f"{effect} not named")
            continue
        free.remove(mine)
        if mine.effect == effect and not _words(where) & _words(mine.where):
            wrong.append(f"{effect} named in {' '.join(mine.where)}")
    return wrong + [f"{n.effect} {' '.join(n.where)} invented" for n in free]


def _words(where: tuple[str, ...]) -> set[str]:
    return {"tool" if w == "link-6" else w for w in where}


def misses(row: Row) -> list[str]:
    """Every rule that a row breaks, in words; empty when the target is met."""
    row = _learned(row)
    out = [] if row.verdict == _expected(row) else [f"verdict {row.verdict}"]
    out += named(row)
    if kind(row) == "clean":
        return out + [f"{m} moved" for m in row.moved]
    if kind(row) == "unknown":
        return out + _first(row)
    for k in KINDS if not out and row.told else ():
        if row.told and row.after[k] > CLOSE * row.told[k]:
            out.append(f"{k} {row.after[k] / row.told[k]:.2f} x told")
    return out


def _expected(row: Row) -> str:
    """A model that already has every effect of the truth is adequate."""
    if kind(row) == "unknown":
        return "unexplained"
    return "adequate" if {effect for effect, _ in row.truth} <= set(row.at_hand) else "explained"


def _learned(row: Row) -> Row:
    """An unknown effect that was learned is judged as one of the catalogue, with the noise floor for its reference."""
    found = {n.effect for n in row.named}
    for scenario, effect in LEARNED.items():
        if row.scenario.endswith(scenario) and row.verdict == "explained" and effect in found:
            truth = tuple((effect, w[:1]) if e == "unknown" else (e, w) for e, w in row.truth)
            return replace(row, truth=truth, told=row.floor)
    return row


def _first(row: Row) -> list[str]:
    """An unknown effect: the joint that moves, or the column that it follows, comes first."""
    (where,) = (w for e, w in row.truth if e == "unknown")
    right = {where[0]} | {w if w.startswith("column:") else f"column:{w}" for w in where[1:] if "joint" not in w}
    if not row.points_at:
        return ["points at nothing"]
    return [] if row.points_at[0][0] in right else [f"points at {row.points_at[0][0]} first, not {where[0]}"]


def within(rows: Iterable[Row], deviations: float) -> tuple[int, int]:
    """How many of all numbers that can be compared are so near the truth, and how many there are."""
    every = [abs(z) for row in rows for z in row.distances.values()]
    return sum(z <= deviations for z in every), len(every)
