"""Text of an input file: what no language accepts is refused here, once for all readers."""

from __future__ import annotations

import re
from pathlib import Path

from toolpaths.errors import ReadError

_CONTROL = re.compile(r"[^\t\n\f\r\x1a\x20-\x7e\x80-\U0010ffff]")
_PAGE = re.compile(r"<!doctype\s+html|<html|%PDF-|\{\\rtf", re.I)
_CONFLICT = re.compile(r"^(<{7} |>{7} |={7}$|\|{7} )", re.MULTILINE)


def load_lines(path: Path, source: str) -> list[str]:
    """The lines of a text file without their ends; the last one is empty when the file ends in a line end.

    UTF-8, with or without byte order mark; what is not UTF-8 is read as Windows-1252 (CAM systems write
    comments so), one character a byte.

    Raises:
        ReadError: the file is missing, a folder, empty, not text, or holds merge-conflict markers.
    """
    data = _load_bytes(path, source)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    if page := _PAGE.match(text, len(text) - len(text.lstrip())):
        what = f"{page[0]!r}: a web page, PDF or document, not a toolpath"
        raise ReadError(source, _line(text, page), what, "Save the file that is behind the link.")
    text = text.replace("\r\n", "\n").replace("\r", "\n").replace("\f", "\n").rstrip("\x1a")
    if bad := _CONTROL.search(text):
        problem = f"character {bad.group()!r}: not a text file"
        raise ReadError(source, _line(text, bad), problem, "Give the file that CAM posted.")
    if not text.strip():
        raise ReadError(source, None, "the file is empty", "Post it again from the CAM system.")
    if mark := _CONFLICT.search(text):
        raise ReadError(
            source,
            _line(text, mark),
            f"merge-conflict marker {mark.group().strip()!r}",
            "Two versions of the file are mixed: settle the conflict first.",
        )
    return text.split("\n")


def refuse_absent(path: Path, source: str) -> None:
    """Refuse a folder, standard input, and a file that is not there; the suffix comes after that.

    Raises:
        ReadError: as it says.
    """
    try:
        if path.is_dir():
            raise ReadError(source, None, "this is a folder", "Name one toolpath file.")
        there = path.exists()
    except (OSError, ValueError) as problem:
        raise _unread(source, problem) from None
    if not there and str(path) == "-":
        raise ReadError(source, None, "standard input is not read", "Name a toolpath file.")
    if not there:
        raise ReadError(source, None, "there is no such file", "Check the name and the folder.")


def _load_bytes(path: Path, source: str) -> bytes:
    refuse_absent(path, source)
    try:
        data = path.read_bytes()
    except (OSError, ValueError) as problem:
        raise _unread(source, problem) from None
    if b"\0" in data:
        raise ReadError(source, None, "binary or UTF-16 (zero bytes), not text", "Save it as UTF-8 text.")
    return data


def _unread(source: str, problem: OSError | ValueError) -> ReadError:
    why = problem.strerror if isinstance(problem, OSError) else str(problem)
    return ReadError(source, None, f"cannot be read: {why}")


def _line(text: str, match: re.Match[str]) -> int:
    return text.count("\n", 0, match.start()) + 1


def comment_word(text: str) -> str:
    """A comment of the file as one short printable line."""
    plain = "".join(c if c.isprintable() else " " for c in text)
    return " ".join(plain.split())[:80]


def plain_text(text: str) -> str:
    """Text that was read byte by byte, as UTF-8 where it is."""
    try:
        return text.encode("latin-1").decode("utf-8")
    except UnicodeDecodeError:
        return text
