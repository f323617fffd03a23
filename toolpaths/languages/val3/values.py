"""ValValues: what the names of a VAL3 program stand for while it runs: points, frames, tools, joints, descriptors.

Source: VAL3 Reference Manual (D28062804A), 8 arm positions (trsf: rx, ry, rz about moving axes; a point in its
father frame; defaults 0), 9 movement control (mdesc).
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from toolpaths.interpreting.values import Runtime
from toolpaths.languages.val3.scan import LARGEST, Fields, ValData
from toolpaths.rotation import matrix_from_staubli
from toolpaths.toolpath import Floats

TRSF = ("x", "y", "z", "rx", "ry", "rz")
JOINTS = ("j1", "j2", "j3", "j4", "j5", "j6")
POINTS, JOINTED = ("point", "pointrx"), ("joint", "jointrx")
#: The names of speeds and distances in programs, and in the data beside them.
SPELLED = {"tvel": "tmax", "rvel": "rmax"}
_N = r"[-+]?(?:\d+\.?\d*|\.\d+)"
REFERENCE = re.compile(r"([A-Za-z_]\w*)(?:\[(\d{1,6})\])?")
_TUPLE = re.compile(rf"\{{\s*({_N}(?:\s*,\s*{_N})*)\s*\}}")
MOST_FATHERS = 20


def numbers_of(text: str) -> tuple[float, ...] | None:
    """The numbers of ``{1, 2.5, -3}``; None where it is not that."""
    m = _TUPLE.fullmatch(text.strip())
    if m is None:
        return None
    out = tuple(float(part) for part in m[1].split(","))
    return out if max(map(abs, out)) <= LARGEST else None


def matrix(numbers: tuple[float, ...]) -> Floats:
    """(4, 4) of x, y, z in mm and rx, ry, rz in deg; its lengths are m."""
    out = np.eye(4)
    out[:3, :3] = matrix_from_staubli(np.radians(numbers[3:6]))
    out[:3, 3] = np.array(numbers[:3]) * 1e-3
    return out


class ValValues:
    """Data by name and index, as far as the program has not made them unknown.

    Args:
        data: of the application.
    """

    def __init__(self, data: dict[str, ValData]) -> None:
        self.kinds = {name: d.kind for name, d in data.items()}
        self.values: dict[tuple[str, int], Fields | Runtime] = {
            (name, k): v for name, d in data.items() for k, v in d.values.items()
        }
        self._fathers: dict[tuple[str, str], Floats | Runtime] = {}  # as long as no frame changes

    def declare(self, data: dict[str, ValData]) -> None:
        """The data of one more program; they hide others of the same name."""
        for name, d in data.items():
            self.kinds[name] = d.kind
            self.values.update({(name, k): v for k, v in d.values.items()})
        self._fathers.clear()

    def find(self, text: str) -> tuple[str, int] | None:
        """Name and index of ``name`` or ``name[2]`` that is declared; None: it is not."""
        m = REFERENCE.fullmatch(text.strip())
        if m is None:
            return None
        key = m[1].lower(), int(m[2] or 0)
        return key if key in self.values else None

    def get(self, key: tuple[str, int]) -> Fields | Runtime:
        """What an element gives."""
        return self.values[key]

    def put(self, key: tuple[str, int], **given: Any) -> None:
        """Set some fields of an element."""
        old = self.values[key]
        if self.kinds[key[0]] not in POINTS:
            self._fathers.clear()
        if not isinstance(old, Runtime):
            self.values[key] = {**old, **given}

    def forget(self, name: str, reason: str) -> None:
        """The elements of a name are known only while the program runs."""
        for key in self.values:
            if key[0] == name:
                self.values[key] = Runtime(reason)
        self._fathers.clear()

    def trsf(self, fields: Fields) -> tuple[float, ...] | Runtime:
        """x, y, z in mm, rx, ry, rz in deg, of a point, frame or tool."""
        return _numbers(fields, TRSF)

    def joints(self, fields: Fields) -> tuple[float, ...] | Runtime:
        """Six angles, deg."""
        return _numbers(fields, JOINTS)

    def placed(self, fields: Fields, root: str) -> Floats | Runtime:
        """(4, 4) of where a father stands in ``root`` (world or flange), through its own fathers.

        A Runtime has the name of the one that is not known as its reason.
        """
        key = str(fields.get("fatherId", f"{root}[0]")), root
        if key not in self._fathers:
            self._fathers[key] = self._placed(*key)
        return self._fathers[key]

    def _placed(self, father: str, root: str) -> Floats | Runtime:
        out = np.eye(4)
        for _ in range(MOST_FATHERS):
            if father.split("[")[0].lower() == root:
                return out
            key = self.find(father)
            found = Runtime(father) if key is None else self.values[key]
            if isinstance(found, Runtime):
                return Runtime(father)
            numbers = self.trsf(found)
            if isinstance(numbers, Runtime):
                return Runtime(father)
            out, father = matrix(numbers) @ out, str(found.get("fatherId", f"{root}[0]"))
        return Runtime(f"{father}, whose frames have each other as fathers")


def _numbers(fields: Fields, names: tuple[str, ...]) -> tuple[float, ...] | Runtime:
    out = tuple(fields.get(name, 0.0) for name in names)
    bad = next((f"{n} = {v!r}" for n, v in zip(names, out, strict=True) if not isinstance(v, float)), None)
    return Runtime(f"{bad[:30]} is no number") if bad else tuple(float(v) for v in out)
