"""Derivatives that are kept small give what the whole matrices give."""

from __future__ import annotations

import numpy as np
import pytest

from stiffness.identification.reading_slopes import ReadingSlopes
from stiffness.numerics.whitened import Whitened, gram

N, CORE, TABLES, JOINTS, POSTURES = 40, 5, 30, 3, 12


@pytest.fixture
def slopes() -> ReadingSlopes:
    """Numbers of tables and others in mixed order; a posture meets two numbers of each joint's table."""
    rng = np.random.default_rng(3)
    order = rng.permutation(CORE + TABLES)
    joint = np.repeat(np.arange(JOINTS), TABLES // JOINTS)
    slope = np.zeros((POSTURES, TABLES))
    for k in range(POSTURES):
        for j in range(JOINTS):
            knot = rng.integers(0, TABLES // JOINTS - 1)
            share = rng.uniform(0.1, 0.9)
            slope[k, j * 10 + knot], slope[k, j * 10 + knot + 1] = 1 - share, share
    return ReadingSlopes(
        count=CORE + TABLES,
        core=np.sort(order[:CORE]),
        dense=rng.normal(size=(N, 3, CORE)),
        own=np.sort(order[CORE:]),
        joint=joint,
        by_angle=rng.normal(size=(N, 3, JOINTS)),
        slope=slope,
        of=rng.integers(0, POSTURES, N),
    )


def test_a_block_has_the_numbers_that_its_readings_meet(slopes: ReadingSlopes) -> None:
    whole = slopes.whole()
    for k, number in enumerate(slopes.own):
        by_hand = slopes.by_angle[:, :, slopes.joint[k]] * slopes.slope[slopes.of, k][:, None]
        np.testing.assert_allclose(whole[:, :, number], by_hand)
    for rows in (np.array([4]), np.array([3, 17, 9])):
        block, numbers = slopes.block(rows)
        assert CORE + 6 <= len(numbers) <= CORE + 6 * len(rows) < CORE + TABLES
        wide = np.zeros((3 * len(rows), slopes.count))
        wide[:, numbers] = block
        np.testing.assert_allclose(wide, whole[rows].reshape(3 * len(rows), -1), rtol=1e-14)


def test_other_axes_other_places_and_a_sparse_matrix_have_the_same_numbers(slopes: ReadingSlopes) -> None:
    rng, whole = np.random.default_rng(5), slopes.whole()
    turn = rng.normal(size=(N, 3, 3))
    np.testing.assert_allclose(slopes.turned(turn).whole(), turn @ whole)
    numbers = [int(slopes.own[7]), int(slopes.core[2]), int(slopes.own[20])]
    some = slopes.taken(numbers, [4, 0, 2], 6)
    np.testing.assert_allclose(some.whole()[:, :, [4, 0, 2]], whole[:, :, numbers])
    assert not some.whole()[:, :, [1, 3, 5]].any()
    rows, sd = rng.uniform(size=N) < 0.6, rng.uniform(0.5, 2.0, (N, 3))
    weighted = slopes.over(sd[rows], rows)
    assert weighted.nnz < weighted.shape[0] * (CORE + 6) + 1
    np.testing.assert_allclose(weighted.toarray(), (whole[rows] / sd[rows][:, :, None]).reshape(-1, slopes.count))


def test_products_of_few_columns_are_those_of_the_wide_matrix(slopes: ReadingSlopes) -> None:
    rng = np.random.default_rng(8)
    parts = []
    for rows in np.array_split(np.arange(N), 17):
        block, numbers = slopes.block(rows)
        parts.append(Whitened(rows, rng.normal(size=len(block)), block, np.eye(len(block)), numbers))
    wide = [Whitened(b.rows, b.residual, b.wide(slopes.count), b.factor) for b in parts]
    expected = np.hstack(
        [np.concatenate([b.jacobian for b in wide]), np.concatenate([b.residual for b in wide])[:, None]]
    )
    np.testing.assert_allclose(gram(parts, slopes.count), expected.T @ expected, atol=1e-12)
    np.testing.assert_allclose(gram(wide, slopes.count), expected.T @ expected, atol=1e-12)
    mixed = [*parts[:5], *wide[5:]]
    np.testing.assert_allclose(gram(mixed, slopes.count), expected.T @ expected, atol=1e-12)
