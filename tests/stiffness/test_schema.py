"""What a schema has against a file: every wrong key by its place, with the value and what was expected."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import pytest
from pydantic import Field, ValidationError, field_validator

from stiffness.schema import SchemaFinding, StrictTable, findings


class Row(StrictTable):
    limits: tuple[float, float]
    kind: Literal["a", "b"] = "a"


class Whole(StrictTable):
    rows: tuple[Row, ...]
    count: Annotated[int, Field(ge=1, strict=True)] = 1

    @field_validator("count")
    @classmethod
    def _odd(cls, count: int) -> int:
        if count % 2 == 0:
            raise ValueError("expected an odd number")
        return count


def found(table: dict[str, Any]) -> list[SchemaFinding]:
    with pytest.raises(ValidationError) as caught:
        Whole.model_validate(table)
    return findings(caught.value)


GOOD: dict[str, Any] = {"limits": (0.0, 1.0)}


@pytest.mark.parametrize(
    ("table", "texts"),
    [
        ({}, ["key rows is missing"]),
        ({"rows": [], "colour": 3}, ["unknown key colour"]),
        ({"rows": [GOOD, {}]}, ["key rows.2.limits is missing"]),
        ({"rows": [GOOD | {"kind": "c"}]}, ["rows.1.kind = 'c': expected 'a' or 'b'"]),
        ({"rows": [], "count": 2}, ["count = 2: expected an odd number"]),
        ({"rows": [GOOD | {"x": 1}], "y": 2}, ["unknown key rows.1.x", "unknown key y"]),
    ],
)
def test_a_finding_names_the_key_the_value_and_what_was_expected(table: dict[str, Any], texts: list[str]) -> None:
    assert [str(f) for f in found(table)] == texts


def test_what_was_read_does_not_change() -> None:
    whole = Whole.model_validate({"rows": [GOOD]})
    with pytest.raises(ValidationError):
        whole.count = 3  # type: ignore[misc]
