"""What the tables of our TOML files share: strict numbers, no unknown keys, and units that are looked at twice."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import ConfigDict, Strict

from stiffness.schema import StrictTable, listed_numbers

Number = Annotated[float, Strict()]  # TOML has numbers: "250" and "250 mm" are mistakes
Three = Annotated[tuple[Number, Number, Number], listed_numbers(3)]
Wrench = Annotated[
    tuple[Number, Number, Number, Number, Number, Number],
    listed_numbers(6, "fx, fy, fz in N, mx, my, mz in N*m, on the robot, about the TCP"),
]


class TomlTable(StrictTable):
    """A table of a file: unknown keys and numbers that are not finite are refused; it does not change once read."""

    model_config = ConfigDict(allow_inf_nan=False)


def refuse_metres(name: str, xyz: tuple[float, float, float]) -> None:
    """Refuse a length in mm that was most likely meant in m.

    Raises:
        ValueError: it is above 0 and below 5 mm.
    """
    length = float(np.linalg.norm(xyz))
    if 0 < length < 5:
        raise ValueError(f"{name} is {length:g} mm long: expected mm, this looks like metres")


def refuse_radians(name: str, angles: tuple[float, ...]) -> None:
    """Refuse angles in deg that were most likely meant in rad.

    Raises:
        ValueError: one is a quarter turn, or a few of them, in rad.
    """
    for a in angles:
        quarters = round(abs(a) / (np.pi / 2))
        if 1 <= quarters <= 4 and abs(abs(a) - quarters * np.pi / 2) < 1e-3:
            raise ValueError(f"{name} holds {a:g}: expected deg, this looks like a multiple of pi/2 in rad")
