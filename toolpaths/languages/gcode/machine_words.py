"""What words of G-code ask of the machine: spindle, tool, the rest."""

from __future__ import annotations

from collections.abc import Iterator

from toolpaths.languages.gcode.words import M_CALL, M_END, M_TAP, Words
from toolpaths.reading.spindle import SpindleTrack
from toolpaths.toolpath import CLOCKWISE, COUNTERCLOCKWISE, MachineCommand

SENSES = {3: int(CLOCKWISE), 4: int(COUNTERCLOCKWISE)}
SPINDLE_STOPS = frozenset((5, 6, 19))  # it stands for a tool change and where it is oriented, too, as LinuxCNC has it


def turning(m: int, speed: float | None) -> MachineCommand:
    """M3 or M4."""
    return MachineCommand(f"M{m}", {} if speed is None else {"S": speed})


def commands(
    values: Words, ms: list[int], spindle: SpindleTrack, speed: float | None, tool: int, changes: bool
) -> Iterator[MachineCommand]:
    """What the words of a block ask of the machine, in the order of RS-274: tool, spindle, the rest, halts.

    Args:
        values: words of the block by letter.
        ms: its M numbers.
        spindle: behind the block.
        speed: S in force.
        tool: T in force.
        changes: the file has an M6: T alone only selects.
    """
    if "T" in values or 6 in ms:
        yield MachineCommand("M6" if 6 in ms or not changes else "T", {"T": float(tool)})
    senses = [m for m in ms if m in SENSES] or [m for m, sense in SENSES.items() if sense == spindle.sense]
    if senses and (not SENSES.keys().isdisjoint(ms) or ("S" in values and spindle.turns)):
        yield turning(senses[0], speed)
    rest = [m for m in ms if m not in (*M_END, M_CALL, M_TAP, 6, *SENSES)]
    yield from (MachineCommand(f"M{m}") for m in sorted(rest, key=lambda m: m in (0, 1)))
