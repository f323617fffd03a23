"""Where the coordinates of a G-code file count from: G54 to G59.3, G52, G92.

The work object of the cell is the one coordinate system that the file uses. G52 and G92 shift coordinates inside
it. G52 and G92 as LinuxCNC and Fanuc have them: a G52 names the new origin, a G92 the present place.
"""

from __future__ import annotations

from collections.abc import Mapping

from toolpaths.frame import Vector

NOWHERE: Vector = (0.0, 0.0, 0.0)


class Origin:
    """The coordinate system in use.

    Attributes:
        shift: what is added to coordinates of the file to have them in the work object, m.
    """

    def __init__(self, systems: Mapping[str, Vector] | None = None) -> None:
        self.systems = systems or {}
        self._system: str | None = None
        self._base = self._moved = self.shift = NOWHERE
        self._kept: Vector | None = None
        self._by = ""

    def choose(self, system: str, used: bool) -> None:
        """Take over G54 ...; ``used``: coordinates were read already.

        Raises:
            ValueError: a second system, and how the two lie to each other is not known.
        """
        before = self._system or ("G54" if used else system)
        self._system = system
        if self.systems:
            if system not in self.systems:
                raise ValueError(f"{system}: the machine's offsets name only {', '.join(self.systems)}")
            self._base = self.systems[system]
            self._sum()
        elif before != system:
            raise ValueError(f"{system} after {before}: how the two lie to each other is not in the file")

    def local(self, to: Mapping[int, float]) -> None:
        """G52: the origin at these places of the work object, by axis index, m."""
        self._use("G52")
        self._moved = _put(self._moved, to)
        self._sum()

    def declare(self, at: Vector, named: Mapping[int, float]) -> Vector:
        """G92: the present place has these coordinates, by axis index, m; where it is in the work object.

        An axis whose place is not known yet is there from now on.
        """
        self._use("G92")
        known = {k: at[k] - v - self._base[k] for k, v in named.items() if at[k] == at[k]}
        self._moved = _put(self._moved, known)
        self._sum()
        return _put(at, {k: v + self.shift[k] for k, v in named.items() if k not in known})

    def drop(self, *, keep: bool) -> None:
        """G92.1 (forget) and G92.2 (set aside): no shift any more."""
        self._kept = self._moved if keep and self._kept is None else self._kept if keep else None
        self._moved, self._by = NOWHERE, self._by if keep else ""
        self._sum()

    def restore(self) -> None:
        """G92.3: the shift that G92.2 set aside."""
        if self._kept is not None:
            self._moved, self._kept = self._kept, None
            self._sum()

    def _use(self, word: str) -> None:
        if self._by not in ("", word) and self._moved != NOWHERE:
            raise ValueError(f"{word} on top of {self._by}: controllers differ in what that means")
        self._by, self._kept = word, None

    def _sum(self) -> None:
        self.shift = (
            self._base[0] + self._moved[0], self._base[1] + self._moved[1], self._base[2] + self._moved[2]
        )  # fmt: skip


def _put(vector: Vector, values: Mapping[int, float]) -> Vector:
    x, y, z = (values.get(k, v) for k, v in enumerate(vector))
    return x, y, z
