"""What statements of an APT/CL file ask of the machine, in the words of G-code where it has them.

Minor words: ISO 4343 (SPINDL, COOLNT, LOADTL, DELAY, STOP, OPSTOP, AUXFUN).
"""

from __future__ import annotations

from collections.abc import Iterator

from toolpaths.languages.apt.words import AptStatement, number
from toolpaths.reading.spindle import SpindleTrack
from toolpaths.toolpath import COUNTERCLOCKWISE, MachineCommand

_COOLANT = {"ON": "M8", "FLOOD": "M8", "MIST": "M7", "OFF": "M9"}
_PLAIN = {"STOP": "M0", "OPSTOP": "M1"}
#: Statements that no word of G-code stands for.
_OWN = frozenset({"COOLNT", "DELAY", "AUXFUN", "PREFUN", "CLAMP", "INSERT"})


def commands_of(s: AptStatement, spindle: SpindleTrack, tool: int) -> Iterator[MachineCommand]:
    """The commands of one statement; ``spindle`` and ``tool`` as it leaves them."""
    minor, value = s.minor, next((v for v in map(number, s.minor) if v is not None), None)
    if s.word == "SPINDL":
        speed = {} if not spindle.rpm > 0 else {"S": spindle.rpm}
        turning = "M4" if spindle.sense == COUNTERCLOCKWISE else "M3"
        yield MachineCommand("M5") if spindle.stands else MachineCommand(turning, speed)
    elif s.word in ("LOAD", "LOADTL", "TOOLNO"):
        yield MachineCommand("M6", {"T": float(tool)})
    elif s.word == "COOLNT" and len(minor) == 1 and minor[0] in _COOLANT:
        yield MachineCommand(_COOLANT[minor[0]])
    elif s.word in _PLAIN:
        yield MachineCommand(_PLAIN[s.word])
    elif s.word == "DELAY" and value is not None and "REV" not in minor:
        yield MachineCommand("G4", {"P": value})
    elif s.word == "AUXFUN" and value is not None and value == int(value):
        yield MachineCommand(f"M{value:g}")
    elif s.word in _OWN:
        yield MachineCommand(s.word)
