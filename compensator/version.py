"""The version of this program, as model files and reports name it."""

from __future__ import annotations

from importlib import metadata


def version() -> str:
    """The installed version; ``unknown`` when run from a folder that was never installed."""
    try:
        return metadata.version("toolpath-compensator")
    except metadata.PackageNotFoundError:
        return "unknown"
