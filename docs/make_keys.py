"""Writes docs/keys.md: every key of every file that is read, from the schemas that check them.

    python -m docs.make_keys
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from compensator.cell.cell_file import Cell
from compensator.process.milling.material import MaterialFile
from compensator.trace.trace_file import TraceFile
from docs.make_glossary import first_sentence
from stiffness.model.file import ModelFile
from stiffness.robot.toml_file import _File as RobotFile
from stiffness.session.file import SessionFile

PAGE = Path(__file__).parent / "keys.md"
HEAD = """# Every key of every file

Made from the schemas that check the files, by `python -m docs.make_keys`; a test compares. What a key means, with
examples, stands on the page named under each heading. Unknown keys are
refused everywhere. `NAME`: a name of your own, or the number of a tool or set-up.
"""
FILES = (
    ("The cell: `cell/1`", Cell, "compensate.md", "Lengths mm, angles deg, mass kg, wrench N and N*m."),
    ("The model: `model/1`", ModelFile, "effects.md", "Lengths m, angles rad, N*m/rad. Parameters by effect there."),
    ("A robot: `.toml`", RobotFile, "robots.md", "Lengths mm, angles deg, mass kg."),
    ("A session: `measurement-session/1`", SessionFile, "sessions.md", "Units as it says itself; its csv there."),
    ("A trace: `trace/1`", TraceFile, "traces.md", "Lengths mm, angles deg; the columns of its csv there."),
    ("A material: `material/1`", MaterialFile, "cutting.md", "N/mm2 and N/mm."),
)
NAMES = {"integer": "whole number", "number": "number", "string": "text", "boolean": "true or false", "null": ""}
BOUNDS = (("exclusiveMinimum", "> "), ("minimum", ">= "), ("exclusiveMaximum", "< "), ("maximum", "<= "))


def page() -> str:
    """The whole page."""
    out = [HEAD]
    for title, table, where, units in FILES:
        schema = table.model_json_schema()
        out += [f"## {title}", "", f"[{where}]({where}). {units}", "", "| key | is | default |", "| --- | --- | --- |"]
        out += [f"| `{key}` | {what} | {default} |" for key, what, default in rows(schema, schema.get("$defs", {}))]
        out.append("")
    return "\n".join(out)


def rows(schema: dict[str, Any], known: dict[str, Any], above: str = "") -> Iterator[tuple[str, str, str]]:
    """(key, what it is, default) of a table and those within."""
    needed = schema.get("required", ())
    for key, given in schema.get("properties", {}).items():
        if key in ("source", "folder") and schema.get("title") == "Cell":
            continue  # not of the file
        tables = list(_tables(given, known))
        name = f"{above}{key}"
        default = "needed" if key in needed else _default(given)
        words = _words(given, known)
        if not tables:
            yield name, words, default
        for suffix, table in tables:
            about = first_sentence(table.get("description", "")) or "a table"
            yield f"{name}{suffix}", f"table. {about}", default
            yield from rows(table, known, f"{name}{suffix}.")


def _tables(given: dict[str, Any], known: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Tables that may stand there, and what follows the key: nothing, .N or .NAME, or their kind."""
    if "$ref" in given:
        table = known[given["$ref"].rsplit("/", 1)[-1]]
        if "properties" in table:
            yield _kind(table), table
        return
    for option in given.get("anyOf", given.get("oneOf", ())):
        yield from _tables(option, known)
    for of, suffix in (("additionalProperties", ".NAME"), ("patternProperties", ".NAME"), ("items", "[]")):
        inner = given.get(of)
        for one in inner.values() if of == "patternProperties" and inner else [inner]:
            if isinstance(one, dict):
                yield from ((f"{suffix}{more}", table) for more, table in _tables(one, known))


def _kind(table: dict[str, Any]) -> str:
    """Of a process: its tables differ by kind."""
    kind = table.get("properties", {}).get("kind", {}).get("const")
    return f"({kind})" if kind else ""


def _words(given: dict[str, Any], known: dict[str, Any]) -> str:
    if "$ref" in given:
        return _words(known[given["$ref"].rsplit("/", 1)[-1]], known)
    if "const" in given:
        return f"`{given['const']}`"
    if "enum" in given:
        return ", ".join(f"`{value}`" for value in given["enum"] if value)
    options = [_words(o, known) for o in given.get("anyOf", given.get("oneOf", ()))]
    if options:
        return " or ".join(dict.fromkeys(o for o in options if o))
    if given.get("type") == "array":
        inner = given.get("prefixItems") or [given.get("items", {})]
        count = str(len(given["prefixItems"])) if "prefixItems" in given else "list of"
        return f"{count} ({_words(inner[0], known) or 'values'})"
    if given.get("type") == "object":
        return "table"
    bounds = [f"{sign}{given[key]:g}" for key, sign in BOUNDS if key in given]
    return " ".join([NAMES.get(given.get("type", ""), "anything"), *([f"({', '.join(bounds)})"] if bounds else [])])


def _default(given: dict[str, Any]) -> str:
    value = given.get("default")
    if value is None or isinstance(value, dict) or value in ([], ""):
        return ""
    return f"`{str(value).lower()}`" if isinstance(value, bool) else f"`{value}`"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8", newline="\n")
