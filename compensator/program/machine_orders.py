"""What a toolpath asks of the machine, with the lines that [program.events] gives for it."""

from __future__ import annotations

from collections.abc import Mapping

from compensator.cell.run_tables import PLACEHOLDER
from compensator.errors import CellError
from toolpaths.toolpath import Event, MachineCommand, Toolpath
from toolpaths.writing.numbers import number
from toolpaths.writing.program import Order


def orders(toolpath: Toolpath, given: Mapping[str, tuple[str, ...]], cell: str) -> tuple[Order, ...]:
    """Every command of the toolpath's events.

    Args:
        given: word of a command -> lines of the program; no lines: nothing is to be done.
        cell: the file that gives them, for messages.

    Raises:
        CellError: a line needs a number that the toolpath does not give there; names the line.
    """
    out = []
    for event in toolpath.events:
        source = toolpath.sources[event.file] if toolpath.sources else toolpath.source
        for command in event.commands:
            lines = given.get(command.word)
            if lines is not None:
                lines = tuple(_filled(text, command, event, source=source, cell=cell) for text in lines)
            out.append(Order(event.pose, command, line=event.line, text=event.word, lines=lines, source=source))
    return tuple(out)


def _filled(text: str, command: MachineCommand, event: Event, *, source: str, cell: str) -> str:
    for letter in PLACEHOLDER.findall(text):
        if letter not in command.values:
            raise CellError(
                f"{source}:{event.line}: {event.word!r} gives no {letter}, and {cell} writes {text!r} for "
                f"{command.word}: put {letter} into the toolpath, or write the number in [program.events]"
            )
    return PLACEHOLDER.sub(lambda m: number(command.values[m[1]], 3), text)
