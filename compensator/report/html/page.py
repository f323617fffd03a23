"""A page from its template: one file that opens without a network, the same bytes for the same result.

Templates escape whatever they are given, and refuse a name that they are not given. The page carries plotly.js; its
own content security policy forbids it to fetch anything.
"""

from __future__ import annotations

from collections.abc import Mapping

from jinja2 import Environment, PackageLoader, StrictUndefined
from plotly.offline import get_plotlyjs

from compensator.report.figures.layout import Figure

_TEMPLATES = Environment(
    loader=PackageLoader("compensator.report.html"),
    autoescape=True,
    undefined=StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
    keep_trailing_newline=True,
)
_TEMPLATES.policies["json.dumps_kwargs"] = {"separators": (",", ":"), "allow_nan": False}


def page(template: str, title: str, figures: Mapping[str, Figure], **shown: object) -> str:
    """The page of a template in ``templates/``.

    Args:
        figures: by the id of the element that they are drawn in.
        shown: numbers in words, sentences and tables, by the names that the template has for them.
    """
    made = _TEMPLATES.get_template(f"{template}.html")
    return made.render(title=title, figures=figures, plotly_js=get_plotlyjs(), **shown)
