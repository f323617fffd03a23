"""What M words of a CNC program ask of the machine: the spindle's columns, and commands in the order of RS-274."""

from __future__ import annotations

from collections.abc import Sequence

from toolpaths.reading.track import Track
from toolpaths.toolpath import CLOCKWISE, COUNTERCLOCKWISE, MachineCommand

#: M words that turn the spindle; 13 and 14 put the coolant on as well.
SENSES = {3: int(CLOCKWISE), 4: int(COUNTERCLOCKWISE), 13: int(CLOCKWISE), 14: int(COUNTERCLOCKWISE)}
_WITH_COOLANT = (13, 14)
_STOPS = frozenset((5, 6, 19))  # it stands for a tool change and where it is oriented, too
_HALTS = (0, 1)


def stay(seconds: float) -> MachineCommand:
    """A dwell."""
    return MachineCommand("G4", {"P": seconds})


def machine_commands(
    track: Track, ms: Sequence[int], *, speed: float | None = None, tool: int | None = None, mounted: bool = True
) -> tuple[MachineCommand, ...]:
    """Turn the spindle of a track as a block says, and tell what else the block asks for.

    Args:
        track: gets the speed and the sense from its next move on.
        ms: M words of the block, without those that end the program.
        speed: S of the block, 1/min.
        tool: that the block calls.
        mounted: the tool comes into the spindle; else it is made ready.
    """
    spindle, at = track.spindle, len(track)
    if speed is not None:
        spindle.say(speed, at)
    if not _STOPS.isdisjoint(ms):
        spindle.stop(at)
    turned = [SENSES[m] for m in ms if m in SENSES]
    for sense in turned:
        spindle.turn(sense, at)
    out = [] if tool is None else [MachineCommand("M6" if mounted else "T", {"T": float(tool)})]
    if turned or (speed is not None and spindle.turns):
        rpm = spindle.rpm
        word = "M4" if spindle.sense == COUNTERCLOCKWISE else "M3"
        out.append(MachineCommand(word, {"S": round(rpm, 6)} if rpm == rpm else {}))
    rest = [8 if m in _WITH_COOLANT else m for m in ms if m != 6 and (m not in SENSES or m in _WITH_COOLANT)]
    out += [MachineCommand(f"M{m}") for m in sorted(rest, key=lambda m: m in _HALTS)]
    return tuple(out)
