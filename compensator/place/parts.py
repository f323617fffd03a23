"""Parts: results of a study as they come in, one Parquet per task beside the study, until all are there."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from compensator.errors import CompensatorError
from compensator.place.candidates import COLUMNS, Candidates
from compensator.place.judge import NUMBERS, Judgement

if TYPE_CHECKING:
    import pyarrow as pa

KEY = b"compensator.study"
Rows = Mapping[str, Sequence[Any]]


def pyarrow() -> Any:
    """The library that reads and writes Parquet.

    Raises:
        CompensatorError: it is not installed.
    """
    try:
        import pyarrow.parquet
    except ImportError as e:
        what = "a study is a Parquet file, which needs pyarrow: pip install 'toolpath-compensator[parquet]'"
        raise CompensatorError(what) from e
    return pyarrow


def rows_of(candidates: Candidates, batch: range, found: Sequence[Judgement]) -> dict[str, list[Any]]:
    """Columns of the candidates of one task."""
    out: dict[str, list[Any]] = {"index": list(batch)}
    out |= {name: candidates.poses[batch.start : batch.stop, k].tolist() for k, name in enumerate(COLUMNS)}
    given = [asdict(j) for j in found]
    out |= {name: [j[name] for j in given] for name in ("status", "collision", *NUMBERS)}
    return out | {f"start_q{k + 1}_deg": [j["start_deg"][k] for j in given] for k in range(6)}


class Parts:
    """The folder of the parts of one study.

    Args:
        output: the study; the parts stand in ``OUTPUT.parts`` until it is written. key: of the study.
    """

    def __init__(self, output: Path, key: str) -> None:
        self.output, self.key = output, key
        self.folder = output.with_name(output.name + ".parts")

    def __repr__(self) -> str:
        return f"Parts({str(self.folder)!r}, {self.key})"

    def refuse_other(self) -> None:
        """Refuse what belongs to another study.

        Raises:
            CompensatorError: the output or parts beside it are of another study.
        """
        for file in [self.output, *self.all()]:
            if file.exists():
                self._refuse_other(file)

    def all(self) -> list[Path]:
        """Parts that are there, of whatever study."""
        return sorted(self.folder.glob("part-*.parquet"))

    def path(self, batch: range) -> Path:
        """The part of a task."""
        return self.folder / f"part-{self.key}-{batch.start:08d}.parquet"

    def write(self, batch: range, rows: Rows) -> None:
        """Write one part beside its name, then rename it: what has the name is whole.

        Raises:
            CompensatorError: there is no room for it.
        """
        target = self.path(batch)
        staged = target.with_suffix(f".{os.getpid()}.tmp")
        try:
            self.folder.mkdir(exist_ok=True)
        except OSError as e:
            raise CompensatorError(f"{self.folder}: cannot be made: {e.strerror or e}") from e
        pyarrow().parquet.write_table(table_of(rows, self.key), staged)
        os.replace(staged, target)

    def joined(self, batches: Sequence[range]) -> pa.Table:
        """All parts in the order of the candidates."""
        pa = pyarrow()
        return pa.concat_tables([pa.parquet.read_table(self.path(b)) for b in batches]).combine_chunks()

    def clear(self) -> None:
        """Take the parts away: the study is written."""
        for file in [*self.all(), *self.folder.glob("part-*.tmp")]:
            file.unlink(missing_ok=True)
        if self.folder.exists():
            self.folder.rmdir()

    def _refuse_other(self, file: Path) -> None:
        try:
            there = pyarrow().parquet.read_schema(file).metadata or {}
        except (OSError, ValueError) as e:  # pyarrow's errors are ValueErrors
            raise CompensatorError(f"{file}: is no study: {e}. Take it away, or give -o another name") from e
        if there.get(KEY) != self.key.encode():
            of = there.get(KEY, b"none").decode()
            raise CompensatorError(
                f"{file}: belongs to another study ({of}; this one is {self.key}): toolpath, cell, placements or "
                "options differ. Take it away, or give -o another name"
            )


def table_of(rows: Rows, key: str) -> pa.Table:
    """A table that carries the key of its study."""
    pa = pyarrow()
    return pa.table(dict(rows)).replace_schema_metadata({KEY: key.encode()})
