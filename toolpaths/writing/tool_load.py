"""The load of a tool in words, for languages whose programs hold none: whoever runs them has to set it."""

from __future__ import annotations

from toolpaths.tool_frame import ToolFrame
from toolpaths.writing.numbers import number


def load_words(tool: ToolFrame) -> tuple[str, ...]:
    """Mass, and centre of mass in the flange frame, as far as they are known."""
    if tool.mass is None:
        return ()
    if tool.com is None:
        return (f"load {number(tool.mass, 3)} kg",)
    centre = " ".join(number(float(c) * 1e3, 1) for c in tool.com)
    return f"load {number(tool.mass, 3)} kg", f"centre mm {centre}"
