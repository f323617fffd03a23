"""G68.2: a tilted working plane; what follows is in its coordinates, with the tool along its z axis.

Source: Fanuc Series 30i operator's manual B-64484EN, "Tilted working plane indexing": origin X Y Z in the coordinate
system in force, then Euler angles, a turn by I about Z, by J about the new X, by K about the new Z. G53.1 turns the
tool into the plane; G69 ends it.
"""

from __future__ import annotations

import numpy as np

from toolpaths.frame import Floats, Frame, Vector
from toolpaths.languages.gcode.words import Words


def tilted_plane(values: Words, unit: float, shift: Vector) -> Frame:
    """The plane in the work object, m.

    Args:
        values: words of the G68.2 block.
        unit: m of one length unit.
        shift: of the coordinate system in force, m.

    Raises:
        ValueError: another form of G68.2, or words that do not belong to it.
    """
    if values.get("P", 0.0) != 0.0:
        raise ValueError(f"G68.2 P{values['P']:g}: read is the form with Euler angles (P0), X Y Z I J K")
    others = values.keys() - set("XYZIJKPN")
    if others:
        raise ValueError(f"G68.2 with {', '.join(sorted(others))}")
    origin = [values.get(c, 0.0) * unit + s for c, s in zip("XYZ", shift, strict=True)]
    first, second, third = (np.radians(values.get(c, 0.0)) for c in "IJK")
    return Frame(_about_z(first) @ _about_x(second) @ _about_z(third), np.array(origin))


def _about_z(angle: float) -> Floats:
    c, s = np.cos(angle), np.sin(angle)
    return _exact(np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]))


def _about_x(angle: float) -> Floats:
    c, s = np.cos(angle), np.sin(angle)
    return _exact(np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]))


def _exact(turn: Floats) -> Floats:
    """Without what sine and cosine of right angles leave."""
    return np.where(np.abs(turn) < 1e-15, 0.0, turn)
