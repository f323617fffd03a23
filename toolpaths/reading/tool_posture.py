"""ToolPosture: how the tool of a CNC program stands: upright, in a tilted plane, by vectors or by rotary axes."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from toolpaths.frame import Vector
from toolpaths.machine import Machine
from toolpaths.reading.rotary_state import RotaryState

UP: Vector = (0.0, 0.0, 1.0)
SAME_DIRECTION = math.radians(0.01)  # by which axes named by angles may miss the plane that they are to stand in


class ToolPosture:
    """How the tool stands.

    Args:
        machine: what the file was posted for.
        tip_word: as for RotaryState.

    Attributes:
        axis: of the tool, in the work object.
        standing: why it does not stand as moves without ``tip`` need it; empty: it does.
        tip: tool centre point control is on.
        swivelled: a tilted working plane is on: the tool stands along z of its frame.
        vectors: the tool axis was given as a vector.
        waiting: a tilted plane is on, and the rotary axes are not there yet.
    """

    def __init__(self, machine: Machine | None, tip_word: tuple[str, str]) -> None:
        self.axis, self.standing = UP, ""
        self.tip = self.swivelled = self.vectors = self.waiting = False
        self._stands: Vector | None = UP  # as it was turned last; None: only the machine knows
        self.rotary = RotaryState(machine, tip_word)
        self._unchecked = False
        self._turned: dict[str, float] = {}

    @property
    def given(self) -> bool:
        """Place and tool axis do not depend on the rotary axes."""
        return self.swivelled or self.vectors

    def check(self) -> None:
        """The tool stands as a move needs it.

        Raises:
            ValueError: it does not, or that is not known.
        """
        if self.waiting:
            raise ValueError(
                "a cut in a tilted plane, and nothing has turned the rotary axes to it",
                "Turn them by words of their own, or let the control do it (PLANE ... TURN or MOVE; _DIR of CYCLE800).",
            )
        if self.standing and not self.tip:
            raise ValueError(
                f"a move while {self.standing}: where its tip is depends on the machine",
                "Move in a tilted plane or with tool centre point control, or turn the axes back to 0 first.",
            )
        if self._unchecked:
            self._check_angles()

    def tilt(self, axis: Vector, *, turns: bool) -> None:
        """A tilted plane is on; ``turns``: the control turns the rotary axes itself, to where only it knows."""
        self.axis, self.standing, self.swivelled, self.vectors = axis, "", True, False
        self._stands = axis if turns else self._stands
        self.waiting = self._stands is not None and math.dist(self._stands, axis) > SAME_DIRECTION
        if turns and self.rotary.used:
            self.rotary.lose(self.rotary.letters)
        self._unchecked = self.rotary.used

    def level(self, *, turns: bool) -> None:
        """No tilted plane any more; ``turns``: the rotary axes go back to 0, else they stay."""
        tilted, self.swivelled = self.swivelled and self.axis != UP, False
        self.waiting = False
        if turns:
            self.upright()
        elif tilted:
            self.standing = "the tool stands as in the tilted plane before"

    def upright(self) -> None:
        """The tool stands along z of the work object."""
        self.axis, self.standing, self.vectors, self._stands = UP, "", False, UP
        self._turned = dict.fromkeys(self._turned, 0.0)
        self.rotary.zero()

    def end_tip(self) -> None:
        """Tool centre point control off: the tool stays as it stands."""
        self.tip = False
        if self.vectors and self.axis != UP and not self.swivelled:
            self.standing = "the tool stands tilted and tool centre point control is off"

    def point(self, vector: Vector) -> None:
        """A tool vector of any length in the work object, from the tip to the spindle.

        Raises:
            ValueError: it has no length.
        """
        i, j, k = vector
        length = math.sqrt(i * i + j * j + k * k)
        if not length > 1e-6:
            raise ValueError("the tool vector has no length")
        self.axis, self.standing, self.vectors = (i / length, j / length, k / length), "", True
        self._stands = self.axis

    def turn_axes(self, angles: Mapping[str, float], *, alone: bool) -> None:
        """Rotary words.

        Args:
            angles: letter -> absolute position, deg; NaN: one that only the control knows.
            alone: nothing else moves in the block.

        Raises:
            ValueError: what they mean depends on a machine that is not known.
        """
        before, self._turned = self._turned, {**self._turned, **angles}
        known = {c: v for c, v in angles.items() if v == v}
        self.waiting = False
        self._stands = self.axis if self.swivelled else UP if all(v == 0.0 for v in self._turned.values()) else None
        if self.swivelled:
            self._turn_in_plane(before, angles, known, alone=alone)
        elif self.rotary.used:
            if len(known) < len(angles):
                raise ValueError("a rotary axis goes where only the control knows, and no tilted plane is on")
            self.rotary.go(known, False, self.tip)
            self.standing, self.vectors = "", False
        elif all(v == 0.0 for v in self._turned.values()):
            self.axis, self.standing, self.vectors = UP, "", False
        elif self.tip or not alone:
            self.rotary.check(angles)
        else:
            words = " ".join(f"{c}{v:g}" if v == v else c for c, v in self._turned.items())
            self.standing = f"the rotary axes stand at {words}"

    def _turn_in_plane(
        self, before: Mapping[str, float], angles: Mapping[str, float], known: Mapping[str, float], *, alone: bool
    ) -> None:
        """The axes go to where the plane is: a move with the tool on the work would not stay in it."""
        if not alone and any(before.get(c) != v for c, v in angles.items()):
            raise ValueError("rotary words beside a move in a tilted plane", "Turn the axes in a block of its own.")
        if self.rotary.used:
            self.rotary.go(known, False, True)
            if unknown := angles.keys() - known.keys():
                self.rotary.lose(unknown)
            self._unchecked = True

    def _check_angles(self) -> None:
        """Rotary positions that the file names must stand in the tilted plane."""
        self._unchecked = False
        machine, angles = self.rotary.machine, np.array([self.rotary.angles])
        if not self.swivelled or machine is None or not np.isfinite(angles).all():
            return
        _, axis = machine.poses(np.zeros((1, 3)), angles, np.array([True]))
        off = math.acos(max(-1.0, min(1.0, float(axis[0] @ np.array(self.axis)))))
        if off > SAME_DIRECTION:
            places = [", ".join(f"{v:.4f}" for v in vector) for vector in (axis[0], self.axis)]
            problem = f"on the machine of the cell the tool points along {places[0]}, in the plane along {places[1]}"
            raise ValueError(problem, "Check [machine] of the cell, or the angles.")
