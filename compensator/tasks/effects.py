"""What `effects` shows: the catalogue, and one effect of it."""

from __future__ import annotations

import difflib
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import entry_points

from compensator.errors import CompensatorError
from stiffness.effects import BY_NAME, CATALOGUE
from stiffness.effects.effect import Effect, Parameter
from stiffness.effects.plugins import GROUP

WIDTH = 110
_SEATS = {
    "joint": "every joint",
    "link": "every link",
    "inner-link": "every link but the last",
    "pair": "every pair of joints",
    "place": "base, every link and tool",
}
_COUNTS = {"joint": "one per joint", "pair": "one per pair of joints", "place": "base, one per link, tool", 1: "one"}
_SCOPES = {
    "robot": "robot: goes wherever the robot goes",
    "tool": "tool: holds for the tool that it was measured with",
    "instruments": "instruments: judges readings, never acts on a planned path",
    "process": "process: holds for the material and the cutter that were traced",
}
_SLOTS = {
    "joint": "deflects joints",
    "angle": "turns joints by an error of their angle",
    "torque": "loads joints",
    "mass": "adds weight",
    "place": "moves the places that it sits in",
    "wrench_reading": "changes what the wrench sensor shows",
    "position_reading": "changes what the tracker shows",
    "process_wrench": "changes the wrench that the process says",
    "surface_reading": "changes the deviation that a cut surface shows",
}


@dataclass(frozen=True)
class Listed:
    """One effect of the catalogue: where it sits, and the package that brought it ("" for a built-in one)."""

    effect: Effect
    where: str
    package: str


def catalogue() -> tuple[Listed, ...]:
    """Every effect that is installed, in the order of the catalogue."""
    packages = _packages()
    return tuple(Listed(e, _seat(e), packages.get(e.name, "")) for e in CATALOGUE)


def _seat(effect: Effect) -> str:
    return "; ".join(_SEATS.get(kind, kind) for kind in effect.site_kind.split("|"))


def _packages() -> dict[str, str]:
    """Effect -> package, of those that come through the entry point; the catalogue has loaded them already."""
    return {entry.load().name: entry.dist.name if entry.dist else "?" for entry in entry_points(group=GROUP)}


def effects_lines() -> list[str]:
    """The catalogue: a line of name, scope, seat and package, and the cause below it."""
    listed = catalogue()
    foreign = any(one.package for one in listed)
    head = ("name", "scope", "sits in", "from") if foreign else ("name", "scope", "sits in")
    rows = [(o.effect.name, o.effect.scope, o.where, f"package {o.package}" if o.package else "") for o in listed]
    first, *rest = _columns([head, *(row[: len(head)] for row in rows)])
    lines = [first]
    for line, one in zip(rest, listed, strict=True):
        lines += [line, *textwrap.wrap(one.effect.cause, WIDTH, initial_indent="    ", subsequent_indent="    ")]
    return lines


def effect_lines(name: str) -> list[str]:
    """One effect: cause, scope, seat, what it does, its parameters.

    Raises:
        CompensatorError: there is no effect of this name.
    """
    if name not in BY_NAME:
        near = difflib.get_close_matches(name, BY_NAME, 1)
        meant = f"did you mean {near[0]!r}? " if near else ""
        raise CompensatorError(
            f"no effect is named {name!r}; {meant}`compensator effects` lists all; "
            "one of another package has to be installed beside this program (docs/own-effect.md)"
        )
    (one,) = (o for o in catalogue() if o.effect.name == name)
    effect = one.effect
    does = [words for slot, words in _SLOTS.items() if getattr(effect, slot) is not None]
    if effect.memory is not None:
        does.append(f"remembers the way it came ({effect.memory.unit})")
    told = [
        ("scope", _SCOPES[effect.scope]),
        ("sits in", one.where),
        ("what it does", ", ".join(does)),
        ("in a model", f"[effects.{name}]"),
    ]
    if one.package:
        told.append(("from", f"package {one.package}"))
    head = ("parameter", "unit", "numbers", "bounds", "default", "meaning")
    rows = [head, *(_row(p) for p in effect.parameters)]
    return [name, *textwrap.wrap(effect.cause, WIDTH), "", *_columns(told), "", *_columns(rows)]


def _row(p: Parameter) -> tuple[str, ...]:
    default = "must be given" if p.default is None else f"{p.default:g}"
    return (p.name, p.unit, _COUNTS.get(p.size, str(p.size)), f"{p.low:g} ... {p.high:g}", default, p.meaning)


def _columns(rows: Sequence[Sequence[str]]) -> list[str]:
    """Rows as lines, every column as wide as its widest entry."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(text.ljust(w) for text, w in zip(row, widths, strict=True)).rstrip() for row in rows]
