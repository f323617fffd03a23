"""One suite over all readers: whatever a file holds, it is read or refused; nothing else escapes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.contracts.samples import READ, to_read
from toolpaths.errors import ToolpathError
from toolpaths.files import read_toolpath

quiet = settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def attempt(file: Path) -> None:
    try:
        path = read_toolpath(file)
    except ToolpathError as refusal:
        assert str(file) in str(refusal)
        return
    known = np.ones(len(path), dtype=bool)
    if path.setting is not None:
        known = ~np.isin(path.row, list(path.setting.joints))  # where joint angles lead is the robot's to tell
    assert len(path) > 0 and np.isfinite(path.position[known]).all()
    np.testing.assert_allclose(np.linalg.norm(path.axis[known], axis=1), 1, atol=1e-12)
    assert (path.feed[path.kind == 1] > 0).all() or np.isnan(path.feed).any()
    assert (np.diff(path.row) > 0).all() and all(0 <= e.pose <= len(path) for e in path.events)


@pytest.mark.parametrize("name", READ)
@quiet
@given(data=st.data())
def test_only_refusals_escape(tmp_path: Path, name: str, data: st.DataObject) -> None:
    sample = READ[name]
    attempt(to_read(tmp_path, name, data.draw(st.binary(max_size=80))))
    attempt(to_read(tmp_path, name, data.draw(st.text(max_size=80)).encode("utf-8", "replace")))
    pieces = data.draw(st.lists(st.sampled_from(sample.fragments), max_size=40))
    attempt(to_read(tmp_path, name, data.draw(st.sampled_from(["", " ", "\n"])).join(pieces)))
    lines = sample.text.split("\n")
    at = data.draw(st.integers(0, len(lines) - 1))
    lines[at] = lines[at] + data.draw(st.sampled_from(["", " ", ","])) + "".join(pieces[:3])
    attempt(to_read(tmp_path, name, "\n".join(lines)))


@pytest.mark.parametrize("name", READ)
@quiet
@given(data=st.data())
def test_only_refusals_escape_from_a_damaged_program(tmp_path: Path, name: str, data: st.DataObject) -> None:
    """Pieces of it lost, cut off, doubled, words of the language put in."""
    sample = READ[name]
    whole = sample.whole or sample.text
    text = whole
    for _ in range(data.draw(st.integers(1, 3))):
        at, length = data.draw(st.integers(0, len(text))), data.draw(st.sampled_from([0, 1, 3, 20, 100]))
        put = data.draw(st.sampled_from(["", *sample.fragments]))
        text = text[:at] + put + text[at + length :]
    attempt(to_read(tmp_path, name, text, sample.beside))
    at, to = sorted(data.draw(st.tuples(*[st.integers(0, len(whole))] * 2)))
    pieces = data.draw(st.lists(st.sampled_from(sample.fragments), max_size=12))
    put = data.draw(st.sampled_from(["", " ", "\n"])).join(pieces)
    for text in (whole[:at] + put + whole[to:], put, whole[:at]):
        attempt(to_read(tmp_path, name, text, sample.beside))
