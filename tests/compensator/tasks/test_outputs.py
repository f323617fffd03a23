"""Outputs appear together or not at all: full disks, folders in the way, devices, and what stood there before."""

from __future__ import annotations

import os
import re
import resource
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from compensator.errors import CompensatorError
from compensator.tasks.compensate import compensate_file, preview_file
from compensator.tasks.outputs import Outputs
from tests.compensator.small_job import Files, files
from toolpaths.errors import ToolpathError

REFUSALS = (CompensatorError, ToolpathError)


@pytest.fixture
def job(tmp_path: Path) -> Files:
    """The small job."""
    return files(tmp_path)


def refused(job: Files, program: Path, **others: Path) -> str:
    """The message of compensate."""
    with pytest.raises(REFUSALS) as caught:
        compensate_file(job.toolpath, job.cell, program, **others)
    assert not list(job.folder.rglob(".compensator*"))
    return str(caught.value)


def test_no_such_folder(job: Files) -> None:
    """The folder of an output is not made."""
    for others in ({}, {"json": job.out / "a.json"}, {"report": job.out / "a.html"}):
        text = refused(job, job.folder / "none" / "out.mod", **others)
        assert re.search(r"none/out\.mod: cannot write there: there is no folder", text)
        assert job.left() == [] and not (job.folder / "none").exists()


@pytest.mark.parametrize("which", ["json", "report"])
def test_program_is_fine_but_the_other_output_is_not(job: Files, which: str) -> None:
    """Nothing at all appears, in no folder."""
    text = refused(job, job.out / "out.mod", **{which: job.folder / "none" / "a.out"})
    assert "none/a.out" in text and job.left() == []
    (job.out / "folder").mkdir()
    text = refused(job, job.out / "out.mod", **{which: job.out / "folder"})
    assert re.search(r"out/folder: is a folder", text) and job.left() == ["folder"]
    with pytest.raises(CompensatorError, match="is a folder"):
        preview_file(job.toolpath, job.cell, csv=job.out / "p.csv", **{which: job.out / "folder"})
    assert job.left() == ["folder"]


def test_a_folder_in_the_place_of_the_program(job: Files) -> None:
    """For every language."""
    for name in ("out.mod", "out.src", "out.csv"):
        (job.out / name).mkdir()
        assert f"{name}: is a folder" in refused(job, job.out / name, json=job.out / "a.json")
        assert job.left() == [name]
        (job.out / name).rmdir()


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="needs /proc: a folder that not even root can write to")
def test_a_folder_that_nobody_can_write_to(job: Files) -> None:
    """The program would go to the out folder, the summary cannot."""
    assert "/proc/a.json: cannot write there" in refused(job, job.out / "out.mod", json=Path("/proc/a.json"))
    assert "/proc/out.mod: cannot write there" in refused(job, Path("/proc/out.mod"), json=job.out / "a.json")
    assert job.left() == []


@pytest.mark.skipif(os.geteuid() == 0, reason="root writes to read-only folders")
def test_a_read_only_folder(job: Files) -> None:
    """By permission."""
    job.out.chmod(0o555)
    try:
        assert re.search(r"out\.mod: cannot write there: Permission denied", refused(job, job.out / "out.mod"))
        assert job.left() == []
    finally:
        job.out.chmod(0o755)


def test_devices_and_pipes(job: Files) -> None:
    """An output is renamed into place: that would put a file where the device was."""
    pipe = job.out / "pipe.csv"
    os.mkfifo(pipe)
    assert re.search(r"pipe\.csv: is a device or a pipe", refused(job, pipe))
    assert pipe.is_fifo() and job.left() == ["pipe.csv"]


def test_through_a_symbolic_link(job: Files) -> None:
    """The link stays, the file it leads to is replaced."""
    real = job.folder / "real.csv"
    real.write_text("old")
    link = job.out / "link.csv"
    link.symlink_to(real)
    compensate_file(job.toolpath, job.cell, link)
    assert link.is_symlink() and real.read_text().startswith("index,kind,")


@pytest.mark.parametrize("outs", [{"program": "path.csv"}, {"json": "cell.toml"}, {"json": "out/out.mod"},
                                  {"report": "out/../out/out.mod"}])  # fmt: skip
def test_an_output_over_an_input_or_over_another(job: Files, outs: dict[str, str]) -> None:
    """Refused before anything is computed."""
    before = {p.name: p.read_bytes() for p in job.folder.iterdir() if p.is_file()}
    given = {"program": job.out / "out.mod", **{k: job.folder / v for k, v in outs.items()}}
    with pytest.raises(CompensatorError, match=r"is an input of this run|is asked for twice"):
        compensate_file(job.toolpath, job.cell, **given)
    assert {p.name: p.read_bytes() for p in job.folder.iterdir() if p.is_file()} == before and job.left() == []


def old(job: Files, *names: str) -> dict[str, str]:
    """Outputs that stand there from before."""
    for name in names:
        (job.out / name).write_text(f"old {name}")
    return {name: f"old {name}" for name in names}


def now(job: Files) -> dict[str, str]:
    """What stands there."""
    return {p.name: p.read_text() for p in job.out.iterdir()}


def test_failures_leave_old_outputs_alone(job: Files, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whichever of the renames fails, everything is put back."""
    real, calls = os.replace, 0
    reached = set()
    for fail_at in range(1, 8):
        before = old(job, "out.mod", "out.json") if fail_at % 2 else old(job, "out.json", "out.html")
        calls = 0

        def replace(a: Path, b: Path, fail_at: int = fail_at) -> None:
            nonlocal calls
            # writers rename inside their own staging folder: not what is tested here
            calls += Path(b).parent == job.out or Path(a).parent == job.out
            if calls == fail_at and (Path(b).parent == job.out or Path(a).parent == job.out):
                raise OSError(28, "No space left on device")
            real(a, b)

        monkeypatch.setattr(os, "replace", replace)
        try:
            text = refused(job, job.out / "out.mod", json=job.out / "out.json", report=job.out / "out.html")
        except pytest.fail.Exception:
            break
        finally:
            monkeypatch.undo()
        assert re.search(r"out\.(mod|json|html): cannot be put in place: No space left", text)
        assert now(job) == before, fail_at
        reached.add(fail_at)
        for left in job.out.iterdir():
            left.unlink()
    assert len(reached) >= 3


def test_an_interrupted_commit_puts_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C between two renames is no reason to lose what stood there."""
    first, second = tmp_path / "a.txt", tmp_path / "b.txt"
    first.write_text("old a")
    second.write_text("old b")
    real, interrupts = os.replace, iter([KeyboardInterrupt()])

    def replace(a: Path, b: Path) -> None:
        if Path(b) == second:
            for interrupt in interrupts:
                raise interrupt
        real(a, b)

    with pytest.raises(KeyboardInterrupt), Outputs() as outs:
        outs.text(first, "new a")
        outs.text(second, "new b")
        monkeypatch.setattr(os, "replace", replace)
        try:
            outs.commit()
        finally:
            monkeypatch.undo()
    assert first.read_text() == "old a" and second.read_text() == "old b"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.txt", "b.txt"]


def limited(job: Files, most: int, *arguments: str) -> subprocess.CompletedProcess[str]:
    """The command line where no file may grow beyond `most` bytes: a full disk, as the kernel says it."""

    def limit() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))

    root = Path(__file__).resolve().parents[3]
    command = [sys.executable, "-B", "-m", "compensator.cli", *arguments]
    return subprocess.run(command, cwd=root, preexec_fn=limit, capture_output=True, text=True, timeout=120, check=False)


def test_a_full_disk(job: Files) -> None:
    """The program does not fit: one message, the name as the user gave it, old outputs as they were."""
    before = old(job, "out.csv", "out.json")
    asked = ["compensate", str(job.toolpath), "--cell", str(job.cell), "-o", str(job.out / "out.csv")]
    run = limited(job, 1000, *asked, "--json", str(job.out / "out.json"))
    assert run.returncode == 1 and now(job) == before, run.stderr
    assert f"{job.out / 'out.csv'}: cannot be written: File too large" in run.stderr
    assert len(run.stderr.splitlines()) == 1
    run = limited(job, 10_000_000, *asked, "--json", str(job.out / "out.json"))
    assert run.returncode == 0, run.stderr
    text = (job.out / "out.csv").read_text()
    assert text.startswith("index,") and text.endswith("\n") and now(job)["out.json"].startswith("{")


def test_a_disk_that_is_full_after_the_program(job: Files) -> None:
    """The program fits, the report (some megabytes) does not."""
    before = old(job, "out.csv")
    run = limited(
        job, 60_000, "compensate", str(job.toolpath), "--cell", str(job.cell), "-o", str(job.out / "out.csv"),
        "--report", str(job.out / "out.html"),
    )  # fmt: skip
    assert run.returncode == 1 and now(job) == before
    assert f"{job.out / 'out.html'}: cannot be written: File too large" in run.stderr


def test_a_writer_that_refuses_names_the_file_asked_for(job: Files) -> None:
    """Not the hidden one beside it."""
    bad = job.out / ("x" * 60 + ".src")
    try:
        text = refused(job, bad)
    except pytest.fail.Exception:
        bad.unlink()
        text = refused(job, job.out / "no suffix")
    assert str(job.out) in text and ".compensator-" not in text
    assert job.left() == []
