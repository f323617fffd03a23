"""Writes docs/glossary.md: the terms as they stand there, and every public class of the code with what it is.

    python -m docs.make_glossary
"""

from __future__ import annotations

import ast
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = Path(__file__).parent / "glossary.md"
PACKAGES = ("toolpaths", "stiffness", "compensator")
HEAD = "## Classes of the code"


def classes() -> list[tuple[str, str, str]]:
    """(name, module, first sentence of the docstring) of every public class."""
    out = []
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            module = ".".join(path.relative_to(ROOT).with_suffix("").parts)
            for node in ast.parse(path.read_text(encoding="utf-8")).body:
                if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                    out.append((node.name, module, first_sentence(ast.get_docstring(node) or "")))
    return sorted(out, key=lambda row: row[0].lower())


def first_sentence(docstring: str) -> str:
    """The first paragraph in one line, with ``code`` as `code` and without what would break a table."""
    return " ".join(docstring.split("\n\n")[0].split()).replace("``", "`").replace("|", "\\|")


def page(terms: str) -> str:
    """The whole page."""
    rows = [f"| `{name}` | `{module}` | {what} |" for name, module, what in classes()]
    lead = "Made from the docstrings by `python -m docs.make_glossary`; a test compares."
    table = ["| class | module | is |", "| --- | --- | --- |", *rows]
    return "\n".join([terms.rstrip(), "", HEAD, "", lead, "", *table, ""])


def terms() -> str:
    """What stands above the classes: written by hand."""
    return PAGE.read_text(encoding="utf-8").split(f"\n{HEAD}\n")[0]


if __name__ == "__main__":
    PAGE.write_text(page(terms()), encoding="utf-8", newline="\n")
