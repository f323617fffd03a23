"""Findings of a cut: what is hit, and what cannot be cut as programmed, pose by pose."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.process.milling.kernels.hits import ABOVE_EDGE, HOLDER_HIT, RAPID_HIT, SHANK_HIT, SIDEWAYS
from compensator.process.milling.mill import Cut
from toolpaths.finding import ERROR

WORDS = {
    RAPID_HIT: ("rapid", "a rapid goes through the material", "Raise it, or make it a feed"),
    ABOVE_EDGE: (
        "above-edge",
        "material stands above the cutting edge: it is not cut",
        "Cut in smaller steps, or give the cutter a longer edge (length)",
    ),
    SHANK_HIT: ("shank", "the shank is in the material", "Use a longer or more slender tool"),
    HOLDER_HIT: ("holder", "the holder is in the material", "Use a longer tool"),
    SIDEWAYS: ("sideways", "a drill moves sideways in the material", "A drill cuts along its axis: use an end mill"),
}
"""Bit -> kind, what is wrong, what to do."""


@dataclass(frozen=True)
class CutFinding:
    """One kind of hit at one pose.

    Attributes:
        level: as in toolpaths.finding; kind: one of those of WORDS.
        pose: index into the path; the move that ends there does it.
    """

    level: str
    kind: str
    pose: int
    what: str
    remedy: str


def cut_findings(cut: Cut) -> list[CutFinding]:
    """Everything that was hit, in the order of the path; repeats are the caller's to merge."""
    out = []
    for bit, (kind, what, remedy) in WORDS.items():
        poses: npt.NDArray[np.intp] = np.flatnonzero(cut.hits & bit)
        out += [CutFinding(ERROR, kind, int(pose), what=what, remedy=remedy) for pose in poses]
    return sorted(out, key=lambda f: f.pose)
