"""The command line: verbs, exit codes, what is said where, and how little is imported."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from compensator.cli import main
from stiffness.robot.load import builtin_robots, load_robot
from tests.compensator.small_job import Files, files, nothing_but_findings

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture
def job(tmp_path: Path) -> Files:
    """A small job that works."""
    return files(tmp_path)


def run(*arguments: object) -> Result:
    """In this process, as a pipe sees it."""
    return CliRunner().invoke(main, [str(a) for a in arguments])


def shell(*arguments: object) -> subprocess.CompletedProcess[str]:
    """In a process of its own."""
    command = [sys.executable, "-m", "compensator.cli", *(str(a) for a in arguments)]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120, check=False)


def test_compensate_is_quiet_when_piped(job: Files) -> None:
    """0, nothing said but findings, everything asked for written; in this process and in one of its own."""
    names = ("a.mod", "a.json")
    for call in (run, shell):
        done = call(
            "compensate", job.toolpath, "--cell", job.cell, "-o", job.out / "a.mod", "--json", job.out / "a.json"
        )
        code = done.exit_code if isinstance(done, Result) else done.returncode
        assert (code, done.stdout) == (0, "") and nothing_but_findings(done.stderr), done.stderr
        assert job.left() == list(sorted(names))
        assert json.loads((job.out / "a.json").read_text())["n_cut"] > 10
        for name in names:
            (job.out / name).unlink()


def test_preview(job: Files) -> None:
    """Needs no output at all; writes what it is asked for."""
    done = run("preview", job.toolpath, "--cell", job.cell)
    assert (done.exit_code, done.stdout) == (0, "") and nothing_but_findings(done.stderr) and job.left() == []
    done = run("preview", job.toolpath, "--cell", job.cell, "--csv", job.out / "p.csv", "--json", job.out / "p.json")
    assert (done.exit_code, done.stdout) == (0, "") and job.left() == ["p.csv", "p.json"]


def test_every_output_at_once(job: Files) -> None:
    """Program, summary and report."""
    outs = ["-o", job.out / "a.src", "--json", job.out / "a.json", "--report", job.out / "a.html"]
    done = run("compensate", job.toolpath, "--cell", job.cell, *outs)
    assert (done.exit_code, done.stdout) == (0, "") and job.left() == ["a.html", "a.json", "a.src"]
    assert "<html" in (job.out / "a.html").read_text()[:300].lower()


def test_verbose_says_what_is_being_done(job: Files) -> None:
    """On stderr, never on stdout."""
    done = run("compensate", job.toolpath, "--cell", job.cell, "-o", job.out / "a.mod", "--verbose")
    assert done.exit_code == 0 and done.stdout == ""
    for word in ("reading the cell", "reading path.csv", "solving", "writing rapid", "verifying"):
        assert word in done.stderr, done.stderr
    done = run("compensate", job.toolpath, "--cell", job.folder / "no.toml", "-o", job.out / "a.csv", "--verbose")
    assert done.exit_code == 1 and "Traceback" in done.stderr and "no.toml" in done.stderr.splitlines()[-1]


@pytest.mark.parametrize("verb", ["compensate", "preview"])
def test_a_refusal_is_one_line_on_stderr(job: Files, verb: str) -> None:
    """1, no traceback, nothing on stdout, nothing left behind."""
    out = ["-o", job.out / "a.mod"] if verb == "compensate" else ["--csv", job.out / "a.csv"]
    for bad, cell in (
        (job.folder / "lost.csv", job.cell),
        (job.toolpath, job.folder / "lost.toml"),
        (job.cell, job.cell),
    ):
        done = run(verb, bad, "--cell", cell, *out)
        assert done.exit_code == 1 and done.stdout == ""
        assert done.stderr.startswith("compensator: ") and len(done.stderr.splitlines()) == 1, done.stderr
        assert "Traceback" not in done.stderr and job.left() == []
    broken = job.folder / "broken.csv"
    broken.write_text(job.toolpath.read_text().replace("100,0,-2", "nan,0,-2"))
    done = shell(verb, broken, "--cell", job.cell, *out)
    assert done.returncode == 1 and done.stdout == "" and job.left() == []
    assert "broken.csv:5: column x_mm: nan" in done.stderr


@pytest.mark.parametrize(
    "arguments",
    [
        [], ["compensate"], ["preview"], ["compensate", "a.csv"], ["compensate", "a.csv", "--cell", "c.toml"],
        ["compensate", "a.csv", "-o", "b.mod"], ["preview", "a.csv"], ["fly"], ["robots", "--all"],
        ["robots", "a", "b"],
        ["compensate", "a.csv", "--cell", "c.toml", "-o", "b.txt", "--format", "cobol"],
        ["preview", "a.csv", "--cell", "c.toml", "-o", "b.mod"],
    ],
    ids=" ".join,
)  # fmt: skip
def test_wrong_usage(arguments: list[str]) -> None:
    """2, and how it is used."""
    done = run(*arguments)
    assert done.exit_code == 2
    assert "Usage:" in done.output + done.stderr


def test_wrong_usage_of_the_shell() -> None:
    """2 there as well."""
    done = shell("compensate", "a.csv")
    assert done.returncode == 2 and "--cell" in done.stderr and done.stdout == ""


def test_format_against_suffix(job: Files) -> None:
    """--format wins over the suffix; a suffix without language needs it; languages to come are refused."""
    ask = ["compensate", job.toolpath, "--cell", job.cell, "-o"]
    assert run(*ask, job.out / "a.mod", "--format", "csv").exit_code == 0
    assert (job.out / "a.mod").read_text().startswith("index,kind,")
    assert run(*ask, job.out / "a.txt", "--format", "rapid").exit_code == 0
    assert "MODULE" in (job.out / "a.txt").read_text()
    assert run(*ask, job.out / "B.MOD").exit_code == 0
    before = job.left()
    done = run(*ask, job.out / "b.txt")
    assert done.exit_code == 1 and "'.txt'" in done.stderr and "--format" in done.stderr
    assert job.left() == before
    words = {".ls": "/PROG", ".script": "def ", ".pgx": "<?xml", ".jbi": "/JOB", ".nc": "G43.4"}
    for suffix, word in words.items():
        target = job.out / f"C{suffix}"
        done = run(*ask, target)
        assert done.exit_code == 0 and nothing_but_findings(done.stderr), (suffix, done.stderr)
        assert word in target.read_text()


def test_robots_are_listed_and_shown(job: Files) -> None:
    """Every built-in by name; one with limits, masses, sources; a file of one's own; a wrong name with remedy."""
    done = run("robots")
    assert done.exit_code == 0 and done.stderr == ""
    names = builtin_robots()
    assert len(names) >= 5 and all(name in done.stdout for name in names)
    for name in names:
        done = run("robots", name)
        robot = load_robot(name)
        assert done.exit_code == 0 and name in done.stdout
        assert "source" in done.stdout and "limits" in done.stdout
        assert all(f"{math.degrees(v):.1f}" in done.stdout for v in robot.upper)
        assert ("assumption" in done.stdout) == bool(robot.assumptions)
    own = job.folder / "own.toml"
    own.write_text((ROOT / "stiffness" / "robot" / "data" / "ur10.toml").read_text().replace('"ur10"', '"own"'))
    assert run("robots", own).exit_code == 0
    done = run("robots", "ur11")
    assert done.exit_code == 1 and "'ur11' is no robot" in done.stderr and "ur10" in done.stderr


@pytest.mark.parametrize(
    ("verb", "options"),
    [
        ("compensate", ["TOOLPATH", "--cell", "--output", "-o", "--format", "--report", "--json", "--verbose"]),
        ("preview", ["TOOLPATH", "--cell", "--csv", "--report", "--json", "--verbose"]),
        ("robots", ["NAME", "--verbose"]),
    ],
)
def test_help(verb: str, options: list[str]) -> None:
    """Every verb and every option of the interface is explained."""
    done = run(verb, "--help")
    assert done.exit_code == 0 and all(o in done.stdout for o in options), done.stdout
    whole = run("--help").stdout
    assert verb in whole


def test_version() -> None:
    """Of the installed package."""
    try:
        version = metadata.version("toolpath-compensator")
    except metadata.PackageNotFoundError:
        pytest.skip("the package is not installed, only on the path")
    done = shell("--version")
    assert done.returncode == 0 and version in done.stdout


HEAVY = ("casadi", "pinocchio", "numpy", "scipy", "plotly", "trimesh", "pydantic", "rich", "tomli_w", "coal", "jinja2")


@pytest.mark.parametrize(
    "code", ["import compensator.cli", "import compensator.cli as c; c.main(['--help'], standalone_mode=False)"]
)
def test_nothing_heavy_is_imported_to_ask_for_help(code: str) -> None:
    """--help starts as fast as Python does."""
    show = f"{code}\nimport sys\nprint('#', *sorted({{m.split('.')[0] for m in sys.modules}} & set({HEAVY!r})))"
    done = subprocess.run([sys.executable, "-c", show], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "#"


def test_a_preview_does_not_load_what_only_a_fit_needs() -> None:
    """scipy, plotly and matplotlib take longer to import than a thousand poses to predict; jinja2 is of reports."""
    slow = ("scipy", "plotly", "matplotlib", "trimesh", "jinja2")
    loaded = f"sorted(set(sys.modules) & set({slow!r}))"
    show = f"import compensator.terminal.path, compensator.tasks.compensate, sys\nprint('#', *{loaded})"
    done = subprocess.run([sys.executable, "-c", show], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "#"
