"""What the process does at every pose, as CSV: engagement and wrench of milling."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from compensator.solve.compensation import Compensation

WRENCH = ("fx_n", "fy_n", "fz_n", "mx_nm", "my_nm", "mz_nm")
LAST = "peak_n"  # stands behind the wrench
BLOCK = 10_000  # rows that are made at a time


def engagement_csv(c: Compensation, poses: npt.NDArray[np.intp]) -> Iterator[str]:
    """The text, block by block: a row per pose, empty where a column has no value; wrench on the robot, base axes.

    Args:
        poses: (M,) those that are written, in their order; ``index`` counts them.
    """
    columns = {name: values for name, values in c.load.columns.items() if name != LAST}
    tail = {name: values for name, values in c.load.columns.items() if name == LAST}
    yield ",".join(["index", "source_line", *columns, *WRENCH, *tail]) + "\n"
    made = [*columns.values(), c.wrench, *tail.values()]
    for begin in range(0, len(poses), BLOCK):
        some = poses[begin : begin + BLOCK]
        numbers = np.column_stack([values[some] for values in made]) + 0.0
        rows = zip(c.path.toolpath.line[some].tolist(), numbers.tolist(), strict=True)
        yield "".join(
            f"{begin + k},{at}," + ",".join(f"{v:.6f}" if v == v else "" for v in row) + "\n"
            for k, (at, row) in enumerate(rows)
        )
