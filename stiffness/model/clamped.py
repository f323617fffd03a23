"""The clamping method: the end-effector is locked, one motor turns, its torque and angle give the joint's stiffness.

With a rigid clamp and the arm away from singularities no link can move, so that what the motor turns is wind-up
of its own joint and nothing else: no lever arm, no other joint enters. A straight line per branch

    torque = K angle + c

is fitted to the readings above a share of the largest torque; K is that of the loading branches. Where a line
meets zero torque is a flank of the gap; loading and unloading branch are averaged, which takes friction out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.effects import backlash, joint_stiffness
from stiffness.model.clamped_readings import ClampedError, ClampedReadings
from stiffness.model.model import ComplianceModel
from stiffness.robot.reducer import ARCMIN
from stiffness.robot.robot import Robot

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
Ints = npt.NDArray[np.int64]

ABOVE = 0.25  # share of the largest torque: below it gap, friction and soft first teeth bend the curve
SCALE_SD = 0.05  # of a torque that comes from motor current: what torque constants are off by; an assumption
_FREE = 3  # degrees of freedom that a standard deviation needs at least
_PLAUSIBLE = (1e3, 1e9)  # N*m/rad
_UNKNOWN_GAP = 1.0 * ARCMIN  # standard deviation of a gap that was not measured; docs/datasheet.md


@dataclass(frozen=True, eq=False)
class Branches:
    """The readings of one joint that count, sorted into straight lines.

    Attributes:
        angle, torque: (N,) rad and N*m.
        row: (N,) of the file.
        of: (N,) index of the line.
        repeat, sign, loading: (L,) load cycle, side and branch of each line.
    """

    angle: Floats
    torque: Floats
    row: Ints
    of: npt.NDArray[np.intp]
    repeat: Ints
    sign: Ints
    loading: Bools

    @property
    def up(self) -> Bools:
        """(N,) readings of loading branches."""
        return np.asarray(self.loading[self.of])


@dataclass(frozen=True)
class JointFit:
    """Stiffness and gap of one joint, fitted to its readings.

    Attributes:
        joint: counted from 0.
        stiffness, sd: N*m/rad, of the loading branches; the scale of the torque is in ``sd``.
        unloading: N*m/rad of the unloading branches; None without.
        gap, gap_sd: rad; None where the torque went to one side only.
        friction_in_gap: no unloading branch: the gap is too small by what friction holds.
        hysteresis: rad, width of the loop at zero torque, friction in it; None without both unloading branches.
        largest: N*m at the joint, of all readings.
        misfit: N*m, standard deviation of a reading about its line.
        used, left_out: rows of the file.
    """

    joint: int
    stiffness: float
    sd: float
    unloading: float | None
    gap: float | None
    gap_sd: float | None
    friction_in_gap: bool
    hysteresis: float | None
    largest: float
    misfit: float
    used: int
    left_out: int


def fit_clamped(readings: ClampedReadings, *, above: float = ABOVE, scale_sd: float = SCALE_SD) -> tuple[JointFit, ...]:
    """Fit every joint that has readings.

    Args:
        above: share of the largest torque of a joint and side from which on readings take part.
        scale_sd: standard deviation of the scale of the torque, as a share of it: no repeat shows it.

    Raises:
        ClampedError: too few readings, or a line that cannot be.
    """
    if not 0 <= above < 1:
        raise ClampedError(f"--above {above:g}: expected a share of the largest torque, 0 ... below 1")
    if not 0 <= scale_sd < 1:
        raise ClampedError(f"--torque-scale-sd {scale_sd:g}: expected a share of the torque, 0 ... below 1")
    return tuple(_fit(readings, int(k), above, scale_sd) for k in np.unique(readings.joint))


def _fit(readings: ClampedReadings, joint: int, above: float, scale_sd: float) -> JointFit:
    mine = np.flatnonzero(readings.joint == joint)
    place = f"{readings.source}: joint {joint + 1}"
    b = _branches(readings, mine, above)
    _enough(place, b)
    slopes, offsets, covariance, misfit = _lines(b)
    _plausible(place, slopes[0])
    kind = np.where(b.loading, 0, 1)
    zero = -offsets / slopes[kind]
    gradient = np.zeros((len(zero), 2 + len(zero)))  # of ``zero`` by slopes and offsets
    gradient[np.arange(len(zero)), kind] = offsets / slopes[kind] ** 2
    gradient[np.arange(len(zero)), 2 + np.arange(len(zero))] = -1 / slopes[kind]
    gap, gap_sd, friction = _gap(b, zero, gradient @ covariance @ gradient.T)
    cycles = [_slope(b, int(i)) for i in np.flatnonzero(b.loading)]
    return JointFit(
        joint=joint,
        stiffness=float(slopes[0]),
        sd=float(np.hypot(max(float(np.sqrt(covariance[0, 0])), _between(cycles)), scale_sd * slopes[0])),
        unloading=None if b.loading.all() else float(slopes[1]),
        gap=gap,
        gap_sd=gap_sd,
        friction_in_gap=friction,
        hysteresis=_hysteresis(b, zero),
        largest=float(np.abs(readings.torque[mine]).max()),
        misfit=misfit,
        used=len(b.angle),
        left_out=len(mine) - len(b.angle),
    )


def _branches(readings: ClampedReadings, mine: npt.NDArray[np.intp], above: float) -> Branches:
    sign = np.sign(readings.torque[mine]).astype(np.int64)
    size = np.abs(readings.torque[mine])
    largest = np.array([size[sign == s].max() for s in sign])
    rows = mine[(size > above * largest) & (sign != 0)]
    key = np.stack([readings.repeat[rows], np.sign(readings.torque[rows]), readings.loading[rows]], axis=1)
    kinds, of = np.unique(key.astype(np.int64), axis=0, return_inverse=True)
    return Branches(
        angle=readings.angle[rows],
        torque=readings.torque[rows],
        row=readings.line[rows],
        of=of.ravel(),
        repeat=kinds[:, 0],
        sign=kinds[:, 1],
        loading=kinds[:, 2] == 1,
    )


def _enough(place: str, b: Branches) -> None:
    readings, lines = int(b.up.sum()), int(b.loading.sum())
    if readings - lines - 1 < _FREE:
        raise ClampedError(
            f"{place}: {readings} readings on {lines} loading branch{'es' * (lines != 1)} have torque enough to count; "
            f"expected {_FREE + 1} more readings than branches: add steps of torque"
        )
    for i in range(len(b.loading)):
        angle, rows = b.angle[b.of == i], b.row[b.of == i]
        if np.ptp(angle) <= 1e-12:
            side = f"{'loading' if b.loading[i] else 'unloading'} branch of repeat {b.repeat[i]}"
            raise ClampedError(
                f"{place}, row {', '.join(map(str, rows))}: the {side} has one angle only where the torque is large "
                "enough to count: a line needs two; add steps of torque or take the branch out"
            )


def _plausible(place: str, stiffness: float) -> None:
    low, high = _PLAUSIBLE
    if stiffness <= 0:
        raise ClampedError(f"{place}: the torque falls as the angle grows: turn the sign of one of the two columns")
    if not low <= stiffness <= high:
        raise ClampedError(
            f"{place}: {stiffness:.3g} N*m/rad is outside {low:g} ... {high:g} N*m/rad: check deg or rad, motor or "
            "joint, and gear_ratio (it enters squared)"
        )


def _lines(b: Branches) -> tuple[Floats, Floats, Floats, float]:
    """Slopes (2,) N*m/rad of loading and unloading, offsets (L,) N*m, the covariance of both, and the misfit N*m."""
    scale = float(np.abs(b.angle).max())
    design = np.zeros((len(b.angle), 2 + len(b.loading)))
    design[np.arange(len(design)), np.where(b.up, 0, 1)] = b.angle / scale
    design[np.arange(len(design)), 2 + b.of] = 1.0
    numbers, _, rank, _ = np.linalg.lstsq(design, b.torque, rcond=None)
    variance = float(np.sum((b.torque - design @ numbers) ** 2)) / (len(design) - int(rank))
    unit = np.r_[1 / scale, 1 / scale, np.ones(len(b.loading))]
    covariance = variance * np.linalg.pinv(design.T @ design, hermitian=True) * np.outer(unit, unit)
    found: Floats = np.asarray(numbers * unit, dtype=np.float64)
    return found[:2], found[2:], np.asarray(covariance, dtype=np.float64), float(np.sqrt(variance))


def _slope(b: Branches, line: int) -> float:
    mine = b.of == line
    off = b.angle[mine] - b.angle[mine].mean()
    return float(off @ b.torque[mine] / (off @ off))


def _between(numbers: list[float]) -> float:
    """Standard deviation of the mean over load cycles, from three cycles on; 0 for fewer."""
    return float(np.std(numbers, ddof=1) / np.sqrt(len(numbers))) if len(numbers) >= 3 else 0.0


def _gap(b: Branches, zero: Floats, covariance: Floats) -> tuple[float | None, float | None, bool]:
    """Gap, its standard deviation, and whether friction is in it: mean over the load cycles with both sides."""
    weights, friction = [], False
    for repeat in np.unique(b.repeat):
        sides = [np.flatnonzero((b.repeat == repeat) & (b.sign == s)) for s in (1, -1)]
        both = all(len(lines) == 2 for lines in sides)
        chosen = [lines[both | b.loading[lines]] for lines in sides]
        if not all(len(lines) for lines in chosen):
            continue
        weight = np.zeros(len(zero))
        for s, lines in zip((1, -1), chosen, strict=True):
            weight[lines] = s / len(lines)
        weights.append(weight)
        friction |= not both
    if not weights:
        return None, None, False
    gaps = [float(weight @ zero) for weight in weights]
    mean = np.mean(weights, axis=0)
    return float(np.mean(gaps)), max(float(np.sqrt(mean @ covariance @ mean)), _between(gaps)), friction


def _hysteresis(b: Branches, zero: Floats) -> float | None:
    """Width of the loop at zero torque: between the unloading branches of the two sides."""
    back = [zero[(b.sign == s) & ~b.loading] for s in (1, -1)]
    if not all(len(angles) for angles in back):
        return None
    return float(back[0].mean() - back[1].mean())


def clamped_model(
    robot: Robot, named: str, fits: tuple[JointFit, ...], provenance: dict[str, object]
) -> ComplianceModel:
    """The fits as a model of ``robot``; joints without readings are not identified."""
    base, play = joint_stiffness.EFFECT.name, backlash.EFFECT.name
    start = joint_stiffness.EFFECT.parameters[0].start
    stiffness, sd, known = np.full(robot.n, start), np.full(robot.n, start), np.zeros(robot.n, dtype=bool)
    gap, gap_sd = np.zeros(robot.n), np.full(robot.n, _UNKNOWN_GAP)
    for f in fits:
        stiffness[f.joint], sd[f.joint], known[f.joint] = f.stiffness, f.sd, True
        if f.gap is not None and f.gap_sd is not None:
            gap[f.joint], gap_sd[f.joint] = max(f.gap, 0.0), f.gap_sd
    values = {base: joint_stiffness.values_of(stiffness)}
    deviations = {base: joint_stiffness.values_of(sd)}
    if any(f.gap is not None for f in fits):
        values[play] = backlash.values_of(gap)
        deviations[play] = {"gap_rad": gap_sd}
    return ComplianceModel(
        source="",
        robot=named,
        gravity="uncompensated",
        reference_temperature=20.0,
        base=robot.base,
        tip=robot.tip,
        values=values,
        sd=deviations,
        identified={} if known.all() else {base: known},
        provenance={"kind": "static", "method": "clamped", **provenance},
    )
