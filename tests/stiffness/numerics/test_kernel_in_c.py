"""Kernels in C: the bits of the kernel without a compiler, and nothing where there is none."""

from __future__ import annotations

import pickle
from pathlib import Path

import casadi as ca
import numpy as np
import numpy.typing as npt
import pytest

from stiffness.numerics import kernel, kernel_in_c, machine_code
from stiffness.numerics.kernel import BLOCK, Kernel
from tests.stiffness.numerics.test_kernel import OPERATIONS, same_bits

Floats = npt.NDArray[np.float64]

needs_compiler = pytest.mark.skipif(machine_code._compiler() is None, reason="no C compiler")


@pytest.fixture(autouse=True)
def _own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(kernel, "IN_C_FROM", 3 * BLOCK)
    monkeypatch.setattr(kernel, "COMPILED_FROM", 5 * BLOCK)
    for cached in (machine_code.machine_code, machine_code._folder):
        cached.cache_clear()


def two_numbers() -> ca.Function:
    """Every operation that a kernel has, of two numbers and a vector that all rows may share."""
    a, b, shared = ca.SX.sym("a"), ca.SX.sym("b"), ca.SX.sym("shared", 2)
    values = ca.vertcat(*(ca.densify(operation(a, b)) for operation in OPERATIONS.values()))
    given = [ca.vertcat(a, b), shared, ca.SX.sym("none", 0)]
    return ca.Function("every", given, [values, a * shared + b], ["x", "shared", "none"], ["values", "sum"])


def rows(count: int, seed: int) -> tuple[Floats, Floats, Floats]:
    rng = np.random.default_rng(seed)
    return rng.uniform(-2, 2, (count, 2)), rng.uniform(-2, 2, 2), np.empty(0)


@needs_compiler
def test_c_gives_the_same_bits() -> None:
    function, given = two_numbers(), rows(20 * BLOCK + 3, 1)
    expected = [np.concatenate(parts) for parts in zip(*(
        Kernel(function).run(given[0][a : a + BLOCK], *given[1:]) for a in range(0, len(given[0]), BLOCK)
    ), strict=True)]  # fmt: skip
    made = Kernel(function, threads=2)
    found = made.run(*given)
    assert repr(made._in_c) == "KernelInC(every)"
    for a, b in zip(found, expected, strict=True):
        assert same_bits(a, b)
    x, shared, none = given
    for strided in (np.repeat(x, 2, axis=0)[::2], np.asfortranarray(x), np.hstack([x, x])[:, :2]):
        assert same_bits(made.run(strided, shared, none)[0], expected[0])
    again = pickle.loads(pickle.dumps(made))
    assert again._in_c is None and same_bits(again.run(*given)[1], expected[1])
    assert repr(again._in_c) == "KernelInC(every)"


@needs_compiler
def test_a_kernel_that_runs_little_waits_for_no_compiler(tmp_path: Path) -> None:
    function, (x, *others) = two_numbers(), rows(4 * BLOCK, 4)
    little = Kernel(function)
    little.run(x, *others)
    assert little._in_c is None
    assert not list(tmp_path.glob("toolpath-compensator/c/*.so"))
    little.run(x, *others)  # much, by now
    assert repr(little._in_c) == "KernelInC(every)"
    machine_code.machine_code.cache_clear()
    later = Kernel(function)
    later.run(x[: 2 * BLOCK], *others)
    assert later._in_c is None
    later.run(x, *others)
    assert repr(later._in_c) == "KernelInC(every)"


@needs_compiler
def test_what_a_compiler_made_is_kept(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    assert kernel_in_c.kernel_in_c(two_numbers()) is not None
    (file,) = tmp_path.glob("toolpath-compensator/c/*.so")
    made = file.stat().st_mtime_ns
    machine_code.machine_code.cache_clear()
    monkeypatch.setattr(machine_code, "_compile", None)
    assert kernel_in_c.kernel_in_c(two_numbers()) is not None
    assert [f.stat().st_mtime_ns for f in file.parent.iterdir()] == [made]


@pytest.mark.parametrize("why", ["no compiler", "a compiler that fails", "no folder", "a large function", "other bits"])
def test_without_it_the_numbers_are_the_same(monkeypatch: pytest.MonkeyPatch, why: str, tmp_path: Path) -> None:
    function, given = two_numbers(), rows(6 * BLOCK, 2)
    monkeypatch.setattr(kernel, "IN_C_FROM", 10**9)
    expected = Kernel(function).run(*given)
    monkeypatch.setattr(kernel, "IN_C_FROM", 0)
    if why == "no compiler":
        monkeypatch.setattr(machine_code, "_compiler", lambda: None)
    elif why == "a compiler that fails":
        monkeypatch.setattr(machine_code, "_compiler", lambda: "/bin/false")
    elif why == "no folder":
        (tmp_path / "toolpath-compensator").write_text("a file")
    elif why == "a large function":
        monkeypatch.setattr(kernel_in_c, "LARGEST", 10)
    else:
        other = ca.Function("every", function.sx_in(), [v + 1e-15 for v in function(*function.sx_in())])
        monkeypatch.setattr(kernel, "kernel_in_c", lambda _, compiles: kernel_in_c.kernel_in_c(other))
    made = Kernel(function)
    for a, b in zip(made.run(*given), expected, strict=True):
        assert same_bits(a, b)
    assert made._in_c is None
