"""A scalar CasADi function as a loop over poses in C, from CasADi's own C code."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt

from stiffness.numerics.machine_code import machine_code

Floats = npt.NDArray[np.float64]

LARGEST = 6000  # instructions; the time of a compiler grows faster than their number

_LOOP = """
void over_rows(long begin, long end, const double *const *in, const long *step, double *const *out)
{{
    const double *arg[{arg}];
    double *res[{res}], w[{w}];
    {integer} iw[{iw}];
    static const long width[] = {{{widths}}};
    for (long i = begin; i < end; i++) {{
        for (int k = 0; k < {n_in}; k++) arg[k] = in[k] + i * step[k];
        for (int k = 0; k < {n_out}; k++) res[k] = out[k] + i * width[k];
        {name}(arg, res, iw, w, 0);
    }}
}}
"""


class KernelInC:
    """The function over rows of arrays; many threads may run it at once.

    Args:
        library: of its text.
        function: as given to ``kernel_in_c``.
    """

    def __init__(self, library: Any, function: ca.Function) -> None:
        self._over_rows, self._name = library.over_rows, function.name()

    def __repr__(self) -> str:
        return f"KernelInC({self._name})"

    def run(self, inputs: Sequence[Floats], outputs: Sequence[Floats], a: int, b: int) -> None:
        """Rows ``a`` to ``b`` of ``outputs``, arrays (N, m_j), from ``inputs``, (N, k_i) or (k_i,) for all rows."""
        given = [x if x.strides[-1:] == (8,) and x.dtype == np.float64 else _plain(x) for x in inputs]
        steps = [x.strides[0] // 8 if x.ndim == 2 else 0 for x in given]
        into, out = (_pointers([x.ctypes.data for x in arrays]) for arrays in (given, outputs))
        self._over_rows(*(ctypes.c_long(a), ctypes.c_long(b), into, (ctypes.c_long * len(steps))(*steps), out))


def kernel_in_c(function: ca.Function, *, compiles: bool = True) -> KernelInC | None:
    """None where there is no compiler, where the function is too large, or, unless it ``compiles``, none is kept."""
    if function.n_instructions() > LARGEST:
        return None
    generator = ca.CodeGenerator("kernel", {"with_header": False})
    generator.add(function)
    text = generator.dump() + _LOOP.format(
        arg=max(function.sz_arg(), 1), res=max(function.sz_res(), 1), w=max(function.sz_w(), 1),
        iw=max(function.sz_iw(), 1), integer="casadi_int", n_in=function.n_in(), n_out=function.n_out(),
        widths=", ".join(str(function.numel_out(j)) for j in range(function.n_out())), name=function.name(),
    )  # fmt: skip
    library = machine_code(text, compiles=compiles)
    return None if library is None else KernelInC(library, function)


def _plain(array: Floats) -> Floats:
    return np.ascontiguousarray(array, dtype=np.float64)


def _pointers(addresses: Sequence[int]) -> Any:
    return (ctypes.c_void_p * len(addresses))(*addresses)
