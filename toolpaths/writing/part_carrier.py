"""Part carrier: the mechanical unit of a controller that turns the part while a program runs.

The poses of such a program are on the part; between two of them the controller goes straight on the part, whatever its
unit does meanwhile. The controller knows where the unit stands, the program only where the work object is on it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from toolpaths.finding import ERROR, Finding
from toolpaths.frame import Frame

Floats = npt.NDArray[np.float64]
#: How programs of a language tell what carries the part: by its name, its number, in a table of poses not at all;
#: "": they have no words for it here.
UnitWords = Literal["", "name", "number", "none"]
EXAMPLES = {"name": '"STN1"', "number": "2"}


@dataclass(frozen=True, repr=False, eq=False)
class PartCarrier:
    """A table that turns while it cuts.

    Attributes:
        axis: as the cell calls it. unit: its name, or its number in MACHINE_DEF; None: not given.
        frame: of the unit in the base with the axis at 0; None: not given.
        direction: (3,) of length 1, base, that it turns about as the value rises. center: (3,) m of it.
    """

    axis: str
    unit: str | int | None
    frame: Frame | None
    direction: Floats
    center: Floats

    def __repr__(self) -> str:
        return f"PartCarrier({self.axis}, {self.unit!r})"

    @property
    def stands(self) -> Frame:
        """The frame of the unit, which has to be given.

        Raises:
            ValueError: it is not.
        """
        if self.frame is None:
            raise ValueError(f"{self.axis}: the frame of its mechanical unit is not given")
        return self.frame

    def on_unit(self, workobject: Frame) -> Frame:
        """A work object, in the base with the axis at 0, in the frame of the unit."""
        return workobject.relative_to(self.stands)

    @property
    def about_z(self) -> bool:
        """Whether the unit turns about z of its frame, the right-handed way."""
        if self.frame is None:
            return True
        z, off = self.frame.rotation[:, 2], self.center - self.frame.origin
        return bool(z @ self.direction > 1.0 - 1e-6 and np.linalg.norm(np.cross(off, self.direction)) < 1e-3)


def carrier_findings(carrier: PartCarrier, words: UnitWords, language: str) -> Iterator[Finding]:
    """Errors where a program cannot tell what carries its part."""
    place = f"external.{carrier.axis}"
    still = "or take speed and acceleration away: then the table is set once, and nothing has to be coordinated"
    if not words:
        what = f"a program in {language} has no words here for a table that turns while it cuts ({carrier.axis})"
        yield Finding(ERROR, place, what, f"write RAPID, KRL or csv, {still}")
    elif words != "none" and (carrier.unit is None or carrier.frame is None):
        what = f"unit is missing: a program in {language} tells by its {words} which mechanical unit turns the part"
        remedy = f"give unit = {EXAMPLES[words]}, and unit_xyz and unit_rpy, where its frame stands with the axis at 0"
        yield Finding(ERROR, place, what, f"{remedy}, {still}")
    elif words != "none" and isinstance(carrier.unit, str) != (words == "name"):
        what = f"unit = {carrier.unit!r}: a program in {language} tells the {words} of the mechanical unit"
        yield Finding(ERROR, place, what, f"give one such as {EXAMPLES[words]}, {still}")
