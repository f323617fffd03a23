"""A robot TOML (robot/1: mm, deg, kg; Denavit-Hartenberg rows of both conventions) as the plant reads it."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np

from .geometry import Array, placement, rot_x, rot_z, shift

MM = 1e-3
FILE_KEYS = {"schema", "name", "convention", "sources", "assumptions", "base", "flange", "joints"}
JOINT_KEYS = {"a", "d", "alpha", "offset", "sign", "limits", "speed", "acceleration", "mass", "com", "name", "source"}
TOLD = {"shapes", "tip", "tips", "former_flange", "reach"}  # nothing of them moves the arm with its own flange


def fixed(table: dict[str, Any]) -> Array:
    """(4,4) of a [base] or [flange] table."""
    xyz, rpy = table.get("xyz", (0, 0, 0)), table.get("rpy", (0, 0, 0))
    return placement(MM * np.array(xyz, dtype=float), np.radians(rpy))


def row(joint: dict[str, Any], convention: str) -> tuple[Array, Array]:
    """(4,4) before and after the turn about z.

    Classic: Rz(theta) Tz(d) Tx(a) Rx(alpha); modified (Craig): Rx(alpha) Tx(a) Rz(theta) Tz(d);
    theta = sign q + offset.
    """
    twist, angle = rot_x(np.radians(joint["alpha"])), rot_z(np.radians(joint["offset"]))
    along_x, along_z = shift((MM * joint["a"], 0, 0)), shift((0, 0, MM * joint["d"]))
    if convention == "classic":
        return angle, along_z @ along_x @ twist
    if convention == "modified":
        return twist @ along_x @ angle, along_z
    raise ValueError(f"convention {convention!r}")


def read_toml(path: Path, tip: str | None = None) -> dict[str, Any]:
    """The fields of an Arm; ``tip``: a frame of the file on the flange, by which its last link then ends."""
    file = tomllib.loads(path.read_text(encoding="utf-8"))
    joints = file["joints"]
    unknown = set(file) - FILE_KEYS - TOLD | {key for joint in joints for key in joint} - JOINT_KEYS
    if unknown or file["schema"] != "robot/1":
        raise ValueError(f"{path.name}: the plant does not know {sorted(unknown)} of {file['schema']}")
    rows = [row(joint, file["convention"]) for joint in joints]
    before, after = [b for b, _ in rows], [a for _, a in rows]
    before[0] = fixed(file.get("base", {})) @ before[0]
    beyond = fixed({} if tip is None else file["tips"][tip])
    after[-1] = after[-1] @ fixed(file.get("flange", {})) @ beyond
    known = all("mass" in joint and "com" in joint for joint in joints)
    com = MM * np.array([joint["com"] for joint in joints], dtype=float) if known else None
    if com is not None:
        com[-1] = beyond[:3, :3].T @ (com[-1] - beyond[:3, 3])
    limits = np.radians([joint["limits"] for joint in joints])
    return {
        "name": file["name"],
        "joint_names": tuple(joint.get("name") or f"joint-{k + 1}" for k, joint in enumerate(joints)),
        "before": np.array(before),
        "axis": np.array([[0.0, 0.0, joint.get("sign", 1)] for joint in joints]),
        "after": np.array(after),
        "lower": limits[:, 0],
        "upper": limits[:, 1],
        "mass": np.array([joint["mass"] for joint in joints], dtype=float) if known else None,
        "com": com,
    }
