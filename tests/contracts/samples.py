"""The samples of all languages, by the names of the table."""

from __future__ import annotations

from pathlib import Path

from tests.contracts.languages import apt, csv, fanuc, gcode, heidenhain, inform, krl, rapid, siemens, urscript, val3
from tests.contracts.sample import FilterSample, ReadSample, Sample, WrittenSample
from toolpaths.languages.table import LANGUAGES

SAMPLES: dict[str, Sample] = {
    "rapid": rapid.SAMPLE, "krl": krl.SAMPLE, "fanuc": fanuc.SAMPLE, "urscript": urscript.SAMPLE, "val3": val3.SAMPLE,
    "inform": inform.SAMPLE, "gcode": gcode.SAMPLE, "siemens": siemens.SAMPLE,
    "heidenhain": heidenhain.SAMPLE, "apt": apt.SAMPLE, "csv": csv.SAMPLE,
}  # fmt: skip
READ: dict[str, ReadSample] = {name: s.read for name, s in SAMPLES.items() if s.read is not None}
WRITTEN: dict[str, WrittenSample] = {name: s.written for name, s in SAMPLES.items() if s.written is not None}
FILTERED: dict[str, FilterSample] = {name: s.filtered for name, s in SAMPLES.items() if s.filtered is not None}


def to_read(folder: Path, name: str, data: str | bytes, beside: tuple[str, str] | None = None) -> Path:
    """A file of a language, with the first of its suffixes, and the one that belongs to it."""
    file = folder / f"part{LANGUAGES[name].reads[0]}"
    file.write_bytes(data if isinstance(data, bytes) else data.encode())
    if beside is not None:
        file.with_suffix(beside[0]).write_bytes(beside[1].encode())
    return file


def to_write(folder: Path, name: str, stem: str = "part1") -> Path:
    """Where a program of a language goes."""
    return folder / f"{stem}{LANGUAGES[name].writes}"
