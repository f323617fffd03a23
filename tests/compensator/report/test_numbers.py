"""Numbers and units as reports write them."""

from __future__ import annotations

import json

import numpy as np
import pytest

from compensator.report.json.text import as_json, known_numbers
from compensator.report.words.numbers import (
    deflection_mm,
    joined,
    parameter_words,
    residual_mm,
    rounded,
    shown_unit,
    with_sd,
)


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (0.0, "0.000"), (12.3456789, "12.346"), (0.001, "0.001"), (0.000999, "0.001"), (5.1e-4, "0.001"),
        (6.99e-5, "< 0.001"), (3.2e-6, "< 0.001"), (9e-10, "0.000"),
    ],
)  # fmt: skip
def test_deflection_mm(value: float, shown: str) -> None:
    assert deflection_mm(value) == shown


@pytest.mark.parametrize(
    ("value", "shown"),
    [(0.0, "0"), (12.3456789, "12.35"), (0.0123456, "0.01235"), (1.23456e-5, "0.000012"), (54321.0, "54321")],
)
def test_residual_mm(value: float, shown: str) -> None:
    assert residual_mm(value) == shown


@pytest.mark.parametrize(
    ("value", "sd", "shown"),
    [(1996912.3, 5612.0, "1,996,900"), (0.0123456, 0.00021, "0.01235"), (float("inf"), 3.0, "∞"), (-0.001, 0.4, "0.00"),
     (5.0, 0.0, "5"), (37650.4, 9.96, "37,650.4")],
)  # fmt: skip
def test_digits_follow_the_standard_deviation(value: float, sd: float, shown: str) -> None:
    assert rounded(value, sd) == shown


def test_a_number_with_its_standard_deviation() -> None:
    assert with_sd(0.0123456, 0.00021) == "0.01235 ± 0.00021"
    assert with_sd(0.3, 0.0) == "0.3"  # searched, not fitted


def test_units_and_names() -> None:
    assert shown_unit("rad") == ("mrad", 1e3)
    assert shown_unit("m/N") == ("µm/N", 1e6) and shown_unit("m/N", rates=False) == ("m/N", 1.0)
    assert shown_unit("N*m") == ("N·m", 1.0)
    assert [parameter_words(n) for n in ("k_nm_per_rad", "gap_rad", "friction_nm", "ratio")] == [
        "k", "gap", "friction", "ratio",
    ]  # fmt: skip
    assert [joined(["a", "b", "c"][:n]) for n in range(4)] == ["", "a", "a and b", "a, b and c"]


def test_json_has_no_number_that_is_not_finite() -> None:
    assert as_json({"a": [1.0, None], "b": {"c": "d"}}) == '{\n  "a": [1.0, null],\n  "b": {"c": "d"}\n}\n'
    with pytest.raises(ValueError, match="JSON compliant"):
        as_json({"a": float("nan")})
    assert known_numbers(np.array([1.0, np.nan]), [True, False]) == [1.0, None]


def test_json_has_arrays_on_few_lines_and_loses_nothing() -> None:
    """A table of 720 numbers, a matrix, rows that are tables: none of it a line per number, none beyond the width."""
    rng = np.random.default_rng(1)
    report = {
        "table": rng.normal(size=720).tolist(),
        "matrix": rng.normal(size=(40, 40)).tolist(),
        "rows": [{"session": "a/b.toml", "row": k, "x": [1.5 * k, None, True]} for k in range(300)],
        "empty": [[], {}],
        "deep": {"a": {"b": {"c": rng.normal(size=9).tolist(), "text": "[1.0,\n 2.0]"}}},
    }
    text = as_json(report)
    assert json.loads(text) == report
    lines = text.splitlines()
    assert max(map(len, lines)) <= 120
    assert len(lines) < 720 / 4 + 40 * (40 / 4 + 2) + 300 + 20  # 2,900 with a line for each number
