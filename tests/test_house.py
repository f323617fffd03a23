"""The rules of the house that a machine can see; docs/architecture.md explains them."""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

from stiffness.effects import BUILT_IN

ROOT = Path(__file__).parents[1]
PACKAGES = ("compensator", "stiffness", "toolpaths")
MAY_IMPORT = {"compensator": {"stiffness", "toolpaths"}, "stiffness": set(), "toolpaths": set()}
FILES = sorted(p for package in PACKAGES for p in (ROOT / package).rglob("*.py"))
MOST_LINES = 300
MOST_POSITIONAL = 4


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def module(path: Path) -> str:
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


MODULES = {module(p): p for p in FILES}


def at(path: Path, node: ast.AST) -> str:
    return f"{path.relative_to(ROOT)}:{getattr(node, 'lineno', 0)}"


def imported(root: ast.AST, package: str) -> Iterator[tuple[str, int]]:
    """Dotted names that a module imports, relative and dynamic imports included, with their line."""
    for node in ast.walk(root):
        if isinstance(node, ast.Import):
            yield from ((alias.name, node.lineno) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            source = package if node.level else (node.module or "")
            yield from ((f"{source}.{alias.name}", node.lineno) for alias in node.names)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            # importlib.import_module("package.module"), also from a table or an f-string
            found = re.match(rf"(?:{'|'.join(PACKAGES)})\.[\w.]*$", node.value)
            if found and node.value != "compensator.effects":  # the name of an entry point, no import
                yield node.value, node.lineno


def forbidden_arrows(path: Path, package: str, root: ast.AST) -> list[str]:
    others = set(PACKAGES) - {package} - MAY_IMPORT[package]
    return [
        f"{path}:{line}: {package} imports {name}"
        for name, line in imported(root, package)
        if name.split(".")[0] in others
    ]


def test_no_forbidden_import_arrow_between_packages() -> None:
    assert [f for p in FILES for f in forbidden_arrows(p, p.relative_to(ROOT).parts[0], tree(p))] == []


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
    assert len(forbidden_arrows(Path("x.py"), package, ast.parse(text))) == 1


@cache
def arrows() -> dict[str, set[str]]:
    """Module -> modules of the project that it imports, also for types only."""
    out: dict[str, set[str]] = {name: set() for name in MODULES}
    for name, path in MODULES.items():
        for node in ast.walk(tree(path)):
            if isinstance(node, ast.Import):
                targets = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                targets = [f"{node.module}.{a.name}" if f"{node.module}.{a.name}" in MODULES else node.module or ""
                           for a in node.names]  # fmt: skip
            else:
                continue
            out[name] |= {t for t in targets if t in MODULES} - {name}
    return out


def circle(graph: dict[str, set[str]]) -> list[str]:
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as e:
        return list(e.args[1])
    return []


def test_no_circles_of_files() -> None:
    assert circle(arrows()) == []


def folder(name: str) -> str:
    """The folder of a module: two levels, but three below languages, report."""
    parts = name.split(".")
    depth = 3 if parts[:2] in (["toolpaths", "languages"], ["compensator", "report"]) else 2
    return ".".join(parts[:depth]) if len(parts) > depth else name


def test_arrows_between_folders_go_one_way() -> None:
    graph: dict[str, set[str]] = defaultdict(set)
    for name, targets in arrows().items():
        graph[folder(name)] |= {folder(t) for t in targets} - {folder(name)}
    assert circle(graph) == []


def test_no_language_imports_another_or_the_table() -> None:
    languages = "toolpaths.languages."
    wrong = [
        f"{name} -> {target}"
        for name, targets in arrows().items()
        for target in targets
        if name.startswith(languages) and name.count(".") > 2 and target.startswith(languages)
        and target.split(".")[2] != name.split(".")[2]
    ]  # fmt: skip
    assert wrong == []


def test_packages_raise_and_do_not_assert() -> None:
    assert [at(p, n) for p in FILES for n in ast.walk(tree(p)) if isinstance(n, ast.Assert)] == []


def test_no_module_without_a_noun() -> None:
    assert [p for p in FILES if p.stem in {"utils", "util", "common", "helpers", "helper", "misc"}] == []


def test_files_stay_short() -> None:
    lengths = {str(p.relative_to(ROOT)): len(p.read_text(encoding="utf-8").splitlines()) for p in FILES}
    assert {name: n for name, n in lengths.items() if n > MOST_LINES} == {}
    some = sorted(n for n in lengths.values() if n)
    assert some[len(some) // 2] <= 120


def test_public_classes_have_one_meaning() -> None:
    where: dict[str, list[str]] = defaultdict(list)
    for p in FILES:
        for node in tree(p).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                where[node.name].append(at(p, node))
    assert {name: places for name, places in where.items() if len(places) > 1} == {}


def docstrings(root: ast.Module) -> set[int]:
    """ids of the constants that are docstrings."""
    holders = [n for n in ast.walk(root) if isinstance(n, ast.Module | ast.ClassDef | ast.FunctionDef)]
    return {id(h.body[0].value) for h in holders if h.body and isinstance(h.body[0], ast.Expr)}


def test_no_effect_is_named_outside_the_catalogue() -> None:
    names, wrong = {e.name for e in BUILT_IN} - {"payload"}, []  # also a column of samples.csv
    for p in FILES:
        if p.relative_to(ROOT).parts[:2] == ("stiffness", "effects"):
            continue
        skip = docstrings(tree(p))
        wrong += [
            f"{at(p, n)} {n.value!r}"
            for n in ast.walk(tree(p))
            if isinstance(n, ast.Constant) and n.value in names and id(n) not in skip
        ]
    assert wrong == []


def foreign_assignments(root: ast.AST) -> Iterator[ast.AST]:
    """Assignments to an attribute of another object than self (or the class)."""
    for node in ast.walk(root):
        targets = (
            node.targets if isinstance(node, ast.Assign)
            else [node.target] if isinstance(node, ast.AugAssign | ast.AnnAssign) else []
        )  # fmt: skip
        for t in targets:
            for part in ast.walk(t):
                stored = isinstance(part, ast.Attribute) and isinstance(part.ctx, ast.Store)
                if stored and ast.unparse(part.value) not in {"self", "cls"}:
                    yield part


def test_no_attribute_of_another_object_is_assigned_to() -> None:
    # gravity of a copied Pinocchio model, numba's folder while a function is decorated, the margin of a request of
    # coal: no other way to give it
    own_copy = {
        "stiffness/robot/robot.py",
        "compensator/process/milling/kernels/compiled.py",
        "compensator/scene/coal_shape.py",
    }
    found = [at(p, n) for p in FILES for n in foreign_assignments(tree(p)) if str(p.relative_to(ROOT)) not in own_copy]
    assert found == []


def test_a_foreign_assignment_is_seen() -> None:
    assert len(list(foreign_assignments(ast.parse("a.b = 1\nself.x = 2\nc.d += 1\ne.f[0] = 1")))) == 2


def test_many_arguments_are_given_by_keyword() -> None:
    wrong = [
        f"{at(p, n)} {ast.unparse(n.func)}"
        for p in FILES
        for n in ast.walk(tree(p))
        if isinstance(n, ast.Call) and len(n.args) > MOST_POSITIONAL
        and not any(isinstance(a, ast.Starred) for a in n.args)
        and ast.unparse(n.func).split(".")[-1] not in VARIADIC
    ]  # fmt: skip
    assert wrong == []


#: Functions of any number of like things, of libraries without keywords, and of numba's and CasADi's kind.
VARIADIC = {"vertcat", "horzcat", "max", "min", "print", "zip", "chain", "group", "Function", "computeFrameJacobian",
            "run", "_clamp", "writes", "hover"}  # fmt: skip


def test_markup_stands_in_templates() -> None:
    """No tag in a string of the code: pages come from templates, which escape."""
    tag = re.compile(r"</?(?:p|div|span|table|tr|td|th|ul|li|h[1-6]|section|figure|script|style|i|em|strong|a)\b[^>]*>")
    wrong = []
    for p in FILES:
        skip = docstrings(tree(p))
        wrong += [
            f"{at(p, n)} {n.value!r}"
            for n in ast.walk(tree(p))
            if isinstance(n, ast.Constant) and isinstance(n.value, str) and id(n) not in skip and tag.search(n.value)
        ]
    assert wrong == []


WORDS = (
    "knowing nothing leaves",
    "knows nothing",
    "an addition that explains less beside others is none",
    "moves in six ways",
    "a robot which lacks nothing",
    "taken back by position",
)


def test_prose_uses_the_terms_of_the_field() -> None:
    assert [f"{p}: {w}" for p in FILES for w in WORDS if w in re.sub(r"\s+", " ", p.read_text(encoding="utf-8"))] == []


STATISTICAL = sorted(p for room in ("diagnosis", "identification") for p in (ROOT / "stiffness" / room).glob("*.py"))
PHYSICAL = re.compile(r"#\s*(?:m|rad|s|K|N|N\*m|N\*m/rad)(?:[,;:. ]|$)")  # a unit comes first: no matter of statistics


def without_study(path: Path, text: str) -> list[str]:
    """Thresholds of a module whose block of constants names no file of tests or benchmarks that exists."""
    lines, out = text.splitlines(), []
    for node in ast.parse(text).body:
        name = node.targets[0] if isinstance(node, ast.Assign) else None
        if not isinstance(node, ast.Assign) or not isinstance(name, ast.Name) or not name.id.isupper():
            continue
        values = [v for v in ast.walk(node.value) if isinstance(v, ast.Constant) and isinstance(v.value, float)]
        if not values or PHYSICAL.search(lines[node.lineno - 1]):
            continue
        top = node.lineno - 1
        while top and re.match(r"#|[A-Z]", lines[top - 1]):
            top -= 1
        named = re.findall(r"(?:tests|benchmarks)/[\w./]*\w", "\n".join(lines[top : node.lineno]))
        if not named or not all((ROOT / study).exists() for study in named):
            out.append(f"{path.name}:{node.lineno}: {name.id}")
    return out


def test_statistical_constants_name_the_study_that_they_come_from() -> None:
    assert [found for p in STATISTICAL for found in without_study(p, p.read_text(encoding="utf-8"))] == []


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("CHANCE = 0.01  # of a false alarm", 1),
        ("# studied in tests/no_such_study.py\nCHANCE = 0.01", 1),
        ("# studied in tests/test_house.py\nMOST = 3\nCHANCE = 0.01", 0),
        ("OFFSET = 0.02  # m; no better known", 0),
        ("MOST = 3", 0),
    ],
)
def test_a_constant_without_a_study_is_seen(text: str, found: int) -> None:
    assert len(without_study(Path("x.py"), text)) == found
