"""Names of a robot program: their values, worked out when they are first asked for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from toolpaths.interpreting.program_text import Declaration, ProgramText
from toolpaths.interpreting.values import ExpressionError, Runtime


@dataclass(frozen=True, slots=True)
class Variable:
    """A name's value, None as long as nobody asked for it.

    Attributes:
        declaration: None once the value is not that of the declaration any more.
        type: where the language knows it.
    """

    value: Any
    declaration: Declaration | None
    type: str = ""


def first_value(
    program: ProgramText, known: dict[str, Variable], key: str, name: str, work_out: Callable[[str], Any]
) -> Any:
    """The value that a declaration gives; Runtime where it gives none.

    Args:
        known: variables by ``key``; meanwhile the name counts as declared by itself.
        name: as messages have it.
        work_out: the value of an expression.

    Raises:
        ReadError: it cannot be evaluated.
    """
    variable = known[key]
    d = variable.declaration
    if d is None or d.value[0] < 0:
        return Runtime(f"{name}, which has no value")
    known[key] = replace(variable, value=Runtime(f"{name}, which is declared by itself"))
    try:
        return work_out(program.piece(*d.value))
    except ExpressionError as e:
        program.refuse(d.start, f"{d.name}: {e}")
