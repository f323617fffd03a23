"""How a command ends before its end: interrupted, terminated, with a full disk or a closed pipe behind it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.compensator.small_job import Files, files, nothing_but_findings

ROOT = Path(__file__).resolve().parents[1]
COMMAND = [sys.executable, "-m", "compensator.cli"]
FULL = Path("/dev/full")


@pytest.fixture
def job(tmp_path: Path) -> Files:
    """The small job."""
    return files(tmp_path)


@pytest.mark.parametrize(
    ("number", "status", "words"), [(signal.SIGINT, 130, "compensator: interrupted\n"), (signal.SIGTERM, 143, "")]
)
@pytest.mark.parametrize("place", ["reading path.csv", "solving", "writing", "verifying", "os.rename"])
def test_a_signal_while_it_works(job: Files, place: str, number: signal.Signals, status: int, words: str) -> None:
    """128 and the signal, one line, nothing left behind, and what stood there as it was."""
    (job.out / "a.csv").write_text("old")
    asked = ["compensate", str(job.toolpath), "--cell", str(job.cell), "-o", str(job.out / "a.csv"), "--verbose"]
    command = [sys.executable, "-m", "tests.signal_itself", place, str(int(number)), *asked]
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert run.returncode == status, run.stderr
    assert "".join(line for line in run.stderr.splitlines(True) if line.startswith("compensator")) == words
    assert "Traceback" not in run.stderr and job.left() == ["a.csv"] and (job.out / "a.csv").read_text() == "old"


@pytest.mark.skipif(not FULL.exists(), reason="needs /dev/full")
@pytest.mark.parametrize("arguments", ["robots", "robots ur10", "effects", "effects backlash", "--help", "--version"])
def test_a_full_disk_behind_standard_output(arguments: str) -> None:
    with FULL.open("w") as full:
        run = subprocess.run(
            [*COMMAND, *arguments.split()], cwd=ROOT, stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert (run.returncode, run.stderr) == (1, "compensator: standard output: No space left on device\n")


@pytest.mark.parametrize("arguments", ["robots", "effects", "--help"])
def test_a_reader_that_is_gone(arguments: str) -> None:
    """Silent, as every command in a pipe: 128 and SIGPIPE."""
    reading, writing = os.pipe()
    os.close(reading)
    run = subprocess.run(
        [*COMMAND, *arguments.split()], cwd=ROOT, stdout=writing, stderr=subprocess.PIPE, text=True, check=False
    )
    os.close(writing)
    assert (run.returncode, run.stderr) == (141, "")


@pytest.mark.skipif(not FULL.exists(), reason="needs /dev/full")
def test_a_program_that_standard_output_does_not_take(job: Files) -> None:
    """Then no other output appears."""
    asked = ["compensate", str(job.toolpath), "--cell", str(job.cell), "-o", "-", "--format", "csv"]
    with FULL.open("w") as full:
        run = subprocess.run(
            [*COMMAND, *asked, "--json", str(job.out / "a.json")],
            cwd=ROOT, stdout=full, stderr=subprocess.PIPE, text=True, check=False,
        )  # fmt: skip
    assert (run.returncode, run.stderr) == (1, "compensator: standard output: No space left on device\n")
    assert job.left() == []


def test_standard_output_as_output(job: Files) -> None:
    """Byte by byte what the file would hold; no file is called `-`."""
    asked = ["compensate", str(job.toolpath), "--cell", str(job.cell), "--format", "rapid", "-o"]
    run = subprocess.run([*COMMAND, *asked, "-"], cwd=job.folder, env=_path(), capture_output=True, check=False)
    assert run.returncode == 0 and nothing_but_findings(run.stderr.decode())
    subprocess.run([*COMMAND, *asked, str(job.out / "PART1.mod")], cwd=ROOT, check=True)
    assert run.stdout == (job.out / "PART1.mod").read_bytes() and not (job.folder / "-").exists()
    for more, words in ((["--json", "-"], b"asked for twice"), (["--format", "val3"], b"standard output takes one")):
        command = [*COMMAND, *asked, "-", *more]
        run = subprocess.run(command, cwd=job.folder, env=_path(), capture_output=True, check=False)
        assert run.returncode == 1 and words in run.stderr and run.stdout == b"" and not (job.folder / "-").exists()


def _path() -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(ROOT)}
