"""What a program was made from: hashes of its inputs in its head, and a seal over the program itself.

The head of a program carries them as comments, one each, of at most 30 characters (a job of INFORM takes no more). The
seal is put in last, over all files of the program with the seal itself left blank: any byte that changes breaks it.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from compensator.cell.cell_file import Cell
from compensator.cell.named_files import DIGITS, named_files, sha256_of
from compensator.version import version
from toolpaths.toolpath import Toolpath

BLANK = "program sha256:" + "0" * DIGITS
OPEN = "predicted error ? mm"
#: What the head tells of the controller's own absolute accuracy or elasticity option, by [controller] of the cell.
ACCURACY = {None: "WARNING: absolute accuracy ?", True: "absolute accuracy on", False: "absolute accuracy off"}
GIVEN = "given as an object"  # no file to hash
_TOLD = re.compile(rb"\b(cell|model|toolpath|program) sha256:([0-9a-f]{%d})\b" % DIGITS)
_SEALED = b"program sha256:"
_SEAL = re.compile(rb"\bprogram sha256:[0-9a-f]{%d}\b" % DIGITS)
_ERROR = re.compile(rb"\bpredicted error (\d+\.\d+) mm")
_VERSION = re.compile(rb"\bversion ([\w.+-]{1,20})(?=.{0,30}?\bcell sha256)", re.S)
_HEAD = re.compile(
    rb"\b(?:cell|model|toolpath|program) sha256:[0-9a-f]+|\bpredicted error [\d.?]+ mm"
    rb"|\bversion [\w.+-]{1,20}(?=.{0,30}?\bcell sha256)|(?:WARNING: )?absolute accuracy (?:\?|on|off)", re.S
)  # fmt: skip


@dataclass(frozen=True)
class Provenance:
    """Version of this program, and shortened sha256 of the inputs of a run.

    Attributes:
        cell: of the cell file and all files that it names but the model. toolpath: of its files, in their order.
        absolute_accuracy: whether the controller's own is on; None: not known.
    """

    version: str
    cell: str
    model: str
    toolpath: str
    absolute_accuracy: bool | None = None

    def as_dict(self) -> dict[str, str]:
        """Version and hashes, for JSON."""
        return {key: str(value) for key, value in asdict(self).items() if key != "absolute_accuracy"}

    @property
    def stamp(self) -> tuple[str, ...]:
        """Comments for the head of a program; error and seal are put in by ``seal``."""
        hashes = [f"{name} sha256:{getattr(self, name)}" for name in ("cell", "model", "toolpath")]
        known = (line for line in hashes if GIVEN not in line)
        return (f"version {self.version[:20]}", *known, OPEN, ACCURACY[self.absolute_accuracy], BLANK)


def provenance_of(cell: Cell, source: Toolpath) -> Provenance:
    """Of a run with this cell and this toolpath, both as they were read."""
    named = named_files(cell)
    parts = [Path(name) for name in source.sources or (source.source,)]
    return Provenance(
        version=version(),
        cell=sha256_of((named.cell, *named.beside)),
        model=sha256_of((named.model,)),
        toolpath=sha256_of(parts) if all(p.is_file() for p in parts) else GIVEN,
        absolute_accuracy=cell.controller.absolute_accuracy,
    )


@dataclass(frozen=True)
class ProgramHead:
    """What the head of a program tells; None: it does not.

    Attributes:
        error: mm, largest predicted error of the program as written.
        seal: hash of the program.
    """

    version: str | None = None
    cell: str | None = None
    model: str | None = None
    toolpath: str | None = None
    error: float | None = None
    seal: str | None = None


def head_of(data: bytes) -> ProgramHead:
    """The head of a program; the first of each kind counts."""
    told: dict[str, str] = {}
    for m in _TOLD.finditer(data):
        told.setdefault(m[1].decode(), m[2].decode())
    if not told:
        return ProgramHead()
    of, error = _VERSION.search(data), _ERROR.search(data)
    return ProgramHead(
        version=of and of[1].decode(),
        cell=told.get("cell"),
        model=told.get("model"),
        toolpath=told.get("toolpath"),
        error=error and float(error[1]),
        seal=told.get("program"),
    )


def without_head(data: bytes) -> bytes:
    """A program without what its head tells of other files and of itself."""
    return _HEAD.sub(b"", data)


def digest_of(files: Iterable[bytes]) -> str:
    """Hash over the files of a program in their order, shortened, whatever seal stands in them."""
    whole = hashlib.sha256()
    for data in files:
        blank = _SEAL.sub(BLANK.encode(), data) if _SEALED in data else data
        whole.update(len(blank).to_bytes(8, "big"))
        whole.update(blank)
    return whole.hexdigest()[:DIGITS]


def seal(files: Sequence[Path], error: float) -> list[Path]:
    """Put the predicted error and the seal into the head of a program that was just written.

    Args:
        files: of the program, staged, the main one first.
        error: m, largest of the cutting poses.

    Returns:
        The files that are still as they were.
    """
    told, open_, blank = f"predicted error {error * 1e3:.4f} mm".encode(), OPEN.encode(), BLANK.encode()

    def text(file: Path) -> bytes:
        data = file.read_bytes()
        return data.replace(open_, told) if open_ in data else data

    mark = _SEALED + digest_of(text(file) for file in files).encode()
    same = list[Path]()
    for file in files:
        data = file.read_bytes()
        if open_ in data or blank in data:
            file.write_bytes(data.replace(open_, told).replace(blank, mark))
        else:
            same.append(file)
    return same
