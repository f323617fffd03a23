"""What a package needs to be installed elsewhere: pins, data files, one version, nothing of this machine."""

from __future__ import annotations

import re
import subprocess
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("compensator", "stiffness", "toolpaths")
FILES = sorted(p for package in PACKAGES for p in (ROOT / package).rglob("*.py"))


def tracked() -> list[Path]:
    done = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=False)
    if done.returncode != 0:
        pytest.skip("not a git checkout")
    return [ROOT / name for name in done.stdout.decode().split("\0") if name]


def test_no_host_name_and_no_path_of_one_machine_in_tracked_files() -> None:
    paths, hosts = r"(^|[^a-zA-Z.])/(work|farm|tmp)/[a-z]", r"pypi\.org|pythonhosted|deb\.debian|index-url"
    pattern = re.compile(f"{paths}|{hosts}", re.MULTILINE)
    found = []
    for path in tracked():
        if path.suffix in {".png"} or path == Path(__file__) or not path.exists():
            continue
        if pattern.search(path.read_text(encoding="utf-8")):
            found.append(str(path.relative_to(ROOT)))
    assert found == []


def project() -> dict[str, object]:
    table: dict[str, object] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return table


def test_every_dependency_is_pinned() -> None:
    text = (ROOT / "constraints.txt").read_text(encoding="utf-8")
    pins = {re.sub(r"[-_.]+", "-", m[1]).lower() for m in re.finditer(r"^([\w.-]+)==[\w.]+$", text, re.MULTILINE)}
    table = project()
    wanted = [*table["dependencies"], *(d for extra in table["optional-dependencies"].values() for d in extra)]  # type: ignore[misc, attr-defined]
    names = {re.sub(r"[-_.]+", "-", re.match(r"[\w.-]+", d)[0]).lower() for d in wanted}  # type: ignore[index]
    assert names - pins == set()
    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    assert all(re.fullmatch(r"[\w.-]+==[\w.]+", line) for line in lines)


def test_package_data_is_declared() -> None:
    table = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]["package-data"]
    for package in PACKAGES:
        files = [p for p in (ROOT / package).rglob("*") if p.is_file() and "__pycache__" not in p.parts]
        suffixes = {p.suffix for p in files} - {".py", ".pyc"}
        declared = {Path(pattern).suffix for pattern in table[package]}
        assert suffixes - declared - {""} == set(), package


def test_the_version_stands_once() -> None:
    assert re.fullmatch(r"\d+\.\d+\.\d+", str(project()["version"]))
    text = "".join(p.read_text(encoding="utf-8") for p in FILES)
    assert "__version__ =" not in text and str(project()["version"]) not in text


def test_papers_beside_the_code() -> None:
    """One version everywhere; the image runs what the README runs; the house is shown to who takes part."""
    version = f"version: {project()['version']}"
    assert version in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert "RUN make demo" in (ROOT / "Containerfile").read_text(encoding="utf-8")
    assert "(docs/images/architecture.png)" in (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    listed = {c for c in project()["classifiers"] if ":: 3." in c}  # type: ignore[attr-defined]
    assert listed == {f"Programming Language :: Python :: 3.{minor}" for minor in (11, 12, 13)}
