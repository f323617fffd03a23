"""Shape: the kinds of cutter that are known. It stands alone: a cell file is read without the machinery of a cut."""

from __future__ import annotations

from typing import Literal

Shape = Literal["flat", "bull", "ball", "taper", "drill"]
