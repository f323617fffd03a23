"""Files that show a result elsewhere: the scene for other viewers, one page for a customer."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from compensator.solve.compensation import Compensation
from compensator.tasks.outputs import Outputs
from compensator.tasks.say import Say

Floats = npt.NDArray[np.float64]


def write_pictures(
    outputs: Outputs,
    c: Compensation,
    numbers: dict[str, Any],
    after: Floats | None,
    *,
    glb: Path | None,
    pdf: Path | None,
    say: Say,
) -> None:
    """Stage those that are asked for.

    Args:
        numbers: the JSON report. after: (N,) m left with the written program, None: nothing is corrected.
    """
    if glb:
        from compensator.report.scene.glb import glb_scene

        say("writing the scene")
        _stage(outputs, glb, ".glb", glb_scene(c))
    if pdf:
        from compensator.report.pdf.sheet import sheet

        say("drawing the page")
        _stage(outputs, pdf, ".pdf", sheet(c, numbers, after))


def _stage(outputs: Outputs, target: Path, suffix: str, content: bytes) -> None:
    with outputs.writing(target, suffix) as staged:
        staged.write_bytes(content)
    outputs.add(staged, target)
