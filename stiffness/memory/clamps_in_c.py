"""The loops of clamp_scan.py in C: the same operations in the same order, so that no number differs."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np

from stiffness.effects.effect import Floats
from stiffness.numerics.machine_code import machine_code

_TEXT = """
static double clamped(double state, double shift, double low, double high)
{
    state += shift;
    state = state >= low || state != state ? state : low;
    return state <= high || state != state ? state : high;
}

/* Every run of rows as one clamp; lowest and highest (runs, n) begin beyond all states. */
void composed(long rows, long n, long length, const double *shift, const double *low, const double *high,
              double *total, double *lowest, double *highest)
{
    for (long first = 0; first < rows; first += length, total += n, lowest += n, highest += n)
        for (long k = first; k < first + length && k < rows; k++)
            for (long j = 0; j < n; j++) {
                long at = k * n + j;
                total[j] = k == first ? shift[at] : total[j] + shift[at];
                lowest[j] = clamped(lowest[j], shift[at], low[at], high[at]);
                highest[j] = clamped(highest[j], shift[at], low[at], high[at]);
            }
}

/* States out (rows, starts, n), every run of rows from its own before (runs, starts, n). */
void walked(long rows, long n, long length, const double *shift, const double *low, const double *high,
            long starts, const double *before, double *out)
{
    for (long first = 0; first < rows; first += length, before += starts * n)
        for (long s = 0; s < starts; s++) {
            const double *state = before + s * n;
            for (long k = first; k < first + length && k < rows; k++) {
                double *to = out + (k * starts + s) * n;
                for (long j = 0; j < n; j++) {
                    long at = k * n + j;
                    to[j] = clamped(state[j], shift[at], low[at], high[at]);
                }
                state = to;
            }
        }
}
"""


class ClampsInC:
    """Clamps (rows, n) in runs of ``length`` rows.

    Args:
        library: what ``clamps_in_c`` gives.
    """

    def __init__(self, library: Any, shift: Floats, low: Floats, high: Floats, *, length: int) -> None:
        self._library, self._arrays = library, [np.ascontiguousarray(a, dtype=np.float64) for a in (shift, low, high)]
        self.rows, self.n, self.length = len(shift), int(shift.shape[1]), length
        self.runs = -(-self.rows // length)

    def __repr__(self) -> str:
        return f"ClampsInC({self.rows} rows, {self.length} a run)"

    def composed(self, far: float) -> tuple[Floats, Floats, Floats]:
        """Every run as one clamp: shift, low and high (runs, n); ``far`` is beyond all states."""
        shape = (self.runs, self.n)
        total, lowest, highest = np.empty(shape), np.full(shape, -far), np.full(shape, far)
        self._library.composed(*self._given, *map(_pointer, (total, lowest, highest)))
        return total, lowest, highest

    def walked(self, before: Floats) -> Floats:
        """States (rows, S, n) of S walks, every run from its own ``before`` (runs, S, n)."""
        before, starts = np.ascontiguousarray(before), before.shape[1]
        out = np.empty((self.rows, starts, self.n))
        self._library.walked(*self._given, ctypes.c_long(starts), _pointer(before), _pointer(out))
        return out

    @property
    def _given(self) -> tuple[Any, ...]:
        return (*map(ctypes.c_long, (self.rows, self.n, self.length)), *map(_pointer, self._arrays))


def clamps_in_c() -> Any:
    """Their machine code; None where there is no compiler."""
    return machine_code(_TEXT)


def _pointer(array: Floats) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)
