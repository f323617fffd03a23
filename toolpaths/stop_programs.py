"""Programs that drive to postures and wait there: which languages have them, and how they are written."""

from __future__ import annotations

from pathlib import Path

from toolpaths.errors import WriteError
from toolpaths.languages.table import LANGUAGES, Language
from toolpaths.writing.stops import Stops

JOINTS = 6


def stopping_languages() -> list[str]:
    """Names of the languages that such a program is written in."""
    return [name for name, language in LANGUAGES.items() if language.stops]


def write_stops(stops: Stops, path: Path, language: Language, name: str) -> None:
    """Write the program to ``path``.

    Args:
        name: of the program, as the user calls it.

    Raises:
        WriteError: the language or the arm cannot have such a program.
    """
    if not language.stops:
        known = ", ".join(stopping_languages())
        raise WriteError(f"{path}: a program that drives to postures is not written as {language.name}; known: {known}")
    if stops.joints.shape[1] != JOINTS:
        raise WriteError(f"{path}: {stops.robot} has {stops.joints.shape[1]} joints; the language takes {JOINTS}")
    path.write_bytes(language.stops_text(stops, name).encode("ascii"))
