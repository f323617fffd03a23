"""TOML text of a table: an array in as few lines as fit, a matrix row by row."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from textwrap import indent
from typing import Any

import tomli_w

WIDTH = 120


def toml_text(table: Mapping[str, Any]) -> str:
    """A table as TOML; reading it again gives the same numbers to the last bit."""
    return "\n".join(_section(table, ())) + "\n"


def _section(table: Mapping[str, Any], path: tuple[str, ...]) -> list[str]:
    own = {k: v for k, v in table.items() if not isinstance(v, Mapping)}
    head = [f"[{'.'.join(path)}]"] if path and (own or not table) else []
    out = head + [line for key, value in own.items() for line in _entry(_key(key), value)]
    for key, value in table.items():
        if isinstance(value, Mapping):
            out += ([""] if out else []) + _section(value, (*path, _key(key)))
    return out


def _entry(key: str, value: Any) -> list[str]:
    return f"{key} = {_value(value, WIDTH - len(key) - 3)}".split("\n")


def _key(key: str) -> str:
    return tomli_w.dumps({key: 0}).removesuffix(" = 0\n")


def _value(value: Any, width: int) -> str:
    """Of a scalar or an array; on one line where it fits into ``width``."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_key(k)} = {_one_line(v)}" for k, v in value.items()) + "}"
    if isinstance(value, str) or not isinstance(value, Sequence):
        return tomli_w.dumps({"k": value}).removeprefix("k = ").removesuffix("\n")
    line = _one_line(value)
    if len(line) <= width:
        return line
    if any(isinstance(v, Sequence) and not isinstance(v, str) for v in value):
        rows = [_value(v, WIDTH - 5) + "," for v in value]
    else:
        rows = _wrapped([_value(v, WIDTH) for v in value])
    return "[\n" + indent("\n".join(rows), "    ") + "\n]"


def _one_line(value: Any) -> str:
    if isinstance(value, Sequence) and not isinstance(value, str):
        return "[" + ", ".join(_one_line(v) for v in value) + "]"
    return _value(value, WIDTH)


def _wrapped(words: Sequence[str]) -> list[str]:
    """Words with a comma behind each, as many to a line as fit."""
    lines, line = list[str](), ""
    for word in words:
        if line and len(line) + len(word) + 2 > WIDTH - 8:
            lines, line = [*lines, line], ""
        line += f"{' ' if line else ''}{word},"
    return [*lines, line] if line else lines
