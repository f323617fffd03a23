"""``python -m stiffness.effects`` prints the table of docs/effects.md."""

from __future__ import annotations

from stiffness.effects.docs_table import markdown

print(markdown(), end="")
