"""Names and comments as controllers accept them: ASCII, legal, short, unique."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Collection


def plain(text: str, limit: int = 72) -> str:
    """One line of printable ASCII, at most ``limit`` characters; accents go, the rest becomes ``?``."""
    decomposed = unicodedata.normalize("NFKD", " ".join(text.split()))
    kept = "".join(c for c in decomposed if not unicodedata.combining(c))
    return re.sub(r"[^ -~]", "?", kept)[:limit]


def words_of(text: str) -> frozenset[str]:
    """The words of a line."""
    return frozenset(text.split())


def is_legal(name: str, limit: int, reserved: Collection[str]) -> bool:
    """Whether a controller takes the name: letter first, letters, digits and _, length, no reserved word."""
    return re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name) is not None and (
        len(name) <= limit and name.upper() not in reserved
    )


def legal_name(text: str, limit: int, reserved: Collection[str]) -> str:
    """The nearest legal name: other characters become _, a letter is put in front, the end is cut off."""
    name = re.sub(r"[^A-Za-z0-9_]", "_", plain(text, 200)) or "P"
    name = name if name[0].isalpha() else "P_" + name.lstrip("_")
    name = name[:limit]
    return name if name.upper() not in reserved else (name[: limit - 2] + "_P")
