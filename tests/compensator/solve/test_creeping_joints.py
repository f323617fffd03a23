"""A joint that moves by less than it is corrected: the message tells so, and does not blame the model."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from compensator.errors import SolveError
from compensator.solve.agreement import _refuse_unsettled
from tests.compensator.small_job import files
from toolpaths.files import read_toolpath


@pytest.mark.parametrize(("count", "said"), [(20, "at 20 of them joint 5 moves by less"), (5, "Check gap, breakaway")])
def test_what_is_said(tmp_path: Path, count: int, said: str) -> None:
    rows = [[k, 0, 0, 0, 0, 1, 1200, "cut"] for k in range(40)]
    path = read_toolpath(files(tmp_path, rows=rows).toolpath)
    unsettled = np.arange(len(path)) < 24
    creeping = np.array([0, 1, 0, 0, count, 0], dtype=np.intp)
    with pytest.raises(SolveError, match=r"path\.csv:2 .*do not agree at 24 poses") as error:
        _refuse_unsettled(path, unsettled, creeping)
    assert said in str(error.value) and ("Check gap" in str(error.value)) == (count < 12)
