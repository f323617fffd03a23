"""Registers of a Fanuc program as far as they are constant: R[n] and PR[n], set to numbers before they are used."""

from __future__ import annotations

import re

import numpy as np

from toolpaths.interpreting.values import Runtime
from toolpaths.rotation import matrix_from_fanuc
from toolpaths.toolpath import Floats

CONSTANT = re.compile(r"-?(?:\d+\.?\d*|\.\d+)")
_VALUE = r"\s*=\s*(\()?\s*(-?[\d.]+)\s*(\))?"
_ELEMENT = re.compile(rf"PR\[(?:GP1:)?(\d+)(?::[^\],]*)?,([1-6])(?::[^\]]*)?\]{_VALUE}")
_NUMBER = re.compile(rf"R\[(\d+)(?::[^\]]*)?\]{_VALUE}")
_ASSIGNED = re.compile(r"(P?R)\[(?:GP\d:)?(\d*)[^=]*\]\s*=")


class Registers:
    """What is known of them at a place of the program."""

    def __init__(self) -> None:
        self._numbers: dict[int, float] = {}
        self._places: dict[int, list[float | None]] = {}

    def assign(self, text: str) -> bool:
        """Follow an assignment; False where the statement is none.

        Raises:
            ValueError: the constant is not a number.
        """
        if m := _ELEMENT.fullmatch(text):
            self._places.setdefault(int(m[1]), [None] * 6)[int(m[2]) - 1] = _constant(m[3], m[4], m[5])
        elif m := _NUMBER.fullmatch(text):
            self._numbers[int(m[1])] = _constant(m[2], m[3], m[4])
        else:
            return self.spoil(text)
        return True

    def spoil(self, text: str) -> bool:
        """What the statement sets is not known behind it; False where it sets no register."""
        found = _ASSIGNED.match(text)
        if found is None:
            return False
        known: dict[int, float] | dict[int, list[float | None]]
        known = self._numbers if found[1] == "R" else self._places
        if found[2]:
            known.pop(int(found[2]), None)
        else:
            known.clear()  # R[R[1]]: any of them
        return True

    def forget(self) -> None:
        """Another program ran that may set any of them."""
        self._numbers.clear()
        self._places.clear()

    def number(self, n: int) -> float | Runtime:
        """R[n]."""
        return self._numbers.get(n, Runtime(f"R[{n}]"))

    def pose(self, n: int) -> Floats | Runtime:
        """PR[n] as (4, 4), m; Runtime as long as one of its six numbers is not known."""
        values = self._places.get(n)
        if values is None or None in values:
            return Runtime(f"PR[{n}]")
        numbers = np.array(values, dtype=np.float64)
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = matrix_from_fanuc(np.radians(numbers[3:])), numbers[:3] * 1e-3
        return pose


def _constant(opened: str | None, text: str, closed: str | None) -> float:
    if not CONSTANT.fullmatch(text) or bool(opened) != bool(closed):
        raise ValueError(text)
    return float(text)
