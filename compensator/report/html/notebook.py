"""A result as a notebook shows it: a small table and its findings, without plotly."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from jinja2 import Environment, PackageLoader, StrictUndefined

_TEMPLATES = Environment(loader=PackageLoader("compensator.report.html"), autoescape=True, undefined=StrictUndefined)


def notebook_table(title: str, facts: Mapping[str, str], findings: Sequence[str]) -> str:
    """HTML; whatever files brought into the words is escaped."""
    return _TEMPLATES.get_template("notebook.html").render(title=title, facts=facts, findings=findings)
