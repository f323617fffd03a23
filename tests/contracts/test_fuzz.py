"""A short run of the coverage-guided fuzzer on every reader, whether it sees faults, and what longer runs found."""

from __future__ import annotations

import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.contracts.samples import READ, to_read
from tests.oracles.patience import OWN_PEAK, not_hanging
from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath

ROOT = Path(__file__).parents[2]
atheris = pytest.mark.skipif(
    importlib.util.find_spec("atheris") is None, reason="atheris is missing: it has wheels for Linux on x86_64 only"
)
RUNS = int(os.environ.get("FUZZ_RUNS", "800"))


def run(folder: Path, *command: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [*OWN_PEAK, sys.executable, *command], cwd=ROOT, capture_output=True, text=True, errors="replace",
        timeout=60 + RUNS / 50, check=False, env={**os.environ, "TMPDIR": str(folder), "OPENBLAS_NUM_THREADS": "1"},
    )  # fmt: skip


@atheris
@pytest.mark.parametrize("language", READ)
def test_only_refusals_escape(tmp_path: Path, language: str) -> None:
    done = run(tmp_path, "-m", "tests.fuzz_readers", "--language", language, "--runs", str(RUNS), "--seed", "1")
    assert done.returncode == 0, done.stderr[-3000:]
    covered = re.findall(r"DONE +cov: (\d+)", done.stderr)
    assert covered and int(covered[0]) > 80, "the reader was not instrumented"


BROKEN = """
from dataclasses import replace
from tests import fuzz_readers as f

f.SLOW, f.MEMORY, kept = 0.3, 500, []

def broken(language, folder):
    sound = f.reader(language, folder)
    def read(data):
        if data.count(b"kind") > 2:
            {fault}
        return sound(data)
    return read

f.fuzz("csv", 50_000, 1, f.Path({corpus!r}), make=broken)
"""
GOOD = 'path = sound(f.seeds("csv")[0]); '
FAULTS = {
    "another error": ('raise KeyError("kind")', "KeyError: 'kind'"),
    "a position": (GOOD + "return replace(path, position=path.position * f.np.nan)", "not fit together: position"),
    "an axis": (GOOD + "return replace(path, axis=path.axis * 1.1)", "not fit together: axis"),
    "the order": (GOOD + "return path.take(range(len(path))[::-1])", "not fit together: .*row"),
    "time": ("end = f.time.process_time() + 0.5\n            while f.time.process_time() < end: pass", r"0.\d s for"),
    "memory": ('f.SLOW = 60; kept.append(b"x" * 400_000_000); f.time.sleep(3)', "out-of-memory"),
}


@atheris
@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_found(tmp_path: Path, fault: str) -> None:
    """A fault where a header word stands three times: only some steps of the search lead there."""
    code, words = FAULTS[fault]
    done = run(tmp_path, "-c", BROKEN.format(fault=code, corpus=str(tmp_path)))
    assert done.returncode != 0 and re.search(words, done.stdout + done.stderr), done.stdout + done.stderr[-3000:]
    found = [p for p in tmp_path.glob("csv-*") if p.is_file()]
    assert len(found) == 1 and found[0].read_bytes().count(b"kind") > 2


def test_a_hang_fails() -> None:
    with pytest.raises(AssertionError, match=r"it hangs: 0\.1 s"), not_hanging(0.1):
        while True:
            pass


#: Inputs that were no clear refusal once, cut down.
FOUND = {
    "a file that ends in IF": ("rapid", "MODULE M\n PROC main()\n IF  \n"),
    "a subprogram's name longer than a file's": ("krl", "DEF P()\nA" + "B" * 300 + "()\nEND\n"),
}


@pytest.mark.parametrize("name", FOUND)
def test_what_was_found_is_refused_or_read(tmp_path: Path, name: str) -> None:
    language, text = FOUND[name]
    file = to_read(tmp_path, language, text)
    try:
        read_toolpath(file, chord=1e-3)
    except ReadError as refusal:
        assert str(file) in str(refusal)
