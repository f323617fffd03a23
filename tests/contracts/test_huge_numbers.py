"""Numbers of four hundred digits, in the place of every number of a program: refused, or of no account to the path."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from tests.contracts.samples import READ, to_read
from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath

HUGE = "9" * 400  # infinity, as a float


@pytest.mark.parametrize("language", READ)
def test_nothing_infinite_is_read(tmp_path: Path, language: str) -> None:
    sample, refused = READ[language], 0
    whole = sample.whole or sample.text
    for n, found in enumerate(re.finditer(r"\d+(?:\.\d+)?", whole)):
        folder = tmp_path / str(n)
        folder.mkdir()
        text = whole[: found.start()] + HUGE + whole[found.end() :]
        try:
            path = read_toolpath(to_read(folder, language, text, sample.beside))
        except ReadError:
            refused += 1
            continue
        joints = path.setting.joints if path.setting is not None else {}
        known = ~np.isin(path.row, list(joints))  # the place of the others is the robot's to say
        assert np.isfinite(path.position[known]).all(), found
        np.testing.assert_allclose(np.linalg.norm(path.axis[known], axis=1), 1, atol=1e-9, err_msg=str(found))
    assert refused > 3
