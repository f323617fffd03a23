"""Rows as Markdown: a summary of each class, misses in words, and one table per arm and size."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from tests.effects_report.case import Row
from tests.effects_report.judge import INTERVAL, SURE, kind, misses, within

TARGET = 3.0
CLASSES = {
    "single": "one effect",
    "pair": "two effects",
    "unknown": "one in no catalogue, alone or beside another",
    "clean": "nothing wrong",
}
HEAD = ("scenario", "size", "verdict", "named", "displacement, um", "absolute, um", "numbers", "target")

_INTRO = """Made by `make effects-report`. A plant of its own (tests/plant, MuJoCo) is made ill in a known way and
writes session files; the program sees the files only. `diagnose` reads session D (34 set-ups) of the ill cell; session
B (30 other set-ups) took part in nothing. The model at hand comes by three flows:

- **a**: joint stiffness, identified from a session of the healthy cell (36 set-ups);
- **b**: what `identify` makes of D itself by default: right is *adequate* where it has the effect already;
- **c**: joint stiffness off by a factor (60 %, one sigma), with standard deviations that say so, as of a data sheet.

- **size**: what the effect changes in the readings of D / what is left of that once joint stiffnesses have been
  refitted, in noise floors (RMS per axis; of two effects the larger). Sized by the latter; `c`: by the former, where
  the latter is out of reach.
- **displacement, absolute**: RMS per axis on B, model at hand → refined model; *floor*: what data sheets leave for a
  perfect model; *told*: a fit to D that is told which effects there are and where.
- **named**: effects and places; `~`: readings that the diagnosis says cannot tell it from those effects.
- **numbers**: the one farthest from the truth, in its standard deviations, and how many could be compared; of two
  that the readings know together only (a link's twist and the spring of the joint of that axis), the sum.
- **target**: verdict right; every effect named (or the group it is in) in its place and no other; RMS after within
  5 % of told. One in no catalogue: unexplained, the joint that moves or the column it follows first. Nothing wrong:
  adequate, nothing added and nothing moved."""


def markdown(rows: Sequence[Row]) -> str:
    """The whole report."""
    at = [r for r in rows if r.size == TARGET]
    out = ["# Effects report", "", _INTRO, ""]
    if at:
        out += [f"## Targets, at {TARGET:g} times the noise floor", ""]
    for flow in sorted({r.flow for r in at}):
        mine = [r for r in at if r.flow == flow]
        out += [f"### Flow {flow}", "", *_summary(mine), "", *_missed(mine), ""]
    for size in sorted({r.size for r in rows}, key=lambda s: (s != TARGET, s)):
        for arm, flow in dict.fromkeys((r.arm, r.flow) for r in rows):
            mine = [r for r in rows if (r.size, r.arm, r.flow) == (size, arm, flow)]
            if mine:
                target = "" if size == TARGET else " (no target)"
                out += [f"## {arm}, flow {flow}, {size:g} times the noise floor{target}", "", *_table(mine), ""]
    return "\n".join(out)


def _summary(rows: Sequence[Row]) -> list[str]:
    out = []
    for name, words in CLASSES.items():
        mine = [r for r in rows if kind(r) == name]
        if mine:
            met = sum(not misses(r) for r in mine)
            out.append(f"- {words}: {met} of {len(mine)} met")
    counted = [r for r in rows if r.distances and not misses(r)]
    if counted:
        (three, every), (two, _) = within(counted, SURE), within(counted, INTERVAL)
        out.append(
            f"- recovered numbers, of {len(counted)} cases that are met: {three} of {every} within three standard "
            f"deviations ({100 * three / every:.1f} %), {two} within their 95 % interval ({100 * two / every:.1f} %)"
        )
    return out


def _missed(rows: Sequence[Row]) -> list[str]:
    out = []
    for r in rows:
        if misses(r):
            said = f"{r.verdict}: {_named(r)}" + (f"; points at {_points(r)}" if r.points_at else "")
            out.append(f"- {_title(r)} on {r.arm}: {'; '.join(misses(r))}. Said: {said}")
    return ["Not met:", "", *out] if out else ["Every one met."]


def _table(rows: Sequence[Row]) -> Iterator[str]:
    yield "| " + " | ".join(HEAD) + " |"
    yield "|" + "---|" * len(HEAD)
    for r in rows:
        cells: list[str] = [
            _title(r), _size(r), r.verdict, _named(r), _scores(r, "displacement"), _scores(r, "absolute"), _numbers(r),
            _met(r),
        ]  # fmt: skip
        yield "| " + " | ".join(cells) + " |"


def _title(r: Row) -> str:
    return r.scenario if r.truth else f"{r.scenario}, session {r.seed}"


def _size(r: Row) -> str:
    if not r.truth:
        return "-"
    return f"{r.change:.1f} / {r.left:.1f}" + ("c" if r.of == "change" else "")


def _named(r: Row) -> str:
    words = []
    for n in r.named:
        alike = f" ~ {', '.join(n.confused_with)}" if n.confused_with else ""
        words.append(f"{n.effect} {' '.join(n.where)}{alike}")
    if r.verdict == "unexplained":
        words.append(f"*at {_points(r)}*")
    return "; ".join(words + [f"moved: {m}" for m in r.moved]) or "nothing"


def _points(r: Row) -> str:
    what, share, follows = r.points_at[0] if r.points_at else ("nothing", 0.0, "")
    return f"{what} ({100 * share:.0f} %{', ' + follows if follows else ''})"


def _scores(r: Row, k: str) -> str:
    if k not in r.before:
        return "-"
    told = _um(r.told[k]) if r.told else "-"
    return f"{_um(r.before[k])} → {_um(r.after[k])}, floor {_um(r.floor[k])}, told {told}"


def _um(value: float) -> str:
    return f"{1e6 * value:.1f}"


def _numbers(r: Row) -> str:
    if not r.distances:
        return "-"
    worst = max(r.distances, key=lambda k: abs(r.distances[k]))
    return f"{r.distances[worst]:+.1f} {worst} of {len(r.distances)}"


def _met(r: Row) -> str:
    if r.size != TARGET:
        return "(met)" if not misses(r) else "(missed)"
    return "met" if not misses(r) else "**missed**"
