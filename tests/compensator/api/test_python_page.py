"""Every example of docs/python.md runs, in its order, and shows what the page shows."""

from __future__ import annotations

import doctest
from pathlib import Path

import pytest

from tests.compensator import small_job
from tests.stiffness.bench_lab import Lab

PAGE = Path(__file__).parents[3] / "docs" / "python.md"
PART = """%
(PART)
G21 G90 G17
S6000 M3
G0 X0 Y0 Z80
G0 Z5
G1 Z-2 F300
G1 X100 F1200
G1 Y60
G0 Z80
M30
%
"""


def test_the_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Files of its names: a part of G-code, a cell with its model, a session."""
    small_job.files(tmp_path)
    (tmp_path / "part.nc").write_text(PART)
    Lab().session(tmp_path, 7, setups=8)
    monkeypatch.chdir(tmp_path)
    text = PAGE.read_text(encoding="utf-8").replace("```", "")
    test = doctest.DocTestParser().get_doctest(text, {}, "python.md", str(PAGE), 0)
    assert len(test.examples) > 20
    out: list[str] = []
    done = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.IGNORE_EXCEPTION_DETAIL).run(
        test, out=out.append
    )
    assert done.failed == 0, "".join(out)
