"""What a benchmark found: rows for the terminal and for JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True)
class Row:
    """One finding.

    Attributes:
        group: headline that it stands under.
        what: what was measured.
        value: the number.
        unit: of the number; ``x`` for a ratio.
        goal: what is aimed for, in words; "" where there is no goal.
    """

    group: str
    what: str
    value: float
    unit: str
    goal: str = ""

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)


def text(rows: Sequence[Row]) -> str:
    """The rows as a table, group by group."""
    lines = []
    width = max(len(r.what) for r in rows)
    group = ""
    for r in rows:
        if r.group != group:
            group = r.group
            lines += ["", group]
        goal = f"   goal {r.goal}" if r.goal else ""
        lines.append(f"  {r.what:<{width}}  {_number(r.value):>12} {r.unit:<12}{goal}".rstrip())
    return "\n".join(lines[1:])


def _number(value: float) -> str:
    if value >= 1000:
        return f"{value:,.0f}"
    return f"{value:.3g}"
