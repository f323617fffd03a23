"""Spelling: how a language whose moves give or name targets spells a pose, and a line that is put in."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Protocol

import numpy as np
import numpy.typing as npt

from toolpaths.interpreting.program_text import Declaration, LinkedText
from toolpaths.rewriting.edits import Edit
from toolpaths.writing.program import Floats


class Spelling(Protocol):
    """How a language spells poses and moves."""

    #: A pose made of numbers; groups 1 to 3 are X, Y, Z.
    literal: re.Pattern[str]
    #: A line end of the file.
    newline: str

    @property
    def program(self) -> LinkedText:
        """The text that its places count in."""

    def aggregate(self, move: int) -> str:
        """The target of a move that is computed, as a literal."""

    def turns(self, rotation: Floats) -> Floats:
        """Rotations (K, 3, 3) as the numbers (K, m) that ``spelled`` takes."""

    def spelled(self, literal: re.Match[str], position: Sequence[float], turn: Sequence[float] | None) -> str:
        """A literal with other numbers: (3,) mm and (m,); without ``turn`` those of the orientation stay."""

    def standing(self, literal: str, external: Mapping[str, float]) -> str:
        """A literal with other values of external axes."""

    def branches_differ(self, nominal: Floats, commanded: Floats) -> npt.NDArray[np.bool_]:
        """(K,) whether a target of the language tells joint angles (K, 6) rad apart."""

    def configured(self, literal: str, nominal: Floats, commanded: Floats) -> str:
        """A literal for joint angles ``commanded`` (6,), from one that holds for ``nominal``."""

    def inserted(self, move: int, target: str) -> str:
        """A straight move to ``target`` as it is put in before the move's statement."""

    def straight(self, move: int) -> Iterator[Edit]:
        """What makes the move a straight one to a target of its own: its word; of an arc the via point goes."""

    def declared(self) -> Sequence[Declaration]:
        """Declared targets by ``start``."""

    def scope(self, target: Declaration) -> tuple[int, int]:
        """Where in the text a declared target may be used."""

    def free_name(self, name: str, taken: set[str]) -> str:
        """A legal name near ``name`` whose upper case is not in ``taken``."""
