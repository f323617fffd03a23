"""Force fit: coefficients of the cutting force from measured mean forces or spindle powers, by least squares."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.errors import CompensatorError
from compensator.process.milling.force_tests import ForceTest
from compensator.process.milling.material import NAMES, SI
from stiffness.model.toml_text import toml_text

Floats = npt.NDArray[np.float64]

RANK = 1e-6  # of the largest singular value of columns of length 1: less tells nothing
PART = 0.05  # share of a coefficient in a combination that the tests do not tell
ROUNDING = 1e-9  # of the standard deviations: a smaller covariance is none
WEIGHING = 3  # times that forces and powers are weighed by what they leave


@dataclass(frozen=True, repr=False)
class ForceFit:
    """What force tests tell of a material; SI, in the order of NAMES.

    Attributes:
        coefficients: (6,); NaN where not determined.
        covariance: (6, 6); NaN there.
        undetermined: name -> why.
        rms: kind (``N``, ``W``) -> root mean square of what is left.
        condition: of the columns that are determined, each of length 1.
        count: readings. tests: what it was made of.
    """

    coefficients: Floats
    covariance: Floats
    undetermined: dict[str, str]
    rms: dict[str, float]
    condition: float
    count: int
    tests: tuple[ForceTest, ...]

    def __repr__(self) -> str:
        return f"ForceFit({self.count} readings, {6 - len(self.undetermined)} of 6 determined)"

    @property
    def sd(self) -> Floats:
        """(6,) standard deviations, NaN where not determined."""
        return np.sqrt(np.diag(self.covariance))


def fit_forces(tests: Sequence[ForceTest], source: str) -> ForceFit:
    """Least squares; forces and powers count by what they leave.

    Raises:
        CompensatorError: not more readings than numbers, or not even ktc is determined.
    """
    rows = [t.rows() for t in tests]
    a, y = np.concatenate([r[0] for r in rows]) * SI, np.concatenate([r[1] for r in rows])  # in N/mm2 and N/mm
    kinds = np.concatenate([r[2] for r in rows])
    undetermined = _undetermined(a, kinds)
    used = [i for i, n in enumerate(NAMES) if n not in undetermined]
    if "ktc" in undetermined:
        raise CompensatorError(f"{source}: ktc is not determined: {undetermined['ktc']}")
    if len(y) <= len(used):
        what = f"{len(y)} readings for {len(used)} numbers"
        raise CompensatorError(f"{source}: {what}; more are needed to tell how sure they are")
    weight = np.ones(len(y))
    for _ in range(WEIGHING):
        k, covariance, rms = _solved(a[:, used], y, kinds, weight)
        weight = 1.0 / np.array([max(rms[kind], 1e-12) for kind in kinds])
    scaled = a[:, used] * weight[:, None]
    out, cov = np.full(6, np.nan), np.full((6, 6), np.nan)
    out[used], cov[np.ix_(used, used)] = k, covariance
    condition = float(np.linalg.cond(scaled / np.linalg.norm(scaled, axis=0)))
    return ForceFit(
        out * SI, cov * np.outer(SI, SI), undetermined, rms, condition=condition, count=len(y), tests=tuple(tests)
    )


def _solved(
    a: Floats, y: Floats, kinds: npt.NDArray[np.str_], weight: Floats
) -> tuple[Floats, Floats, dict[str, float]]:
    """Numbers, their covariance, and the root mean square that each kind of reading leaves."""
    k: Floats = np.asarray(np.linalg.lstsq(a * weight[:, None], y * weight, rcond=None)[0], dtype=float)
    left = y - a @ k
    lost = len(k) / len(y)  # share of the readings that the numbers take up
    rms = {
        kind: float(np.sqrt(np.mean(left[kinds == kind] ** 2) / (1.0 - lost)))
        for kind in map(str, np.unique(kinds))
    }
    noise = np.array([rms[kind] for kind in kinds])
    inverse = np.linalg.inv((a * weight[:, None]).T @ (a * weight[:, None]))
    gain = inverse @ (a * weight[:, None]).T * weight  # k = gain y
    return k, np.asarray((gain * noise**2) @ gain.T, dtype=float), rms


def _undetermined(a: Floats, kinds: npt.NDArray[np.str_]) -> dict[str, str]:
    """Coefficients that no reading depends on, or that readings cannot tell from others."""
    size = np.linalg.norm(a, axis=0)
    largest = size.max(initial=0.0)
    silent = size <= 1e-9 * largest
    if np.all(kinds == "W"):
        silent |= np.array([n not in ("ktc", "kte") for n in NAMES])
        why = "spindle power tells of the tangential force only"
    else:
        why = "no reading depends on it"
    out = {NAMES[i]: why for i in np.flatnonzero(silent)}
    used = np.flatnonzero(~silent)
    if not len(used):
        return out
    _, values, ways = np.linalg.svd(a[:, used] / size[used], full_matrices=True)
    values = np.concatenate([values, np.zeros(len(used) - len(values))])
    for way in ways[values < RANK * values[0]]:
        mixed = [NAMES[used[i]] for i in np.flatnonzero(np.abs(way) > PART)]
        for name in mixed:
            out.setdefault(name, f"the tests do not tell {' from '.join(mixed)}: measure at another feed per tooth")
    return out


def material_text(fit: ForceFit, name: str, source: str) -> str:
    """A material/1 file of what is determined."""
    used = [i for i in range(6) if NAMES[i] not in fit.undetermined]
    values, sd = fit.coefficients / SI, fit.sd / SI
    covariance = np.nan_to_num(fit.covariance / np.outer(SI, SI))
    covariance = 0.5 * (covariance + covariance.T)
    size = np.sqrt(np.diag(covariance))
    covariance[np.abs(covariance) < ROUNDING * np.outer(size, size)] = 0.0  # which would differ between machines
    feeds = [t.feed * 1e3 for t in fit.tests]
    speeds = [60.0 * np.pi * t.cutter.diameter * t.spindle for t in fit.tests if t.spindle]
    tools = sorted({f"{t.cutter.shape} {t.cutter.diameter * 1e3:g} mm, {t.cutter.flutes} flutes" for t in fit.tests})
    span: dict[str, object] = {"feed_per_tooth_mm": [min(feeds), max(feeds)]}
    if speeds:
        span["speed_m_min"] = [float(min(speeds)), float(max(speeds))]
    table = {
        "schema": "material/1",
        "name": name,
        "source": source,
        "sign": "as measured: forces on the tool in path axes, z out of the tool into the work",
        "covariance": [[float(f"{v:.9g}") for v in row] for row in covariance],
        "coefficients": {NAMES[i]: float(f"{values[i]:.9g}") for i in used},
        "sd": {NAMES[i]: float(f"{sd[i]:.6g}") for i in used},
        "range": {**span, "tool": "; ".join(tools)},
    }
    return toml_text(table)
