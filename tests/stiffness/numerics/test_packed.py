"""Packed symmetric matrices against the whole ones."""

from __future__ import annotations

import numpy as np

from stiffness.numerics.packed import Packed


def test_a_packed_matrix_is_the_whole_one_and_any_block_of_it() -> None:
    rng = np.random.default_rng(2)
    for n in (1, 2, 7, 60):
        a, b = ((m + m.T) for m in rng.normal(size=(2, n, n)))
        packed = Packed.of(a)
        assert len(packed) == n and packed.triangle.size == n * (n + 1) // 2
        np.testing.assert_array_equal(packed.whole(), a)
        np.testing.assert_array_equal((packed + Packed.of(b)).whole(), a + b)
        at = rng.integers(0, n, 5)
        np.testing.assert_array_equal(packed.block(at), a[np.ix_(at, at)])
