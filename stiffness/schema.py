"""Schemas of files: the strict base of their tables, and what a schema has against a file, key by key."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from math import isfinite
from typing import Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, ValidationError
from pydantic_core import ErrorDetails


class StrictTable(BaseModel):
    """A table of a file: a key that it does not know is refused, and what was read does not change."""

    model_config = ConfigDict(extra="forbid", frozen=True, protected_namespaces=())


@dataclass(frozen=True)
class SchemaFinding:
    """What is wrong with one key.

    Attributes:
        kind: the key is ``unknown``, ``missing``, or its value is ``wrong``.
        key: with the tables it stands in, items of lists counted from 1: ``joints.3.limits.1``.
        given: the value that stands there.
        why: what was expected, in the words of pydantic or of a validator.
        code: pydantic's name of the error, or that of a custom one.
    """

    kind: Literal["unknown", "missing", "wrong"]
    key: str
    given: object
    why: str
    code: str

    def __str__(self) -> str:
        if self.kind == "unknown":
            return f"unknown key {self.key}"
        if self.kind == "missing":
            return f"key {self.key} is missing"
        return f"{self.key} = {self.given!r}: {self.why}"


def findings(error: ValidationError) -> list[SchemaFinding]:
    """What a schema has against a file, in the order of its keys."""
    found, short = [], set[str]()
    for e in error.errors():
        loc, given = e["loc"], e["input"]
        if e["type"] == "missing" and isinstance(loc[-1], int):  # an item of a list that is too short
            loc = loc[:-1]
            if _key(loc) in short:
                continue
            short.add(_key(loc))
            most = max(f["loc"][-1] for f in error.errors() if f["loc"][:-1] == loc and isinstance(f["loc"][-1], int))
            found.append(SchemaFinding("wrong", _key(loc), given, _count(given, most + 1), code="too_short"))
            continue
        found.append(SchemaFinding(_KINDS.get(e["type"], "wrong"), _key(loc), given, _why(e), code=e["type"]))
    return found


def listed_numbers(count: int, meaning: str = "") -> BeforeValidator:
    """What refuses anything but a list of so many finite numbers, in words that tell what they are."""
    meaning = meaning and f": {meaning}"

    def check(given: Any) -> Any:
        what = f"expected {count} numbers in brackets{meaning}"
        if not isinstance(given, list | tuple):
            raise ValueError(what)
        if len(given) != count:
            raise ValueError(_count(given, count) + meaning)
        for k, item in enumerate(given, 1):
            if isinstance(item, bool) or not isinstance(item, int | float):
                raise ValueError(f"{what}; item {k} is {item!r}{_not_number(item)}")
            if not isfinite(item):
                raise ValueError(f"{what}; item {k} is not finite")
        return given

    return BeforeValidator(check)


def meant(word: str, known: Iterable[str], alike: float = 0.6) -> str:
    """'; did you mean ...?', or nothing; ``alike``: the least ratio of what matches, as difflib counts it."""
    near = get_close_matches(word, list(known), n=1, cutoff=alike)
    return f"; did you mean {near[0]}?" if near else ""


_KINDS: dict[str, Literal["unknown", "missing"]] = {"extra_forbidden": "unknown", "missing": "missing"}
_BOUNDS = {
    "greater_than": "above",
    "greater_than_equal": "from",
    "less_than": "below",
    "less_than_equal": "up to",
}
_WORDS = {
    "bool_type": "expected true or false, without quotes",
    "string_type": "expected text in quotes",
    "list_type": "expected a list in brackets",
    "tuple_type": "expected a list in brackets",
    "dict_type": "expected a table",
    "model_type": "expected a table",
    "model_attributes_type": "expected a table",
    "finite_number": "expected a finite number",
}


def _key(loc: tuple[int | str, ...]) -> str:
    return ".".join(str(part + 1) if isinstance(part, int) else part for part in loc if part != "[key]")


def _why(e: ErrorDetails) -> str:
    code, context = e["type"], e.get("ctx", {})
    if code in ("float_type", "int_type", "float_parsing", "int_parsing"):
        number = "a whole number" if code.startswith("int") else "a number"
        return f"expected {number}{_not_number(e['input'])}"
    if code == "too_long":
        return _count(e["input"], context["max_length"])
    for bound, words in _BOUNDS.items():
        if code == bound:
            return f"expected a number {words} {next(iter(context.values())):g}"
    if code == "union_tag_invalid":
        return f"kind {context['tag']!r} is unknown; known are {context['expected_tags']}"
    return _WORDS.get(code) or e["msg"].removeprefix("Value error, ").replace("Input should be", "expected")


def _count(given: Any, expected: int) -> str:
    there = len(given) if isinstance(given, list | tuple) else 0
    comma = " (a decimal sign is a point)" if there > expected else ""
    return f"there {'is' if there == 1 else 'are'} {there}{comma}, expected {expected}"


def _not_number(given: object) -> str:
    """What is wrong with a text where a number should be."""
    if not isinstance(given, str):
        return ""
    try:
        float(given.replace(",", "."))
    except ValueError:
        return ": text; write the number alone, without quotes and unit" if given[:1].isdigit() else ""
    return ": text; write it without quotes" + (", with a point as decimal sign" if "," in given else "")
