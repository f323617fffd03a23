"""The page of ``view``: the scene with what is edited; it talks to the server that it comes from and to no other."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from compensator.report.html.page import template_page, three_js


def view_page(shown: Mapping[str, Any], names: Mapping[str, str], token: str, spare: str) -> str:
    """The page of a cell.

    Args:
        shown: scene, numbers and values, as ``LiveCell`` has them. names: of ``cell`` and ``toolpath``.
        token: that the server asks for. spare: a name to save under.
    """
    return template_page(
        "view",
        title=f"{names['cell']}: the cell at work",
        scene=shown["scene"],
        numbers=shown["numbers"],
        values=shown["values"],
        names=names,
        view={"token": token, "spare": spare, "values": shown["values"]},
        three_js=three_js(),
    )
