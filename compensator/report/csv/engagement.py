"""What the process does at every pose, as CSV: engagement and wrench of milling."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from compensator.process.milling.milling_load import CutColumns
from compensator.process.process import ProcessLoad
from compensator.solve.compensation import Compensation

WRENCH = ("fx_n", "fy_n", "fz_n", "mx_nm", "my_nm", "mz_nm")
LAST = "peak_n"  # stands behind the wrench
BLOCK = 10_000  # rows that are made at a time


def engagement_csv(c: Compensation, poses: npt.NDArray[np.intp]) -> Iterator[str]:
    """The text, block by block: a row per pose, empty where a column has no value; wrench on the robot, base axes.

    Args:
        poses: (M,) those that are written, in their order; ``index`` counts them.
    """
    load = c.load
    columns, tail = [name for name in load.columns if name != LAST], [name for name in load.columns if name == LAST]
    yield ",".join(["index", "source_line", *columns, *WRENCH, *tail]) + "\n"
    for begin in range(0, len(poses), BLOCK):
        some = poses[begin : begin + BLOCK]
        made = [*(_at(load, k, some) for k in columns), load.wrench[some], *(_at(load, k, some) for k in tail)]
        numbers = np.column_stack(made) + 0.0
        rows = zip(c.path.toolpath.line[some].tolist(), numbers.tolist(), strict=True)
        yield "".join(
            f"{begin + k},{at}," + ",".join(f"{v:.6f}" if v == v else "" for v in row) + "\n"
            for k, (at, row) in enumerate(rows)
        )


def _at(load: ProcessLoad, name: str, rows: npt.NDArray[np.intp]) -> npt.NDArray[np.float64]:
    """(K,) of a column of the load, at poses: those of a cut are made, and of all poses they would take much room."""
    return load.columns.at(name, rows) if isinstance(load.columns, CutColumns) else load.columns[name][rows]
