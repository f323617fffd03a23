"""Edits of a cell in its text: work object and tool get other numbers, comments and everything else stay."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from copy import deepcopy
from typing import Any

import tomli_w

from compensator.errors import CellError

DIGITS = 6  # of a length in mm and an angle in deg
LARGEST = 1e6
Numbers = Sequence[float]
Edit = Mapping[str, Mapping[str, Numbers]]  # table, such as ``workobject`` or ``tools.2`` -> key -> numbers


def checked_edit(given: object, editable: Mapping[str, Mapping[str, Numbers]]) -> dict[str, dict[str, list[float]]]:
    """An edit as a page sends it.

    Args:
        editable: tables and keys that there are.

    Raises:
        CellError: names what is wrong with it.
    """
    if not isinstance(given, Mapping):
        raise CellError("edit: a table of tables is expected")
    out: dict[str, dict[str, list[float]]] = {}
    for table, keys in given.items():
        if table not in editable or not isinstance(keys, Mapping):
            there = ", ".join(editable) or "none"
            raise CellError(f"edit: [{table}] is no table that can be edited; there are {there}")
        for key, values in keys.items():
            if key not in editable[table]:
                raise CellError(f"edit: {table}.{key} cannot be edited; there are {', '.join(editable[table])}")
            out.setdefault(table, {})[key] = _three(f"{table}.{key}", values)
    return out


def _three(name: str, values: object) -> list[float]:
    whole = values if isinstance(values, list) else []
    numbers = [float(v) for v in whole if isinstance(v, int | float) and not isinstance(v, bool)]
    if len(numbers) != 3 or len(whole) != 3 or not all(abs(v) <= LARGEST for v in numbers):
        raise CellError(f"{name} = {values!r}: 3 numbers are expected, mm or deg")
    return [round(v, DIGITS) + 0.0 for v in numbers]


def edited_text(text: str, edit: Edit) -> str:
    """The text of a cell with the numbers of ``edit``; where the text is laid out in a way that is not known, its
    tables as they are written afresh, without comments."""
    wanted = deepcopy(tomllib.loads(text))
    for name, keys in edit.items():
        table = wanted
        for part in name.split("."):
            table = table.setdefault(part, {})
        table.update({key: list(values) for key, values in keys.items()})
    out = text
    for name, keys in edit.items():
        for key, values in keys.items():
            out = _with_line(out, name, key, values)
    try:
        same = tomllib.loads(out) == wanted
    except tomllib.TOMLDecodeError:
        same = False
    return out if same else tomli_w.dumps(wanted)


def _with_line(text: str, table: str, key: str, values: Numbers) -> str:
    """The text with one value of one table replaced, or put in as the table's first."""
    lines = text.splitlines(keepends=True)
    name = r"\s*\.\s*".join(map(re.escape, table.split(".")))
    head = re.compile(rf"^\s*\[\s*{name}\s*\]\s*(#.*)?$")
    start = next((k for k, line in enumerate(lines) if head.match(line)), None)
    if start is None:
        return text
    end = next((k for k in range(start + 1, len(lines)) if lines[k].lstrip().startswith("[")), len(lines))
    pattern = re.compile(rf"^(\s*{re.escape(key)}\s*=\s*)\[[^\[\]#]*\]", re.MULTILINE)
    shown, part = str([float(v) for v in values]), "".join(lines[start + 1 : end])
    part = pattern.sub(lambda m: m[1] + shown, part, count=1) if pattern.search(part) else f"{key} = {shown}\n{part}"
    return "".join(lines[: start + 1]) + part + "".join(lines[end:])


def editable_tables(cell: Mapping[str, Any]) -> dict[str, dict[str, list[float]]]:
    """What can be edited of a cell: table -> key -> numbers, mm and deg.

    Args:
        cell: the tables of the file.
    """
    out: dict[str, dict[str, list[float]]] = {}
    if "xyz" in cell.get("workobject", {}):
        out["workobject"] = _place(cell["workobject"])
    if "tool" in cell:
        out["tool"] = _place(cell["tool"])
    for number, table in cell.get("tools", {}).items():
        out[f"tools.{number}"] = _place(table)
    return out


def _place(table: Mapping[str, Any]) -> dict[str, list[float]]:
    return {key: [float(v) for v in table.get(key, (0.0, 0.0, 0.0))] for key in ("xyz", "rpy")}
