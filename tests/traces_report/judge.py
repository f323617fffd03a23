"""Whether a row meets the target, and what was said where it does not."""

from __future__ import annotations

from tests.traces_report.case import Row

CLOSE = 1.10  # after over told the truth


def sort(row: Row) -> str:
    """clean, single, pair, unknown."""
    if not row.truth:
        return "clean"
    if any(effect == "unknown" for effect, _ in row.truth):
        return "unknown"
    return "single" if len(row.truth) == 1 else "pair"


def misses(row: Row) -> list[str]:
    """Every rule that a row breaks, in words; empty when the target is met."""
    if sort(row) == "clean":
        out = [] if row.verdict == "adequate" else [f"verdict {row.verdict}"]
        return out + [f"{n.effect} {' '.join(n.where)} invented" for n in row.named]
    if sort(row) == "unknown":
        out = [] if row.verdict == "unexplained" else [f"verdict {row.verdict}"]
        return out + _first(row)
    if lost(row) and row.verdict == "adequate" and not row.named:
        return []
    out = [] if row.verdict in ("explained", "parameters-changed") else [f"verdict {row.verdict}"]
    out += named(row)
    if row.told is not None and row.after > CLOSE * row.told:
        out.append(f"{row.after / row.told:.2f} x told")
    return out


def lost(row: Row) -> bool:
    """Whether springs that a data sheet leaves open take the cause up: less than the noise is left of it."""
    return row.flow == "sheet" and row.left < 1.0


def named(row: Row) -> list[str]:
    """What is wrong with the names: every cause has to be there, in its place, or in the group of one that is. Of an
    effect in several joints each joint stands for one cause."""
    wrong, met = [], set()
    free = [(n, place) for n in row.named for place in n.where or ("",)]
    for effect, where in row.truth:
        own = [f for f in free if f[0].effect == effect]
        group = [f for f in free if effect in f[0].confused_with]
        mine = next((f for f in (*own, *group) if f[1] in where), None) or next(iter(group), None)
        if mine is not None:
            free.remove(mine)
            met.add(mine[0])
        elif own:
            wrong.append(f"{effect} named in {' '.join(own[0][0].where)}")
            met.add(own[0][0])
        else:
            wrong.append(f"{effect} not named")
    return wrong + [f"{n.effect} {' '.join(n.where)} invented" for n in row.named if not n.moved and n not in met]


def _first(row: Row) -> list[str]:
    """The joint and its speed, or the fixture, the force and the way along the path that move it, come first."""
    (where,) = (w for e, w in row.truth if e == "unknown")
    if not row.points_at:
        return ["points at nothing"]
    what, _, follows = row.points_at[0]
    right = {"edge": {"fixture", "process"}, "slip": {"fixture", "arc-length"}, "rock": {"fixture", "process"}}
    if where[0] == "fixture":
        return [] if what in right[where[1]] else [f"points at {what} first"]
    if what != where[0]:
        return [f"points at {what} first, not {where[0]}"]
    return [] if where[1:] != ("speed",) or "speed of " in follows else [f"follows {follows}, not its speed"]
