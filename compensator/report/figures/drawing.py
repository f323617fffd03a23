"""Drawing: the figures of a page, one by one, so that one that fails costs no other and no number of the report."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from compensator.report.figures.layout import Figure, base_layout, label

Warn = Callable[[str], None]


def silent(_: str) -> None:
    """Takes warnings that nobody asked for."""


def drawn(makers: Mapping[str, Callable[[], Figure]], warn: Warn) -> dict[str, Figure]:
    """The figures by their id; where making one fails, words in its place, and a warning that names it."""
    out = {}
    for name, make in makers.items():
        try:
            out[name] = make()
        except Exception as error:  # whatever it is: the numbers of the report do not depend on a figure
            why = f"{type(error).__name__}: {error}"
            warn(f"figure {name!r} of the report could not be drawn ({why}); everything else is complete")
            out[name] = words_figure(f"This figure could not be drawn ({why}).")
    return out


def words_figure(text: str) -> Figure:
    """A figure that is a sentence."""
    layout = base_layout(120)
    layout |= {"xaxis": {"visible": False}, "yaxis": {"visible": False}}
    layout["annotations"] = [
        {"text": label(text), "showarrow": False, "x": 0.5, "y": 0.5, "xref": "paper", "yref": "paper"}
    ]
    return {"data": [], "layout": layout}
