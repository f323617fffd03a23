"""Text of a device's file: UTF-8, UTF-16 with its mark, else Windows-1252 as shop-floor software writes it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from compensator.devices.readings import DeviceFile
from compensator.errors import DeviceError
from stiffness.text_file import file_bytes

_OTHER = {b"PK": "a zip or office file", b"%PDF": "a PDF", b"\xd0\xcf\x11\xe0": "an old office file"}
CLOSED = ".b5r"  # refused by its reader, which needs no text


def device_text(path: Path, columns: Mapping[str, str] | None = None) -> DeviceFile:
    """A file as text; ``columns``: as the command line maps them.

    Raises:
        DeviceError: it cannot be read, is empty, or is no text.
    """
    label = str(path)
    raw = file_bytes(label, path, DeviceError)
    if path.suffix.lower() == CLOSED:
        return DeviceFile(label, "", columns or {})
    kind = next((what for mark, what in _OTHER.items() if raw.startswith(mark)), None)
    wide = raw.startswith((b"\xff\xfe", b"\xfe\xff"))
    if kind is None and not wide and b"\0" in raw:
        kind = "binary"
    if kind is not None:
        raise DeviceError(f"{label}: is {kind}, not text; export the readings as text or csv")
    text = _decoded(raw, wide)
    if not text.strip():
        raise DeviceError(f"{label}: is empty; export it again")
    return DeviceFile(label, text, columns or {})


def _decoded(raw: bytes, wide: bool) -> str:
    if wide:
        return raw.decode("utf-16", errors="replace")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        return raw.decode("cp1252", errors="replace")
