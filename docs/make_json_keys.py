"""Writes docs/json-keys.md: the keys of every JSON summary, found by running a small job of every verb.

    python -m docs.make_json_keys
"""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from click.testing import CliRunner

from compensator.cli import main
from tests.verb_jobs import JOBS, write_inputs

PAGE = Path(__file__).parent / "json-keys.md"
HEAD = """# The keys of every JSON summary

Made by running a small job of every verb, by `python -m docs.make_json_keys`. Units are in the names: `_mm`, `_n`,
`_nm_per_rad`, `_deg`. `[]`: a list of such entries. A key may be null, or not be there, where something is not known
or not asked for. What they mean stands on the page of the verb.
"""


def page(keys: Mapping[str, list[tuple[str, str]]]) -> str:
    """The whole page, of the keys by verb."""
    out = [HEAD]
    for verb, rows in keys.items():
        out += [f"## {verb}", "", "| key | is |", "| --- | --- |", *(f"| `{key}` | {kind} |" for key, kind in rows), ""]
    return "\n".join(out)


def keys_of(verb: str) -> list[tuple[str, str]]:
    """Keys of the summary of a verb, run in the working folder, which has the inputs of all jobs."""
    Path("keys.json").unlink(missing_ok=True)
    done = CliRunner().invoke(main, [verb, *JOBS[verb].arguments, *outputs(verb), "--json", "keys.json"])
    if not Path("keys.json").exists():
        raise RuntimeError(f"{verb}: {done.output or done.exception!r}")
    return rows(json.loads(Path("keys.json").read_text(encoding="utf-8")))


def outputs(verb: str) -> tuple[str, ...]:
    """The output that a verb cannot do without."""
    usual = JOBS[verb].writes.get("-o")
    return ("-o", usual) if usual else ()


def rows(value: Any, above: str = "") -> list[tuple[str, str]]:
    """(key, kind) of a value; entries of a list together."""
    found: dict[str, str] = {}
    for key, kind in _rows(value, above):
        found[key] = kind if found.get(key, "null") == "null" else found[key]
    return list(found.items())


def _rows(value: Any, above: str) -> Iterator[tuple[str, str]]:
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from _rows(inner, f"{above}.{key}" if above else key)
    elif isinstance(value, list) and value and isinstance(value[0], dict):
        for inner in value:
            yield from _rows(inner, f"{above}[]")
    else:
        yield above, _kind(value)


def _kind(value: Any) -> str:
    if isinstance(value, list):
        return f"list of {_kind(value[0])}" if value else "list"
    names = {bool: "true or false", str: "text", int: "number", float: "number", type(None): "null"}
    return names[type(value)]


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        write_inputs(Path(folder))
        os.chdir(folder)
        made = {verb: keys_of(verb) for verb in sorted(JOBS) if "--json" in JOBS[verb].writes}
    PAGE.write_text(page(made), encoding="utf-8", newline="\n")
