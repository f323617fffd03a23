"""The generated reference pages are current; the example of every function runs; Parquet holds the table."""

from __future__ import annotations

import doctest
import sys
from pathlib import Path

import pytest

import compensator
from compensator.errors import CompensatorError
from docs import make_functions, make_json_keys, make_keys
from tests.compensator import small_job
from tests.compensator.api.test_python_page import PART
from tests.stiffness.bench_lab import Lab
from tests.verb_jobs import write_inputs


def test_the_page_of_functions_is_current() -> None:
    assert make_functions.PAGE.read_text(encoding="utf-8") == make_functions.page()
    assert set(make_functions.EXAMPLES) | {"__version__"} == set(compensator.__all__)


def test_the_page_of_keys_is_current() -> None:
    page = make_keys.PAGE.read_text(encoding="utf-8")
    assert page == make_keys.page()
    for key in ("process(milling).stock.box", "controller.absolute_accuracy", "reflectors.NAME.position"):
        assert f"| `{key}` |" in page


@pytest.mark.parametrize("verb", ["check", "clamped", "compare", "cutting", "datasheet", "preview", "verify"])
def test_the_keys_of_summaries_are_current(verb: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of verbs that take about a second."""
    write_inputs(tmp_path)
    monkeypatch.chdir(tmp_path)
    section = make_json_keys.page({verb: make_json_keys.keys_of(verb)})[len(make_json_keys.HEAD) :]
    assert section.strip() in make_json_keys.PAGE.read_text(encoding="utf-8")


def test_every_example_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In their order, on files of their names."""
    small_job.files(tmp_path)
    (tmp_path / "part.nc").write_text(PART)
    Lab().session(tmp_path, 7, setups=8)
    monkeypatch.chdir(tmp_path)
    text = make_functions.PAGE.read_text(encoding="utf-8").replace("```", "")
    test = doctest.DocTestParser().get_doctest(text, {}, "functions", str(make_functions.PAGE), 0)
    out: list[str] = []
    done = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(test, out=out.append)
    assert done.failed == 0 and done.attempted > 20, "".join(out)


def test_parquet(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same numbers as the columns; not over an input; a clear word without pyarrow."""
    from pyarrow import parquet

    job = small_job.files(tmp_path)
    shown = compensator.preview(job.toolpath, job.cell)
    file = job.out / "a.parquet"
    assert compensator.write(shown, file).files == (file,)
    read = parquet.read_table(file).to_pydict()
    assert {name: list(values) for name, values in shown.columns().items()} == read and len(read["x_mm"]) > 5
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(CompensatorError, match=r"pyarrow is not installed: pip install .*\[parquet\]"):
        compensator.write(shown, job.out / "b.parquet")
    assert job.left() == ["a.parquet"]
