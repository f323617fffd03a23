"""Kernel: one scalar CasADi function, run over many poses at once.

The instructions of an SX function are replayed on MX column vectors, so that CasADi's virtual machine
pays its overhead once per block of poses instead of once per pose, and numpy memory goes in and out
through ``Function.buffer`` without a copy into DM (measured in benchmarks/; no compiler is needed).
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache, partial
from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt

from stiffness.numerics.cores import cores
from stiffness.numerics.kernel_in_c import KernelInC, kernel_in_c

Floats = npt.NDArray[np.float64]
Span = Callable[[tuple[Floats, ...], tuple[Floats, ...], int, int], None]

POOL = "kernel"  # name of the threads
BLOCK = 512
IN_C_FROM = 30_000  # rows that a kernel has run over, from which on machine code is taken where it is kept
COMPILED_FROM = 500_000  # and made where it is not: a compiler takes half a second, and saves it over a million
_SMALL = (1, 32)  # poses of calls with few: every size costs a replay of the instructions, a tenth of a second
_THREADS_FROM = 16 * BLOCK  # below this, a second thread costs more than it brings

_UNARY: dict[int, Callable[[ca.MX], ca.MX]] = {
    ca.OP_ASSIGN: lambda a: a,
    ca.OP_NEG: lambda a: -a,
    ca.OP_EXP: ca.exp,
    ca.OP_LOG: ca.log,
    ca.OP_SQRT: ca.sqrt,
    ca.OP_SQ: lambda a: a * a,
    ca.OP_TWICE: lambda a: 2 * a,
    ca.OP_SIN: ca.sin,
    ca.OP_COS: ca.cos,
    ca.OP_TAN: ca.tan,
    ca.OP_ASIN: ca.asin,
    ca.OP_ACOS: ca.acos,
    ca.OP_ATAN: ca.atan,
    ca.OP_NOT: ca.logic_not,
    ca.OP_FLOOR: ca.floor,
    ca.OP_CEIL: ca.ceil,
    ca.OP_FABS: ca.fabs,
    ca.OP_SIGN: ca.sign,
    ca.OP_INV: lambda a: 1 / a,
    ca.OP_SINH: ca.sinh,
    ca.OP_COSH: ca.cosh,
    ca.OP_TANH: ca.tanh,
    ca.OP_ASINH: ca.asinh,
    ca.OP_ACOSH: ca.acosh,
    ca.OP_ATANH: ca.atanh,
    ca.OP_ERF: ca.erf,
    ca.OP_LOG1P: ca.log1p,
    ca.OP_EXPM1: ca.expm1,
}
_BINARY: dict[int, Callable[[ca.MX, ca.MX], ca.MX]] = {
    ca.OP_ADD: lambda a, b: a + b,
    ca.OP_SUB: lambda a, b: a - b,
    ca.OP_MUL: lambda a, b: a * b,
    ca.OP_DIV: lambda a, b: a / b,
    ca.OP_POW: lambda a, b: a**b,
    ca.OP_CONSTPOW: lambda a, b: a**b,
    ca.OP_LT: lambda a, b: a < b,
    ca.OP_LE: lambda a, b: a <= b,
    ca.OP_EQ: lambda a, b: a == b,
    ca.OP_NE: lambda a, b: a != b,
    ca.OP_AND: ca.logic_and,
    ca.OP_OR: ca.logic_or,
    ca.OP_FMOD: ca.fmod,
    ca.OP_REMAINDER: ca.remainder,
    ca.OP_FMIN: ca.fmin,
    ca.OP_FMAX: ca.fmax,
    ca.OP_ATAN2: ca.atan2,
    ca.OP_HYPOT: ca.hypot,
    ca.OP_COPYSIGN: ca.copysign,
    ca.OP_IF_ELSE_ZERO: lambda a, b: ca.if_else(a, b, 0),
}


def replay(function: ca.Function, rows: int) -> ca.Function:
    """The scalar SX ``function`` on ``rows`` poses at once.

    Input i becomes a (rows, k_i) matrix, output j a (rows, m_j) matrix; column c holds element c.

    Raises:
        NotImplementedError: the function uses an operation that has no column form here.
    """
    inputs = [ca.MX.sym(function.name_in(i), rows, function.numel_in(i)) for i in range(function.n_in())]
    columns = [ca.horzsplit(x) if x.shape[1] else [] for x in inputs]
    zero = ca.MX.zeros(rows, 1)
    outputs = [[zero] * function.numel_out(j) for j in range(function.n_out())]
    work: list[ca.MX] = [zero] * function.sz_w()
    for k in range(function.n_instructions()):
        op = function.instruction_id(k)
        o = function.instruction_output(k)
        i = function.instruction_input(k)
        if op == ca.OP_CONST:
            work[o[0]] = ca.MX(function.instruction_constant(k))
        elif op == ca.OP_INPUT:
            work[o[0]] = columns[i[0]][i[1]]
        elif op == ca.OP_OUTPUT:
            outputs[o[0]][o[1]] = work[i[0]]
        elif op in _UNARY:
            work[o[0]] = _UNARY[op](work[i[0]])
        elif op in _BINARY:
            work[o[0]] = _BINARY[op](work[i[0]], work[i[1]])
        else:
            raise NotImplementedError(f"CasADi operation {op} of {function.name()} has no column form")
    full = [
        ca.horzcat(*(c if c.shape[0] == rows else ca.repmat(c, rows, 1) for c in cs)) if cs else ca.MX(rows, 0)
        for cs in outputs
    ]
    return ca.Function(function.name() + "_columns", inputs, [ca.densify(f) for f in full])


class Kernel:
    """A CasADi function with dense column-vector inputs and outputs, run row-wise over arrays.

    Args:
        function: SX function; sparse inputs or outputs are refused.
        block: poses per call.
        threads: default as many as ``cores``; each thread owns its buffers,
            so results do not depend on it.
    """

    def __init__(self, function: ca.Function, *, block: int = BLOCK, threads: int | None = None) -> None:
        for i in range(function.n_in()):
            if not function.sparsity_in(i).is_dense():
                raise ValueError(f"input {function.name_in(i)} of {function.name()} is sparse")
        for j in range(function.n_out()):
            if not function.sparsity_out(j).is_dense():
                raise ValueError(f"output {function.name_out(j)} of {function.name()} is sparse")
        self.function = function
        self.names_in = tuple(function.name_in())
        self.names_out = tuple(function.name_out())
        self._widths_in = [function.numel_in(i) for i in range(function.n_in())]
        self._widths_out = [function.numel_out(j) for j in range(function.n_out())]
        self._block = block
        self._threads = threads
        self._columns: dict[int, ca.Function] = {}
        self._free: dict[int, list[_Memory]] = {}
        self._rows_run, self._next_look = 0, IN_C_FROM
        self._in_c: KernelInC | None = None

    def __repr__(self) -> str:
        return f"Kernel({self.function.name()}, {self.function.n_instructions()} instructions)"

    def __getstate__(self) -> dict[str, Any]:
        free: dict[int, list[_Memory]] = {block: [] for block in self._columns}
        own = {"_free": free, "_in_c": None, "_next_look": IN_C_FROM}  # memory and machine code stay with their process
        return {**self.__dict__, **own}

    def run(self, *inputs: Floats) -> tuple[Floats, ...]:
        """Evaluate every row.

        Args:
            inputs: arrays (N, k_i), or (k_i,) for a value that all rows share.

        Returns:
            Arrays (N, m_j), one per output of the function.
        """
        if len(inputs) != len(self._widths_in):
            raise ValueError(f"{self.function.name()} takes {self.names_in}, got {len(inputs)} arrays")
        rows = max((len(x) for x in inputs if x.ndim == 2), default=1)
        for x, width, name in zip(inputs, self._widths_in, self.names_in, strict=True):
            if x.shape not in ((rows, width), (width,)):
                raise ValueError(f"{name} of {self.function.name()}: shape {x.shape}, not ({rows}, {width})")
        block = next((size for size in _SMALL if rows <= size), self._block)
        outputs = tuple(np.empty((rows, w)) for w in self._widths_out)
        threads = (self._threads or cores()) if rows >= _THREADS_FROM else 1
        step = -(-rows // threads // block) * block if threads > 1 else max(rows, 1)
        spans = [(a, min(a + step, rows)) for a in range(0, rows, step)]
        work = self._work(block, inputs, outputs)
        others = [_pool(os.getpid()).submit(work, inputs, outputs, *span) for span in spans[1:]]
        for span in spans[:1]:
            work(inputs, outputs, *span)
        for other in others:
            other.result()
        return outputs

    def _work(self, block: int, inputs: tuple[Floats, ...], outputs: tuple[Floats, ...]) -> Span:
        """What does a range of rows: C, for a kernel that runs over many rows, where it gives the same numbers."""
        rows = len(outputs[0]) if outputs else 0
        self._rows_run += rows
        if self._in_c is None and self._rows_run >= self._next_look and rows >= self._block:
            compiles = self._rows_run >= COMPILED_FROM
            self._next_look = sys.maxsize if compiles else COMPILED_FROM
            self._in_c = self._checked(kernel_in_c(self.function, compiles=compiles), inputs, outputs)
        if self._in_c is not None and rows >= self._block:
            return self._in_c.run
        self._prepare(block)
        return partial(self._span, block)

    def _checked(
        self, kernel: KernelInC | None, inputs: tuple[Floats, ...], outputs: tuple[Floats, ...]
    ) -> KernelInC | None:
        """The kernel, if a block of these rows becomes what it becomes without."""
        if kernel is None:
            return None
        self._prepare(self._block)
        found, expected = (tuple(np.empty((self._block, w)) for w in self._widths_out) for _ in range(2))
        self._span(self._block, inputs, expected, a=0, b=self._block)
        kernel.run(inputs, found, 0, self._block)
        same = all(np.array_equal(a, b, equal_nan=True) for a, b in zip(found, expected, strict=True))
        return kernel if same else None

    def _prepare(self, block: int) -> None:
        if block not in self._columns:
            self._columns[block] = replay(self.function, block)
            self._free[block] = []

    def _span(self, block: int, inputs: tuple[Floats, ...], outputs: tuple[Floats, ...], a: int, b: int) -> None:
        free = self._free[block]
        try:
            own = free.pop()  # by one thread at a time
        except IndexError:
            own = _Memory(self._columns[block], block, self._widths_in, self._widths_out)
        for array, source in zip(own.ins, inputs, strict=True):
            if source.ndim == 1:
                array[:] = source[:, None]
        for start in range(a, b, block):
            count = min(block, b - start)
            for array, source in zip(own.ins, inputs, strict=True):
                if source.ndim == 2:
                    array[:, :count] = source[start : start + count].T
            own.evaluate()
            for array, target in zip(own.outs, outputs, strict=True):
                target[start : start + count] = array[:, :count].T
        free.append(own)


class _Memory:
    """What one thread evaluates a block of poses in; making it takes as long as some hundred poses."""

    def __init__(self, columns: ca.Function, block: int, widths_in: list[int], widths_out: list[int]) -> None:
        self._buffer, self.evaluate = columns.buffer()
        # CasADi matrices are column-major: a C array of shape (columns, rows) is the same memory.
        self.ins = [np.zeros((w, block)) for w in widths_in]
        self.outs = [np.zeros((w, block)) for w in widths_out]
        for k, array in enumerate(self.ins):
            if array.size:
                self._buffer.set_arg(k, memoryview(array))  # type: ignore[call-arg, arg-type]  # stubs know the C form
        for k, array in enumerate(self.outs):
            if array.size:
                self._buffer.set_res(k, memoryview(array))  # type: ignore[call-arg, arg-type]


@lru_cache(maxsize=1)
def _pool(process: int) -> ThreadPoolExecutor:
    """The threads of this process: those of the one that it was forked from are not there."""
    return ThreadPoolExecutor(max(os.cpu_count() or 1, 1), POOL)
