"""A page from its template: one file that opens without a network, the same bytes for the same result.

Templates escape whatever they are given, and refuse a name that they are not given. The page carries plotly.js; its
own content security policy forbids it to fetch anything.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from compensator.report.figures.layout import Figure

_TEMPLATES = Environment(
    loader=PackageLoader("compensator.report.html"),
    autoescape=True,
    undefined=StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
    keep_trailing_newline=True,
)
SMALL = {"scatter", "scatter3d", "mesh3d"}  # what plotly's bundle gl3d draws of what stands in our figures
_TEMPLATES.policies["json.dumps_kwargs"] = {"separators": (",", ":"), "allow_nan": False}


def page(
    template: str, title: str, figures: Mapping[str, Figure], *, scene: Mapping[str, Any] | None = None, **shown: object
) -> str:
    """The page of a template in ``templates/``.

    Args:
        figures: by the id of the element that they are drawn in.
        scene: of the arm at work, as ``report/scene`` makes it; the page then carries three.js, too.
        shown: numbers in words, sentences and tables, by the names that the template has for them.
    """
    drawing = {"plotly_js": plotly_js(figures), "scene": scene, "three_js": three_js() if scene else ""}
    return template_page(template, title=title, figures=figures, **drawing, **shown)


def template_page(template: str, **shown: object) -> str:
    """A page of a template that needs nothing but what is given."""
    return _TEMPLATES.get_template(f"{template}.html").render(**shown)


def plotly_js(figures: Mapping[str, Figure]) -> str:
    """plotly.js with its licence: all of it, 4.8 MB, or the 1.8 MB that curves and views in three dimensions need."""
    kinds = {trace["type"] for figure in figures.values() for trace in figure["data"]}
    if kinds <= SMALL:
        return (files("compensator.report.html") / "plotly" / "plotly-gl3d.js").read_text(encoding="utf-8")
    from plotly.offline import get_plotlyjs  # 5 MB, and not every page has figures

    return str(get_plotlyjs())


@cache
def three_js() -> str:
    """three.js with its licence, one file; docs/view.md says how it is made."""
    return (files("compensator.report.html") / "three" / "three.js").read_text(encoding="utf-8")
