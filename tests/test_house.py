"""The house rules that a machine can see: imports, names, sizes, pins, versions."""

from __future__ import annotations

import ast
import re
import subprocess
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("compensator", "stiffness", "toolpaths")
MAY_IMPORT = {"compensator": {"stiffness", "toolpaths"}, "stiffness": set(), "toolpaths": set()}
FILES = sorted(p for package in PACKAGES for p in (ROOT / package).rglob("*.py"))


def imported(tree: ast.AST, package: str) -> Iterator[tuple[str, int]]:
    """Top-level names that a module imports, relative and dynamic imports included, with their line."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((alias.name.split(".")[0], node.lineno) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield (package if node.level else (node.module or "").split(".")[0]), node.lineno
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            # importlib.import_module("package.module"), also from a table or an f-string
            found = re.match(rf"({'|'.join(PACKAGES)})\.[\w.]*$", node.value)
            if found and node.value != "compensator.effects":  # the name of an entry point, no import
                yield found[1], node.lineno


def forbidden_arrows(path: Path, package: str, text: str) -> list[str]:
    tree = ast.parse(text)
    others = set(PACKAGES) - {package} - MAY_IMPORT[package]
    return [f"{path}:{line}: {package} imports {name}" for name, line in imported(tree, package) if name in others]


def test_no_forbidden_import_arrow_between_packages() -> None:
    found = [f for p in FILES for f in forbidden_arrows(p, p.relative_to(ROOT).parts[0], p.read_text(encoding="utf-8"))]
    assert found == []


@pytest.mark.parametrize(
    ("package", "text"),
    [
        ("stiffness", "import toolpaths.toolpath"),
        ("stiffness", "def f():\n    from compensator import cell"),
        ("toolpaths", "from stiffness.robot import Robot as R"),
        ("toolpaths", "import importlib\nimportlib.import_module('stiffness.robot')"),
    ],
)
def test_a_forbidden_arrow_is_seen(package: str, text: str) -> None:
    assert len(forbidden_arrows(Path("x.py"), package, text)) == 1


def arrows(path: Path) -> set[str]:
    """Modules of the project that a file imports, those for types alone and those inside functions included."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return {name for name in found if name.split(".")[0] in PACKAGES}


def module(path: Path) -> str:
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


def circles(graph: dict[str, set[str]]) -> list[str]:
    """What is left of a graph when all that imports only what is below is taken away."""
    left = {name: to & graph.keys() - {name} for name, to in graph.items()}
    while done := {name for name, to in left.items() if not to & left.keys()}:
        left = {name: to for name, to in left.items() if name not in done}
    return sorted(left)


def test_no_circles_of_files() -> None:
    assert circles({module(p): arrows(p) for p in FILES}) == []
    assert circles({"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": set()}) == ["a", "b", "c"]


def test_no_language_imports_another_or_the_table() -> None:
    languages = "toolpaths.languages"
    found = []
    for path in (ROOT / "toolpaths" / "languages").glob("*/*.py"):
        own = f"{languages}.{path.parent.name}"
        found += [f"{path}: {name}" for name in arrows(path) if name.startswith(languages) and name != own
                  and not name.startswith(f"{own}.")]  # fmt: skip
    assert found == []


def test_packages_raise_and_do_not_assert() -> None:
    found = [
        f"{p}:{node.lineno}"
        for p in FILES
        for node in ast.walk(ast.parse(p.read_text(encoding="utf-8")))
        if isinstance(node, ast.Assert)
    ]
    assert found == []


def test_no_module_without_a_noun() -> None:
    assert [p for p in FILES if p.stem in {"utils", "util", "common", "helpers", "helper", "misc"}] == []


def test_files_stay_short() -> None:
    lengths = {str(p.relative_to(ROOT)): len(p.read_text(encoding="utf-8").splitlines()) for p in FILES}
    assert {name: n for name, n in lengths.items() if n > 400} == {}
    assert sorted(lengths.values())[len(lengths) // 2] < 180


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
    assert "__version__" not in text
