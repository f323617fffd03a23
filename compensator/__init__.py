"""Elastic compensation of CAM toolpaths for industrial robots; ``import compensator as comp``: see docs/python.md.

Nothing is imported until a name is first asked for: the help of the command starts as fast as Python does.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from compensator.api import (
        compensate,
        diagnose,
        evaluate,
        identify,
        load_cell,
        load_model,
        load_robot,
        preview,
        read_toolpath,
        write,
    )

    __version__: str

__all__ = [
    "__version__",
    "compensate",
    "diagnose",
    "evaluate",
    "identify",
    "load_cell",
    "load_model",
    "load_robot",
    "preview",
    "read_toolpath",
    "write",
]


def __getattr__(name: str) -> Any:
    """The version, or a function of ``compensator.api``."""
    if name == "__version__":
        from compensator.version import version

        return version()
    if name in __all__:
        from compensator import api

        return getattr(api, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}; it has {', '.join(__all__)}")


def __dir__() -> list[str]:
    """What a notebook offers to complete."""
    return sorted(__all__)
