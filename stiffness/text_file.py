"""Text files: bytes, characters, TOML; what cannot be read is refused in words that say what to do."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

Refuse = Callable[[str], Exception]  # makes the exception of a message

_AT = re.compile(r" \(at (?:line (\d+), column (\d+)|end of document)\)$")
_COMMA = re.compile(r"=\s*[-+]?\d+,\d+\s*(#.*)?$")
_BARE = re.compile(r"=\s*[A-Za-z][^\"']*$")
_HINTS = (
    (re.compile("[\u2018\u2019\u201c\u201d\u201e]"), "; the quotes have to be straight ones"),
    (re.compile(r'"[^"]*\\'), "; in a path write / instead of \\, or put it into '...'"),
    (_COMMA, "; a decimal sign is a point"),
    (_BARE, "; text stands in quotes"),
)
_OTHER = {b"<": "XML or HTML", b"{": "JSON", b"PK": "a zip or office file", b"%PDF": "a PDF"}


def file_bytes(label: str, path: Path | Traversable, refuse: Refuse) -> bytes:
    """The content of a file; ``label``: what messages call it."""
    try:
        return path.read_bytes()
    except (OSError, ValueError) as error:
        raise refuse(f"{label}: {_why_unread(path, error)}") from error


def decoded(label: str, raw: bytes, refuse: Refuse) -> str:
    """UTF-8 text, with or without byte order mark."""
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise refuse(f"{label}: is UTF-16 text; save it as UTF-8")
    if b"\0" in raw:
        raise refuse(f"{label}: is binary, not text")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line, byte = raw.count(b"\n", 0, error.start) + 1, raw[error.start : error.start + 1]
        shown = byte.decode("cp1252", errors="replace")
        why = f"byte 0x{byte.hex()} is not UTF-8 ({shown!r} in Windows-1252?); save it as UTF-8"
        raise refuse(f"{label}: row {line}: {why}") from error


def toml_table(label: str, path: Path | Traversable, refuse: Refuse, schema: str = "") -> dict[str, Any]:
    """The table of a TOML file, which has this ``schema`` or none."""
    return parsed_toml(label, file_bytes(label, path, refuse), refuse, schema)


def parsed_toml(label: str, raw: bytes, refuse: Refuse, schema: str = "") -> dict[str, Any]:
    """The table of the bytes of a TOML file."""
    begin = raw.removeprefix(b"\xef\xbb\xbf").lstrip()
    for mark, kind in _OTHER.items():
        if begin.startswith(mark):
            raise refuse(f"{label}: is {kind}, not TOML; is it the right file?")
    text = decoded(label, raw, refuse)
    try:
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise refuse(_not_toml(label, text, str(error))) from error
    given = table.get("schema", schema)
    if schema and given != schema:
        raise refuse(f"{label}: schema = {given!r}, expected {schema!r}; is it the right file?")
    return table


def _why_unread(path: Path | Traversable, error: OSError | ValueError) -> str:
    if isinstance(error, FileNotFoundError):
        if str(path) == "-":
            return "standard input is not read: name a file"
        return "there is no such file; check the name and the folder"
    if isinstance(error, IsADirectoryError):
        return "is a folder; name a file"
    return f"cannot be read: {getattr(error, 'strerror', None) or error}"


def _not_toml(label: str, text: str, why: str) -> str:
    """With the line as it stands there."""
    place = _AT.search(why)
    why = _AT.sub("", why)
    lines = text.splitlines()
    number = int(place[1]) if place and place[1] else len(lines)
    line = lines[number - 1].strip() if 0 < number <= len(lines) else ""
    if line.count(",") > 2 and "=" not in line:
        hint = "; this looks like a csv table, is it the right file?"
        return f"{label}: is not TOML: line {number}, {line[:60]!r}{hint}"
    hint = next((hint for pattern, hint in _HINTS if pattern.search(line)), "")
    if why.startswith("Cannot overwrite") or why.startswith("Cannot declare"):
        hint = "; it stands there twice: take one out"
    return f"{label}: is not TOML: line {number}, {line[:80]!r}: {why[:1].lower()}{why[1:]}{hint}"
