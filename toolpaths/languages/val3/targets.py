"""Targets, speeds and tools of the moves of a VAL3 program.

Source: VAL3 Reference Manual (D28062804A), 8 arm positions (appro, father frames), 9 movement control (mdesc).
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from toolpaths.frame import Frame
from toolpaths.interpreting.robot_track import RobotTrack
from toolpaths.interpreting.values import Runtime
from toolpaths.languages.val3.values import JOINTED, POINTS, ValValues, matrix, numbers_of
from toolpaths.rotation import staubli_from_matrix
from toolpaths.tool_frame import ToolFrame
from toolpaths.toolpath import Floats

_APPRO = re.compile(r"appro\s*\(\s*([^,(){}]+),\s*(\{[^{}]*\})\s*\)")
_NAN = float("nan")
FASTEST = 9999.0  # mm/s: tvel that limits nothing


@dataclass(frozen=True)
class ValTarget:
    """Where a move leads.

    Attributes:
        numbers: x, y, z in mm, rx, ry, rz in deg, in the father frame; or six angles in deg.
        jointed: they are angles.
        father: (4, 4) of the father frame in world, m; None: it is not in the file.
        unknown: its name then.
    """

    numbers: tuple[float, ...]
    jointed: bool = False
    father: Floats | None = None
    unknown: str = ""

    def beside(self, other: ValTarget) -> bool:
        """Whether both are given in the same frame."""
        if self.father is None or other.father is None:
            return self.father is other.father and self.unknown == other.unknown
        return np.array_equal(self.father, other.father)


class ValSpeed(NamedTuple):
    """Speed, mm/s, and corner, mm, of a move; NaN where they are not given."""

    feed: float
    zone: float


def target_of(values: ValValues, text: str) -> ValTarget | Runtime:
    """The target that an argument of a move gives."""
    more = None
    if m := _APPRO.fullmatch(text):
        more = numbers_of(m[2])
        if more is None or len(more) != 6:
            return Runtime(f"{m[2][:30]} is no trsf of six numbers")
        text = m[1]
    key = values.find(text)
    if key is None:
        return Runtime(f"{text[:30]} is not in the data of the program")
    fields, kind = values.get(key), values.kinds[key[0]]
    if isinstance(fields, Runtime):
        return fields
    if kind not in (*JOINTED, *POINTS):
        return Runtime(f"{text[:30]} is a {kind or 'name without a type'}, no point")
    numbers = values.joints(fields) if kind in JOINTED else values.trsf(fields)
    if isinstance(numbers, Runtime):
        return numbers
    if kind in JOINTED:
        return ValTarget(numbers, jointed=True)
    if more is not None:
        moved = matrix(numbers) @ matrix(more)
        angles = np.degrees(staubli_from_matrix(moved[:3, :3]))
        numbers = (*(moved[:3, 3] * 1e3).tolist(), *angles.tolist())
    father = values.placed(fields, "world")
    if isinstance(father, Runtime):
        return ValTarget(numbers, unknown=father.reason)
    return ValTarget(numbers, father=father)


def speed_of(values: ValValues, text: str) -> ValSpeed | Runtime:
    """What a movement descriptor gives; nothing where it is not in the data."""
    key = values.find(text)
    if key is None:
        return ValSpeed(_NAN, _NAN)
    fields = values.get(key)
    if isinstance(fields, Runtime):
        return fields
    given = [fields.get(name, _NAN) for name in ("tmax", "leave", "reach")]
    numbers = [v for v in given if isinstance(v, float)]
    if len(numbers) < 3 or numbers[0] <= 0.0:
        return Runtime(f"{text[:30]} has {given[0]!r}, {given[1]!r}, {given[2]!r} as speed, leave, reach")
    blend = str(fields.get("blend", "")).lower()
    zone = 0.0 if blend == "off" else max(*numbers[1:], 0.0) if blend else _NAN
    return ValSpeed(numbers[0] if numbers[0] < FASTEST else _NAN, zone)


class ValTools:
    """The tools of a program by number.

    Args:
        values: where their frames are.
        track: gets those that are known.
    """

    def __init__(self, values: ValValues, track: RobotTrack) -> None:
        self._values, self._track = values, track
        self._numbers: dict[tuple[str, int], int] = {}

    def number(self, text: str) -> int:
        """0 is the flange; else that of the name where it ends in one, or the next free one."""
        if text.split("[")[0].strip().lower() == "flange":
            return 0
        key = self._values.find(text) or (text.strip().lower(), 0)
        if key not in self._numbers:
            self._numbers[key] = self._free(key)
            fields = self._values.values.get(key, Runtime(text))
            if not isinstance(fields, Runtime):
                numbers, father = self._values.trsf(fields), self._values.placed(fields, "flange")
                if not isinstance(numbers, Runtime) and not isinstance(father, Runtime):
                    self._track.tools[self._numbers[key]] = ToolFrame(key[0], Frame.of(father @ matrix(numbers)))
        return self._numbers[key]

    def _free(self, key: tuple[str, int]) -> int:
        taken = set(self._numbers.values())
        digits = re.search(r"\d{1,4}$", key[0])
        wanted = int(digits[0]) if digits and not key[1] else 0
        return wanted if wanted and wanted not in taken else next(n for n in range(1, len(taken) + 2) if n not in taken)
