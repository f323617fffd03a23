"""The notebooks run from end to end as they stand, and are committed without outputs."""

from __future__ import annotations

import shutil
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

EXAMPLES = Path(__file__).parents[1] / "examples"
NOTEBOOKS = sorted((EXAMPLES / "notebooks").glob("*.ipynb"))
SAID = {
    "identify-and-diagnose": ("backlash", "joint-3", "mm before, 0.02"),
    "mesh-to-program": ("error of the file: 0.00", "WrittenFiles(finish.mod)", "MODULE finish", "um, largest"),
}


@pytest.mark.filterwarnings("ignore")  # of the libraries that run a kernel; it has those of the project in its outputs
@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda p: p.stem)
def test_it_runs(notebook: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In a folder of its own, beside the session of the examples; what it shows is what its words say."""
    monkeypatch.setenv("PYTHONPATH", str(EXAMPLES.parent))
    monkeypatch.setenv("PYTHONWARNINGS", "ignore")
    shutil.copytree(EXAMPLES / "session", tmp_path / "session")
    read = nbformat.read(notebook, as_version=4)
    NotebookClient(read, timeout=300, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = [o for cell in read.cells if cell.cell_type == "code" for o in cell.outputs]
    shown = "".join(o.get("text", "") + str(o.get("data", "")) for o in outputs)
    assert [words for words in SAID[notebook.stem] if words not in shown] == []
    assert any("text/html" in o.get("data", {}) for o in outputs)


def test_they_are_committed_empty() -> None:
    assert {p.stem for p in NOTEBOOKS} == set(SAID)
    for notebook in NOTEBOOKS:
        read = nbformat.read(notebook, as_version=4)
        nbformat.validate(read)
        assert all(not c.outputs and c.execution_count is None for c in read.cells if c.cell_type == "code")
