"""Schemas of files: the strict base of their tables, and what a schema has against a file, key by key."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from pydantic import BaseModel, ConfigDict, ValidationError


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


_KINDS: dict[str, Literal["unknown", "missing"]] = {"extra_forbidden": "unknown", "missing": "missing"}


def findings(error: ValidationError) -> list[SchemaFinding]:
    """What a schema has against a file, in the order of its keys."""
    return [
        SchemaFinding(
            kind=_KINDS.get(e["type"], "wrong"),
            key=".".join(str(part + 1) if isinstance(part, int) else str(part) for part in e["loc"]),
            given=e["input"],
            why=e["msg"].removeprefix("Value error, "),
            code=e["type"],
        )
        for e in error.errors()
    ]
