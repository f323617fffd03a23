"""Fanuc TP that drives to postures and pauses at them."""

from __future__ import annotations

import numpy as np

from toolpaths.languages.fanuc.config import controller_joints
from toolpaths.languages.fanuc.writer import HEAD, JOINT_POSITION, NAME_LIMIT, remarks
from toolpaths.writing.names import legal_name
from toolpaths.writing.numbers import printed
from toolpaths.writing.stops import Stops


def stops_text(stops: Stops, name: str) -> str:
    """The program."""
    lines = [line for text in stops.head for line in remarks(text)]
    for k, words in enumerate(stops.words, 1):
        lines.append(f"J P[{k}] {stops.speed}% FINE")
        lines += [*remarks(words), "  PAUSE"] if words else []
    numbered = "".join(f"{i:4d}:{line} ;\n" for i, line in enumerate(lines, 1))
    angles = printed(np.degrees(controller_joints(stops.joints)), 6).tolist()
    positions = "".join(JOINT_POSITION % (k, *row) for k, row in enumerate(angles, 1))
    head = HEAD.format(name=legal_name(name, NAME_LIMIT, ()).upper(), comment="measure", lines=len(lines))
    return f"{head}{numbered}/POS\n{positions}/END\n".replace("\n", "\r\n")
