"""`compare`: what differs between two JSON summaries of the same verb."""

from __future__ import annotations

import json as json_text
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from compensator.errors import CompensatorError
from compensator.report.json import check, diagnosis, evaluation, fit, path
from compensator.report.json.text import as_json
from compensator.report.words.findings import finding_sentences
from compensator.tasks.outputs import Outputs
from compensator.tasks.run_files import writes

SCHEMA = "comparison/1"
KNOWN = (path.SCHEMA, fit.SCHEMA, diagnosis.SCHEMA, evaluation.SCHEMA, check.SCHEMA)
NOT_COMPARED = ("schema", "seconds", "findings", "notes")
LISTED = 12  # numbers of a list that are compared one by one; of longer ones how many there are
ROUNDING = 1e-12  # of the larger number: the order of a sum

Value = str | float | bool | None


@dataclass(frozen=True)
class Difference:
    """A key with two values; ``None`` where a summary has it not, or has null there."""

    key: str
    one: Value
    other: Value

    @property
    def by(self) -> float | None:
        """Other less one, where both are numbers."""
        if isinstance(self.one, bool) or isinstance(self.other, bool):
            return None
        if isinstance(self.one, int | float) and isinstance(self.other, int | float):
            return float(self.other - self.one)
        return None


@dataclass(frozen=True)
class Comparison:
    """Two summaries, compared.

    Attributes:
        names: of the two files. schema: of both.
        rows: what differs, in the order of the summaries.
        only_one, only_other: findings that only one of them has.
    """

    names: tuple[str, str]
    schema: str
    rows: tuple[Difference, ...]
    only_one: tuple[str, ...]
    only_other: tuple[str, ...]

    def report(self) -> dict[str, Any]:
        """The JSON report."""
        return {
            "schema": SCHEMA,
            "files": list(self.names),
            "compared": self.schema,
            "differences": [
                {"key": d.key, "one": d.one, "other": d.other, "other_less_one": d.by} for d in self.rows
            ],
            "findings_only_one": list(self.only_one),
            "findings_only_other": list(self.only_other),
        }


@writes("json")
def compare_files(one: Path, other: Path, *, json: Path | None = None) -> Comparison:
    """Compare two summaries.

    Raises:
        CompensatorError: one is no summary, of an unknown schema, or the two are of different verbs.
    """
    first, second = _summary(one), _summary(other)
    if first["schema"] != second["schema"]:
        what = f"is a {second['schema']}, {one} a {first['schema']}"
        raise CompensatorError(f"{other}: {what}: expected two summaries of the same verb")
    a, b = dict(_flat("", first)), dict(_flat("", second))
    keys = [*a, *(key for key in b if key not in a)]
    rows = [Difference(key, a.get(key), b.get(key)) for key in keys]
    told, said = finding_sentences(first), finding_sentences(second)
    done = Comparison(
        names=(str(one), str(other)),
        schema=first["schema"],
        rows=tuple(d for d in rows if not _same(d)),
        only_one=tuple(s for s in told if s not in said),
        only_other=tuple(s for s in said if s not in told),
    )
    if json:
        with Outputs() as outputs:
            outputs.text(json, as_json(done.report()))
            outputs.commit()
    return done


def _summary(file: Path) -> dict[str, Any]:
    try:
        found = json_text.loads(file.read_text(encoding="utf-8"))
    except OSError as e:
        raise CompensatorError(f"{file}: cannot be read: {e.strerror}") from e
    except ValueError as e:
        raise CompensatorError(f"{file}: is no JSON: {e}; give what --json wrote") from e
    schema = found.get("schema") if isinstance(found, dict) else None
    if schema not in KNOWN or not isinstance(found.get("findings"), list):
        known = ", ".join(KNOWN)
        raise CompensatorError(f"{file}: schema = {schema!r}: expected one of {known}; give what --json wrote")
    return dict(found)


def _flat(key: str, value: Any) -> Iterator[tuple[str, Value]]:
    """Key with dots -> value; of a list of tables, or a long one, how many entries there are."""
    if isinstance(value, dict):
        for name, inner in value.items():
            if key or name not in NOT_COMPARED:
                yield from _flat(f"{key}.{name}" if key else name, inner)
    elif not isinstance(value, list):
        yield key, value
    elif len(value) <= LISTED and not any(isinstance(v, dict | list) for v in value):
        for k, inner in enumerate(value, start=1):
            yield f"{key}[{k}]", inner
    else:
        yield f"{key}: entries", len(value)


def _same(d: Difference) -> bool:
    if (by := d.by) is None:
        return d.one == d.other
    return abs(by) <= ROUNDING * max(abs(float(d.one or 0)), abs(float(d.other or 0)))
