"""Kernel: a replayed function gives the bits of the function itself, whatever the number of rows."""

from __future__ import annotations

import pickle
from collections.abc import Callable

import casadi as ca
import numpy as np
import numpy.typing as npt
import pytest

from stiffness.numerics import kernel
from stiffness.numerics.kernel import BLOCK, Kernel, replay

Floats = npt.NDArray[np.float64]

# Two scalars in (-2, 2) -> a value, one per operation of the tables.
OPERATIONS: dict[str, Callable[[ca.SX, ca.SX], ca.SX]] = {
    "neg": lambda a, b: -a,
    "exp": lambda a, b: ca.exp(a),
    "log": lambda a, b: ca.log(a),
    "sqrt": lambda a, b: ca.sqrt(a),
    "sq": lambda a, b: a * a,
    "twice": lambda a, b: 2 * a,
    "sin": lambda a, b: ca.sin(a),
    "cos": lambda a, b: ca.cos(a),
    "tan": lambda a, b: ca.tan(a),
    "asin": lambda a, b: ca.asin(a),
    "acos": lambda a, b: ca.acos(a),
    "atan": lambda a, b: ca.atan(a),
    "not": lambda a, b: ca.logic_not(a > b),
    "not of a number": lambda a, b: ca.logic_not(ca.floor(a)),
    "floor": lambda a, b: ca.floor(a),
    "ceil": lambda a, b: ca.ceil(a),
    "fabs": lambda a, b: ca.fabs(a),
    "sign": lambda a, b: ca.sign(a),
    "inv": lambda a, b: 1 / a,
    "sinh": lambda a, b: ca.sinh(a),
    "cosh": lambda a, b: ca.cosh(a),
    "tanh": lambda a, b: ca.tanh(a),
    "asinh": lambda a, b: ca.asinh(a),
    "acosh": lambda a, b: ca.acosh(a),
    "atanh": lambda a, b: ca.atanh(a),
    "erf": lambda a, b: ca.erf(a),
    "log1p": lambda a, b: ca.log1p(a),
    "expm1": lambda a, b: ca.expm1(a),
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
    "pow": lambda a, b: a**b,
    "constpow": lambda a, b: a**3.5,
    "lt": lambda a, b: a < b,
    "le": lambda a, b: a <= b,
    "eq": lambda a, b: ca.floor(a) == ca.floor(b),
    "ne": lambda a, b: ca.floor(a) != ca.floor(b),
    "and": lambda a, b: ca.logic_and(a, ca.floor(b)),
    "or": lambda a, b: ca.logic_or(ca.floor(a), ca.floor(b)),
    "fmod": lambda a, b: ca.fmod(a, b),
    "remainder": lambda a, b: ca.remainder(a, b),
    "fmin": lambda a, b: ca.fmin(a, b),
    "fmax": lambda a, b: ca.fmax(a, b),
    "atan2": lambda a, b: ca.atan2(a, b),
    "hypot": lambda a, b: ca.hypot(a, b),
    "copysign": lambda a, b: ca.copysign(a, b),
    "if else": lambda a, b: ca.if_else(a > 0, b, ca.sin(a)),
    "if else zero": lambda a, b: ca.if_else(a > 0, b, 0),
}


def one_by_one(function: ca.Function, *inputs: Floats) -> list[Floats]:
    """The function itself, row after row."""
    rows = max((len(x) for x in inputs if x.ndim == 2), default=1)
    outs = [np.empty((rows, function.numel_out(j))) for j in range(function.n_out())]
    for k in range(rows):
        result = function.call([ca.DM(x if x.ndim == 1 else x[k]) for x in inputs])
        for j, value in enumerate(result):
            outs[j][k] = np.asarray(value).ravel()
    return outs


def same_bits(a: Floats, b: Floats) -> bool:
    """Equal, with the sign of zeros; any NaN equals any other."""
    both = np.isnan(a) & np.isnan(b)
    return a.shape == b.shape and bool(np.all(both | ((a == b) & (np.signbit(a) == np.signbit(b)))))


def rough(rows: int, width: int, seed: int = 0) -> Floats:
    """Values in (-2, 2), with zeros of both signs among them."""
    x = np.random.default_rng(seed).uniform(-2, 2, (rows, width))
    x[1::7] = 0.0
    x[2::11] = -0.0
    return x


def tangled(seed: int, widths: tuple[int, ...]) -> ca.Function:
    """A random function of many operations that uses its results again, with outputs of several widths."""
    rng = np.random.default_rng(seed)
    inputs = [ca.SX.sym(f"x{k}", w) for k, w in enumerate(widths)]
    values = [x[i] for x in inputs for i in range(x.shape[0])]
    names = list(OPERATIONS)
    for _ in range(150):
        a, b = (values[k] for k in rng.integers(0, len(values), 2))
        values.append(ca.sin(OPERATIONS[names[rng.integers(len(names))]](ca.sin(a), b)))
    outputs = [ca.densify(ca.vertcat(*values[-5:])), ca.densify(ca.SX(values[-1])), ca.densify(inputs[0])]
    return ca.Function("tangled", inputs, outputs)


@pytest.mark.parametrize("name", OPERATIONS)
def test_every_operation_gives_the_bits_of_casadi(name: str) -> None:
    a, b = ca.SX.sym("a"), ca.SX.sym("b")
    function = ca.Function("f", [a, b], [ca.densify(OPERATIONS[name](a, b))])
    x, y = rough(300, 1, 1), rough(300, 1, 2)
    (out,) = Kernel(function, block=128).run(x, y)
    assert same_bits(out, one_by_one(function, x, y)[0])
    assert np.isfinite(out).sum() > 50


def test_no_operation_of_the_tables_goes_untested() -> None:
    seen = set()
    for make in OPERATIONS.values():
        a, b = ca.SX.sym("a"), ca.SX.sym("b")
        function = ca.Function("f", [a, b], [make(a, b)])
        seen |= {function.instruction_id(k) for k in range(function.n_instructions())}
    table = set(kernel._UNARY) | set(kernel._BINARY)
    assert table - seen == {ca.OP_ASSIGN}  # CasADi folds every assignment away


@pytest.mark.parametrize("rows", [0, 1, 2, 63, 64, 65, 300])
@pytest.mark.parametrize("seed", [0, 1])
def test_any_number_of_rows(rows: int, seed: int) -> None:
    function = tangled(seed, (3, 1, 4))
    inputs = [rough(rows, w, seed + k) for k, w in enumerate((3, 1, 4))]
    got = Kernel(function, block=64).run(*inputs)
    assert [g.shape for g in got] == [(rows, 5), (rows, 1), (rows, 3)]
    for g, expected in zip(got, one_by_one(function, *inputs), strict=True):
        assert same_bits(g, expected)
    assert same_bits(got[2], inputs[0])


@pytest.mark.parametrize("rows", [BLOCK - 1, BLOCK, BLOCK + 1])
def test_around_the_default_block(rows: int) -> None:
    function = tangled(5, (2, 2))
    x, y = rough(rows, 2, 3), rough(rows, 2, 4)
    for g, expected in zip(Kernel(function).run(x, y), one_by_one(function, x, y), strict=True):
        assert same_bits(g, expected)


@pytest.mark.parametrize("rows", [16 * BLOCK, 16 * BLOCK + 1, 21 * BLOCK + 17])
def test_threads_do_not_change_a_bit(rows: int) -> None:
    function = tangled(7, (3, 2))
    x, y = rough(rows, 3, 8), rough(rows, 2, 9)
    one, two, five = (Kernel(function, threads=t).run(x, y) for t in (1, 2, 5))
    for a, b, c in zip(one, two, five, strict=True):
        assert same_bits(a, b) and same_bits(a, c)
    some = np.r_[0:40, rows // 2 - 20 : rows // 2 + 20, rows - 40 : rows]
    for a, expected in zip(one, one_by_one(function, x[some], y[some]), strict=True):
        assert same_bits(a[some], expected)


def test_a_shared_row_is_given_once() -> None:
    function = tangled(9, (3, 2))
    x, shared = rough(700, 3, 1), np.array([0.3, -1.2])
    expected = Kernel(function).run(x, np.tile(shared, (700, 1)))
    for a, b in zip(Kernel(function).run(x, shared), expected, strict=True):
        assert same_bits(a, b)
    assert [r.shape for r in Kernel(function).run(x[0], shared)] == [(1, 5), (1, 1), (1, 3)]


def test_what_a_run_leaves_in_memory_is_not_in_the_next() -> None:
    """One kernel, more rows and fewer, shared rows and own ones, in turn; and after a pickle."""
    function = tangled(9, (3, 2))
    one = Kernel(function)
    for kernel_, rows, seed in [(one, 700, 1), (one, 5, 2), (pickle.loads(pickle.dumps(one)), 3, 3), (one, 700, 4)]:
        x, shared = rough(rows, 3, seed), rough(1, 2, seed + 10)[0]
        for second in (shared, shared[::-1].copy(), rough(rows, 2, seed + 20), shared):
            for a, b in zip(kernel_.run(x, second), Kernel(function).run(x, second), strict=True):
                assert same_bits(a, b)


def test_empty_inputs_and_outputs_and_constants() -> None:
    x, nothing = ca.SX.sym("x", 2), ca.SX.sym("nothing", 0)
    function = ca.Function("f", [x, nothing], [ca.SX(0, 1), ca.SX(ca.DM([3.5, -0.25])), x[0] + x[1]])
    empty, constant, total = Kernel(function).run(rough(10, 2), np.empty((10, 0)))
    assert empty.shape == (10, 0)
    np.testing.assert_array_equal(constant, np.tile([3.5, -0.25], (10, 1)))
    np.testing.assert_array_equal(total[:, 0], rough(10, 2).sum(axis=1))
    (alone,) = Kernel(ca.Function("g", [], [ca.SX(ca.DM([4.0]))])).run()
    np.testing.assert_array_equal(alone, [[4.0]])


def test_strided_and_column_major_arrays() -> None:
    function = tangled(11, (3, 2))
    x, y = rough(900, 3), rough(900, 2)
    expected = Kernel(function).run(x[::3], y[::3])
    again = Kernel(function).run(np.asfortranarray(x)[::3], np.asfortranarray(y)[::3])
    for a, b in zip(again, expected, strict=True):
        assert same_bits(a, b)


def test_a_bad_row_spoils_no_other() -> None:
    function = tangled(13, (2,))
    x = rough(600, 2)
    clean = Kernel(function).run(x)
    x[77] = np.nan
    x[400] = np.inf
    for a, b in zip(Kernel(function).run(x), clean, strict=True):
        keep = np.delete(np.arange(600), [77, 400])
        assert same_bits(a[keep], b[keep])


def test_an_operation_without_a_column_form_is_refused() -> None:
    x = ca.SX.sym("x")
    with pytest.raises(NotImplementedError, match=rf"operation {ca.OP_ERFINV} of inverse"):
        replay(ca.Function("inverse", [x], [ca.erfinv(x)]), 4)


def test_wrong_shapes_are_refused() -> None:
    q, w = ca.SX.sym("q", 3), ca.SX.sym("w", 2)
    k = Kernel(ca.Function("f", [q, w], [q[0] + w[1]], ["q", "w"], ["sum"]))
    with pytest.raises(ValueError, match=r"takes.*got 1 arrays"):
        k.run(np.zeros((5, 3)))
    with pytest.raises(ValueError, match=r"w of f: shape \(5, 3\), not \(5, 2\)"):
        k.run(np.zeros((5, 3)), np.zeros((5, 3)))
    with pytest.raises(ValueError, match=r"q of f: shape \(4, 3\), not \(5, 3\)"):
        k.run(np.zeros((4, 3)), np.zeros((5, 2)))
    with pytest.raises(ValueError, match=r"w of f: shape \(3,\)"):
        k.run(np.zeros((3, 3)), np.zeros(3))
    with pytest.raises(ValueError, match=r"shape \(1, 5, 3\)"):
        k.run(np.zeros((1, 5, 3)), np.zeros((5, 2)))


def test_sparse_functions_are_refused() -> None:
    x, s = ca.SX.sym("x", 2), ca.SX.sym("s", ca.Sparsity.diag(2))
    with pytest.raises(ValueError, match=r"output.*sparse"):
        Kernel(ca.Function("f", [x], [ca.SX(2, 1)]))
    with pytest.raises(ValueError, match=r"input.*sparse"):
        Kernel(ca.Function("g", [s], [s[0, 0] + s[1, 1]]))
