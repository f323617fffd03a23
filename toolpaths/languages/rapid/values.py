"""Values of RAPID: record types, what the controller predefines, and functions of constants.

Source: ABB 3HAC050917 "RAPID Instructions, Functions and Data types".
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from toolpaths.rotation import matrix_from_quaternion, matrix_from_rpy, quaternion_from_matrix
from toolpaths.writing.program import Floats

#: A number, a truth, a string, a list (record or array), or Runtime.
Value = Any


#: Record type -> components and their types.
RECORDS: dict[str, tuple[tuple[str, str], ...]] = {
    "pos": tuple((k, "num") for k in "xyz"),
    "orient": tuple((k, "num") for k in ("q1", "q2", "q3", "q4")),
    "pose": (("trans", "pos"), ("rot", "orient")),
    "confdata": tuple((k, "num") for k in ("cf1", "cf4", "cf6", "cfx")),
    "extjoint": tuple((f"eax_{k}", "num") for k in "abcdef"),
    "robjoint": tuple((f"rax_{k}", "num") for k in range(1, 7)),
    "robtarget": (("trans", "pos"), ("rot", "orient"), ("robconf", "confdata"), ("extax", "extjoint")),
    "jointtarget": (("robax", "robjoint"), ("extax", "extjoint")),
    "loaddata": (
        ("mass", "num"), ("cog", "pos"), ("aom", "orient"), ("ix", "num"), ("iy", "num"), ("iz", "num"),
    ),
    "tooldata": (("robhold", "bool"), ("tframe", "pose"), ("tload", "loaddata")),
    "wobjdata": (
        ("robhold", "bool"), ("ufprog", "bool"), ("ufmec", "string"), ("uframe", "pose"), ("oframe", "pose"),
    ),
    "speeddata": tuple((k, "num") for k in ("v_tcp", "v_ori", "v_leax", "v_reax")),
    "zonedata": (
        ("finep", "bool"), ("pzone_tcp", "num"), ("pzone_ori", "num"), ("pzone_eax", "num"), ("zone_ori", "num"),
        ("zone_leax", "num"), ("zone_reax", "num"),
    ),
}  # fmt: skip

_ZERO: list[Value] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]]
_SPEEDS = (
    5, 10, 20, 30, 40, 50, 60, 80, 100, 150, 200, 300, 400, 500, 600, 800, 1000, 1500, 2000, 2500, 3000, 4000, 5000,
    6000, 7000,
)  # fmt: skip
_ZONES = {0: 0.3, **{k: float(k) for k in (1, 5, 10, 15, 20, 30, 40, 50, 60, 80, 100, 150, 200)}}

#: name -> type, value. ``vmax`` is what the robot can do: no feed.
PREDEFINED: dict[str, tuple[str, Value]] = {
    **{f"v{v}": ("speeddata", [float(v), 500.0, 5000.0, 1000.0]) for v in _SPEEDS},
    "vmax": ("speeddata", [math.nan, 500.0, 5000.0, 1000.0]),
    **{f"z{k}": ("zonedata", [False, r, *[1.5 * r] * 2, 0.15 * r, 1.5 * r, 0.15 * r]) for k, r in _ZONES.items()},
    "fine": ("zonedata", [True, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
    "tool0": ("tooldata", [True, _ZERO, [0.001, [0.0, 0.0, 0.001], [1.0, 0.0, 0.0, 0.0], 0.0, 0.0, 0.0]]),
    "load0": ("loaddata", [0.001, [0.0, 0.0, 0.001], [1.0, 0.0, 0.0, 0.0], 0.0, 0.0, 0.0]),
    "wobj0": ("wobjdata", [False, True, "", _ZERO, _ZERO]),
    "pi": ("num", math.pi),
}


def fits(kind: str, value: Value) -> bool:
    """Whether a value has the shape of a type; of unknown types every value has."""
    if kind in RECORDS:
        parts = RECORDS[kind]
        return isinstance(value, list) and len(value) == len(parts) and all(
            fits(k, v) for (_, k), v in zip(parts, value, strict=True)
        )
    if kind in ("num", "dnum"):
        return isinstance(value, float)
    return isinstance(value, {"bool": bool, "string": str}.get(kind, object))


def matrix(pose: list[Value]) -> Floats:
    """(4, 4), m, of a pose in mm.

    Raises:
        ValueError: the quaternion is not of unit length, or a number is not finite.
    """
    out = np.eye(4)
    if not all(map(math.isfinite, pose[0])):
        raise ValueError("a coordinate that is not a finite number")
    length = math.sqrt(sum(q * q for q in pose[1]))
    if not abs(length - 1.0) < 1e-3:
        raise ValueError(f"a quaternion of length {length:.6g}, 1 expected")
    out[:3, :3] = matrix_from_quaternion(np.array(pose[1]))
    out[:3, 3] = np.array(pose[0]) * 1e-3
    return out


def pose_of(frame: Floats) -> list[Value]:
    """A pose, mm, of (4, 4) m."""
    return [(frame[:3, 3] * 1e3).tolist(), quaternion_from_matrix(frame[:3, :3]).tolist()]


def _offs(target: Value, x: float, y: float, z: float) -> Value:
    return [[a + b for a, b in zip(target[0], (x, y, z), strict=True)], *target[1:]]


def _rel_tool(target: Value, x: float, y: float, z: float, rx: float = 0.0, ry: float = 0.0, rz: float = 0.0) -> Value:
    """Shifted and turned in the tool's axes, turned about x, then the new y, then the new z."""
    frame, step = matrix(target[:2]), np.eye(4)
    step[:3, 3] = (x * 1e-3, y * 1e-3, z * 1e-3)
    turns = [matrix_from_rpy(np.radians(t)) for t in ((rx, 0.0, 0.0), (0.0, ry, 0.0), (0.0, 0.0, rz))]
    step[:3, :3] = turns[0] @ turns[1] @ turns[2]
    return [*pose_of(np.asarray(frame @ step)), *target[2:]]


def _orient(z: float, y: float, x: float) -> Value:
    return quaternion_from_matrix(matrix_from_rpy(np.radians([x, y, z]))).tolist()


def _degrees(f: Callable[[float], float]) -> Callable[[float], float]:
    return lambda a: f(math.radians(a))


#: name -> function of constants, and the types of its arguments that are no numbers.
FUNCTIONS: dict[str, tuple[Callable[..., Value], tuple[str, ...]]] = {
    "offs": (_offs, ("robtarget",)),
    "reltool": (_rel_tool, ("robtarget",)),
    "orientzyx": (_orient, ()),
    "posemult": (lambda a, b: pose_of(np.asarray(matrix(a) @ matrix(b))), ("pose", "pose")),
    "poseinv": (lambda a: pose_of(np.asarray(np.linalg.inv(matrix(a)), dtype=np.float64)), ("pose",)),
    "abs": (abs, ()),
    "sqrt": (math.sqrt, ()),
    "pow": (math.pow, ()),
    "sin": (_degrees(math.sin), ()),
    "cos": (_degrees(math.cos), ()),
    "tan": (_degrees(math.tan), ()),
    "atan2": (lambda y, x: math.degrees(math.atan2(y, x)), ()),
    "trunc": (lambda a: float(math.trunc(a)), ()),
}
