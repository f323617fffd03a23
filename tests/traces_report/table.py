"""Rows as Markdown: a summary, misses in words, and a table per kind."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from tests.traces_report.case import FLOWS, Row
from tests.traces_report.judge import misses, sort
from tests.traces_report.shop import KINDS

CLASSES = {
    "single": "one cause",
    "pair": "two causes",
    "unknown": "a cause in no catalogue",
    "clean": "nothing wrong",
}


def markdown(rows: Sequence[Row]) -> str:
    """The part of the report that is made."""
    out = ["## Targets", "", "| | " + " | ".join(KINDS) + " |", "|---" * (len(KINDS) + 1) + "|"]
    for name, words in CLASSES.items():
        for flow in FLOWS:
            mine = [r for r in rows if sort(r) == name and r.flow == flow]
            if mine:
                counted = [_met([r for r in mine if r.kind == k]) for k in KINDS]
                out.append(f"| {words}, model: {flow} | " + " | ".join(counted) + " |")
    wrong = [r for r in rows if misses(r)]
    out += ["", "## Missed", ""]
    out += [f"- {r.kind}, {r.scenario}, {r.flow}: {'; '.join(misses(r))}. {_said(r)}" for r in wrong]
    for kind in KINDS:
        out += ["", f"## {kind}", "", *_table([r for r in rows if r.kind == kind])]
    return "\n".join(out) + "\n"


def _met(rows: Sequence[Row]) -> str:
    return f"{sum(not misses(r) for r in rows)} of {len(rows)}" if rows else "-"


def _said(r: Row) -> str:
    return f"Said {r.verdict}: {_named(r)}; {_points(r)}"


def _table(rows: Sequence[Row]) -> Iterator[str]:
    yield "| not as the model has it | model | size | verdict | named | held out, um | target |"
    yield "|---|---|---|---|---|---|---|"
    for r in rows:
        size = f"{r.change:.1f} / {r.left:.1f}" if r.truth else "-"
        told = "-" if r.told is None else f"{1e6 * r.told:.1f}"
        score = f"{1e6 * r.before:.1f} → {1e6 * r.after:.1f}, told {told}"
        met = "**missed**" if misses(r) else "met"
        named = _named(r) if r.verdict != "unexplained" else f"{_named(r)}; *{_points(r)}*"
        yield f"| {r.scenario} | {r.flow} | {size} | {r.verdict} | {named} | {score} | {met} |"


def _named(r: Row) -> str:
    words = []
    for n in r.named:
        alike = f" ~ {', '.join(n.confused_with)}" if n.confused_with else ""
        words.append(f"{'moved: ' if n.moved else ''}{n.effect} {' '.join(n.where)}{alike}")
    return "; ".join(words) or "nothing"


def _points(r: Row) -> str:
    if not r.points_at:
        return "points at nothing"
    what, share, follows = r.points_at[0]
    return f"points at {what} ({100 * share:.0f} %{', ' + follows if follows else ''})"
