"""The table of docs/effects.md, made from the catalogue so that the page cannot differ from the code."""

from __future__ import annotations

from stiffness.effects import BUILT_IN
from stiffness.effects.effect import Parameter

_SIZES = {"joint": "one per joint", "pair": "one per pair of joints", "place": "one per place", 1: "one"}


def markdown() -> str:
    """Keys, units, bounds and defaults of every effect, as Markdown."""
    lines = [
        "| effect | scope | key | unit | numbers | bounds | default | meaning |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for effect in BUILT_IN:
        for p in effect.parameters:
            names = (f"`{effect.name}`", effect.scope, f"`{p.name}`")
            lines.append("| " + " | ".join((*names, p.unit, _size(p), _bounds(p), _default(p), p.meaning)) + " |")
    return "\n".join(lines) + "\n"


def _size(p: Parameter) -> str:
    words = _SIZES.get(p.size, str(p.size))
    return words if p.each == 1 else words.replace("one", str(p.each))


def _bounds(p: Parameter) -> str:
    return f"{p.low:g} ... {p.high:g}"


def _default(p: Parameter) -> str:
    return "must be given" if p.default is None else f"{p.default:g}"
