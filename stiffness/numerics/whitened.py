"""Whitened blocks: residuals that are correlated inside a block, made independent and of unit variance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import linalg, sparse

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]

STACKED = 256  # blocks per product: one of large matrices costs less than many of small ones
OFTEN = 0.5  # of all blocks: a number that so many have is one of a dense product


@dataclass(frozen=True, repr=False)
class Whitened:
    """One block: whitened ``residual`` (k,) and ``jacobian`` (k, c), and the Cholesky ``factor`` of its covariance.

    ``columns`` (c,): the numbers that the jacobian is by; None: all of them, in their order.
    """

    rows: Index
    residual: Floats
    jacobian: Floats
    factor: Floats
    columns: Index | None = None

    def wide(self, width: int) -> Floats:
        """(k, width) the jacobian by all numbers."""
        if self.columns is None:
            return self.jacobian
        out = np.zeros((len(self.jacobian), width))
        out[:, self.columns] = self.jacobian
        return out


def whitened(
    rows: Index, residual: Floats, jacobian: Floats, covariance: Floats, columns: Index | None = None
) -> Whitened:
    """Whiten one block; ``covariance`` (k, k) is positive definite."""
    factor = np.linalg.cholesky(covariance)
    both = linalg.solve_triangular(factor, np.column_stack([residual, jacobian]), lower=True, check_finite=False)
    return Whitened(rows, both[:, 0], both[:, 1:], np.asarray(factor, dtype=float), columns=columns)


def gram(parts: Sequence[Whitened], width: int) -> Floats:
    """(width + 1, width + 1) products of the jacobian's columns of all blocks; the residual is the last column."""
    out = _compact([b for b in parts if b.columns is not None], width)
    whole = [b for b in parts if b.columns is None]
    for k in range(0, len(whole), STACKED):
        both = np.concatenate([np.column_stack([b.jacobian, b.residual]) for b in whole[k : k + STACKED]])
        out += both.T @ both
    return out


def _compact(parts: Sequence[Whitened], width: int) -> Floats:
    """``gram`` of blocks with few numbers each: those that most blocks have in a dense product, all others sparse."""
    out = np.zeros((width + 1, width + 1))
    given = [(b, b.columns) for b in parts if b.columns is not None]
    if not given:
        return out
    share = np.bincount(np.concatenate([c for _, c in given]), minlength=width) / len(given)
    often = share > OFTEN
    at, place = np.append(np.flatnonzero(often), width), np.cumsum(often) - 1
    ends = np.cumsum([len(b.residual) for b in parts])
    dense = np.zeros((int(ends[-1]), len(at)))
    value, row, column = list[Floats](), list[Index](), list[Index]()
    for end, (b, columns) in zip(ends.tolist(), given, strict=True):
        mine, here = often[columns], np.arange(end - len(b.residual), end)
        dense[here[:, None], place[columns[mine]]] = b.jacobian[:, mine]
        dense[here, -1] = b.residual
        rest = columns[~mine]
        value.append(b.jacobian[:, ~mine].ravel())
        row.append(np.repeat(here, len(rest)))
        column.append(np.tile(rest, len(here)))
    triplets = np.concatenate(value), (np.concatenate(row), np.concatenate(column))
    few = sparse.csr_array(triplets, shape=(len(dense), width))
    cross = np.asarray(few.T @ dense)  # zero where a number is one of the dense product
    out[np.ix_(at, at)] = dense.T @ dense
    out[:width, at] += cross
    out[at, :width] += cross.T
    pairs = (few.T @ few).tocoo()  # each once
    out[pairs.row, pairs.col] += pairs.data
    return out


def deletion_statistics(block: Whitened, sizes: Sequence[int]) -> Floats:
    """Chi-square of leaving out each reading of a block; ``sizes``: how many numbers each reading has.

    With z = C^-1 r and M = C^-1 the reading i, predicted from all the others, misses by M_ii^-1 z_i with covariance
    M_ii^-1, so that z_i' M_ii^-1 z_i is chi-square with as many degrees of freedom as it has numbers.
    """
    inverse_factor = linalg.solve_triangular(block.factor, np.eye(len(block.factor)), lower=True, check_finite=False)
    precision = inverse_factor.T @ inverse_factor
    z = inverse_factor.T @ block.residual
    ends = np.cumsum(sizes)
    spans = [slice(int(e) - n, int(e)) for e, n in zip(ends, sizes, strict=True)]
    return np.array([float(z[s] @ np.linalg.solve(precision[s, s], z[s])) for s in spans])
