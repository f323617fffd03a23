"""Files about a cut: the engagement of every pose, and the stock that remains."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from compensator.errors import CellError
from compensator.process.milling.left_mesh import left_mesh, refuse_suffix
from compensator.process.milling.milling_load import MillingLoad
from compensator.process.process import Process
from compensator.report.csv.engagement import engagement_csv
from compensator.solve.compensation import Compensation
from compensator.tasks.outputs import Outputs


def refuse_without_cut(process: Process, source: str, engagement: Path | None, left: Path | None) -> None:
    """Refuse what only a milling process has, before anything is solved.

    Args:
        source: the cell, for messages.

    Raises:
        CellError: the process is another one.
        CompensatorError: the suffix of ``left`` is of no mesh.
    """
    if (engagement or left) and not process.cuts_stock:
        option = "--engagement" if engagement else "--left"
        raise CellError(f'{source}: {option} needs [process] kind = "milling": other kinds cut no stock')
    if left:
        refuse_suffix(left)


def write_cut(
    outputs: Outputs, c: Compensation, poses: npt.NDArray[np.intp], *, engagement: Path | None, left: Path | None
) -> None:
    """Stage the files that are asked for.

    Args:
        poses: (M,) those of ``c`` that are written elsewhere, too.
    """
    if engagement:
        with outputs.writing(engagement, ".csv") as staged, staged.open("w", encoding="utf-8", newline="") as stream:
            stream.writelines(engagement_csv(c, poses))
        outputs.add(staged, engagement)
    if left and isinstance(c.load, MillingLoad):
        with outputs.writing(left, left.suffix) as staged:
            staged.write_bytes(left_mesh(c.load, left.suffix))
        outputs.add(staged, left)
