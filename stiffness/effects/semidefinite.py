"""Symmetric matrices without negative directions that are nearest to what data say, by how sure they are of it."""

from __future__ import annotations

import numpy as np

from stiffness.effects.effect import Floats

_START = 0.1  # of the largest eigenvalue: the smallest of the matrix that the iteration starts from
_CLOSE = 1e-6  # of chi-square: how near the result is to the best
_ROUNDING = 1e-12  # of the chi-square that the iteration starts with
_NEWTON = 30  # steps for one height of the barrier


def nearest_semidefinite(wanted: Floats, precision: Floats, *, unit_diagonal: bool = False) -> Floats:
    """The positive definite C (n, n) with the smallest (c - w)' P (c - w) / 2 - mu log det C, mu -> 0.

    An interior-point method (Boyd & Vandenberghe, Convex Optimization, 11.3): mu n is how far the first term is from
    its smallest value.

    Args:
        wanted: (n, n) symmetric; its entries are of similar size.
        precision: (Q, Q) of c: the diagonal, unless that is held at one, then the entries below it row by row.
        unit_diagonal: the diagonal is one.
    """
    n = len(wanted)
    rows, columns = np.tril_indices(n, -1)
    if not unit_diagonal:
        rows, columns = np.concatenate([np.arange(n), rows]), np.concatenate([np.arange(n), columns])
    basis = np.zeros((len(rows), n, n))
    basis[np.arange(len(rows)), rows, columns] = basis[np.arange(len(rows)), columns, rows] = 1.0
    fixed = np.eye(n) if unit_diagonal else np.zeros((n, n))
    target = wanted[rows, columns]
    c = np.zeros(len(rows)) if unit_diagonal else _inside(wanted)[rows, columns]
    worth = float((c - target) @ precision @ (c - target))
    least = max(_CLOSE, _ROUNDING * worth) / n
    mu = max(worth, 1.0) / n
    while mu > least:
        mu = max(mu / 5, least)
        for _ in range(_NEWTON):
            inner = np.linalg.inv(fixed + np.tensordot(c, basis, 1))
            turned = inner @ basis
            gradient = precision @ (c - target) - mu * np.trace(turned, axis1=1, axis2=2)
            curved = precision + mu * np.einsum("pij,qji->pq", turned, turned)
            step = -np.linalg.solve(curved, gradient)
            # along a Newton step of a barrier 1 / (1 + length) of it is safe
            length = float(np.sqrt(max(-gradient @ step, 0.0) / mu))
            c = c + step * (1.0 if length < 0.25 else 1 / (1 + length))
            if length < 1e-3:
                break
    return np.asarray(fixed + np.tensordot(c, basis, 1))


def _inside(wanted: Floats) -> Floats:
    """``wanted`` with its small and negative eigenvalues raised."""
    values, vectors = np.linalg.eigh(wanted)
    floor = _START * max(float(np.abs(values).max()), 1e-300)
    return np.asarray((vectors * np.maximum(values, floor)) @ vectors.T)
