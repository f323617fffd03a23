"""Which ball-bar circles tell the lost motion of every joint: one centre, as few circles as do, both directions.

A circle is good for a joint that turns round in it, with a lever along the bar, far from where the others turn round.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from compensator.cell.job import Job
from compensator.errors import PathError
from compensator.trials.begin import beginning_at
from compensator.trials.circle import PLANES, CircleShape
from compensator.trials.trial_path import TrialMoves, frames, joined, moves, toolpath_of
from stiffness.planning.lever import tcp_levers
from stiffness.planning.reversals import Reversal, gap_sd, reversals, sides

Floats = npt.NDArray[np.float64]

LEVER = 0.02  # m/rad: a gap of 0.1 mrad, small for a robot, steps by 2 um there, what a ball-bar resolves
APART = np.radians(10.0)  # between reversals of two joints: a step, and where friction turns round after it
FROM_END = np.radians(5.0)  # of an arc
NOISE = 1e-6  # m, of a ball-bar reading
MOST = 4  # circles
COARSE, STEP = np.radians(3.0), np.radians(1.0)
TILTS = tuple(np.radians(t) for t in ((0, 0), (25, 0), (-25, 0), (0, 25), (0, -25)))
FEW = 3  # centres, where a circle takes long to follow
SPREAD = 0.3  # m from the work object's zero to the centres that are tried
TURNS = 12
CLEAR = 0.1  # m above a circle
FEEDS = (500.0, 2000.0)  # mm/min: two tell servo lag from play


@dataclass(frozen=True, repr=False)
class Circle:
    """A circle that the arm can run.

    Attributes:
        shape: of it. q: (N, n) rad, one way. angle: (N,) rad. lever: (N, n) m/rad along the bar, outward.
        data: (N,) whether readings count there. turns: reversals among them. branch: arm configuration.
    """

    shape: CircleShape
    q: Floats
    angle: Floats
    lever: Floats
    data: npt.NDArray[np.bool_]
    turns: tuple[Reversal, ...]
    branch: int

    def best(self, joint: int) -> Reversal | None:
        """The reversal that tells most of a joint, if one does."""
        good = [r for r in self.turns if r.joint == joint and abs(r.lever) >= LEVER and r.apart >= APART]
        return max(good, key=lambda r: abs(r.lever) * min(1.0, r.apart / (2 * APART)), default=None)

    @property
    def gap_rows(self) -> Floats:
        """(2M, n) m by gap of every joint: there, and back."""
        there = -sides(self.q) * self.lever / 2
        back = -sides(self.q[::-1])[::-1] * self.lever / 2
        return np.vstack([there[self.data], back[self.data]])


@dataclass(frozen=True, repr=False)
class BallbarPlan:
    """Circles about one centre.

    Attributes:
        center: (3,) m, work object. radius: m. circles: in the order of the program. tried: circles of all centres, and
            how many of them the arm can run.
        sd: (n,) rad of the gap of each joint with NOISE; inf: not determined.
    """

    center: Floats
    radius: float
    circles: tuple[Circle, ...]
    sd: Floats
    tried: tuple[int, int]

    def told(self, joint: int) -> tuple[int, Reversal] | None:
        """Number of the circle, from 0, and the reversal that tell a joint best."""
        found = [(k, r) for k, c in enumerate(self.circles) if (r := c.best(joint)) is not None]
        return max(found, key=lambda f: abs(f[1].lever), default=None)

    def why_not(self, joint: int) -> str:
        """Why no circle tells a joint."""
        levers = max(float(np.max(np.abs(c.lever[:, joint]))) for c in self.circles)
        if levers < LEVER:
            return f"the TCP moves {levers * 1e3:.1f} um per mrad of it along the bar at most: it lies near its axis"
        turns = [r for c in self.circles for r in c.turns if r.joint == joint]
        if not turns:
            return "it does not turn round in them"
        best = max(turns, key=lambda r: (abs(r.lever) >= LEVER, r.apart))
        if abs(best.lever) < LEVER:
            return f"where it turns round it moves the bar by {abs(best.lever) * 1e3:.1f} um per mrad only"
        return f"it turns round {np.degrees(best.apart):.1f} deg from another joint, expected {np.degrees(APART):g}"


def ballbar_plan(job: Job, radius: float, center: Floats | None) -> BallbarPlan:
    """The best circles of a cell.

    Args:
        radius: m. center: (3,) m, work object; None: chosen near its zero.

    Raises:
        PathError: the arm runs none of them; the reason of the first.
    """
    best: tuple[tuple[float, ...], Floats, list[Circle]] | None = None
    first: PathError | None = None
    tried = ran = 0
    quick = job.planner.inverse.labelled  # without a closed form a circle takes a second
    for at in list(_centres(radius))[: None if quick else FEW] if center is None else [center]:
        circles = []
        turn, posture = _turn(job, at)
        planner = job.planner if quick or posture is None else beginning_at(job.planner, posture)
        for shape in _shapes(turn):
            tried += 1
            try:
                circles.append(_circle(replace(job, planner=planner), at, radius, shape))
            except PathError as e:
                first = first or e
        ran += len(circles)
        chosen = _cover(circles, job.arm.robot.n)
        score = _score(chosen, job.arm.robot.n)
        if chosen and (best is None or score > best[0]):
            best = (score, at, chosen)
        if not quick and score[0] >= _visible(circles):
            break
    if best is None:
        where = "give --center X Y Z (mm, base) where the arm reaches all around, a smaller --radius, or another [tool]"
        raise PathError(f"none of {tried} circles of radius {radius * 1e3:g} mm can be run: {first}; {where}")
    _, at, chosen = best
    rows = [c.gap_rows for c in chosen]
    bars = [np.tile(c.shape.outward(c.angle[c.data]), (2, 1)) for c in chosen]
    beside = [np.hstack([u, np.ones((len(u), 1))]) for u in bars]
    return BallbarPlan(
        center=at, radius=radius, circles=tuple(chosen), sd=gap_sd(rows, beside, NOISE), tried=(tried, ran)
    )


def _centres(radius: float) -> Iterator[Floats]:
    """(3,) m in the work object: its zero first, then around it, then higher."""
    for z in (radius, radius + SPREAD):
        for x, y in ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)):
            yield np.array([x * SPREAD, y * SPREAD, z])


def _shapes(turn: float) -> Iterator[CircleShape]:
    for tilt in TILTS:
        for plane in PLANES:
            yield CircleShape(plane, (float(tilt[0]), float(tilt[1])), turn)


def _turn(job: Job, center: Floats) -> tuple[float, Floats | None]:
    """rad about the tool axis that leaves most room at the centre to limits and singularities, and the posture."""
    planner, most = job.planner, -np.inf
    best: tuple[float, Floats | None] = (0.0, None)
    for turn in np.arange(TURNS) * 2 * np.pi / TURNS:
        shape = CircleShape("XY", turn=float(turn))
        pose = toolpath_of(moves(center[None], shape.quaternion, 0.01), "")
        tcp = planner.workobject.then(frames(pose))
        postures = planner.inverse.postures(pose, tcp, limits=True)
        if not postures:
            continue
        q = np.array([posture for _, posture in postures])
        margin = planner.bounds.margin(q)
        if float(margin.max()) > most:
            most, best = float(margin.max()), (float(turn), q[int(np.argmax(margin))])
    return best


def _circle(job: Job, center: Floats, radius: float, shape: CircleShape) -> Circle:
    angle = shape.angles(COARSE if job.planner.inverse.labelled else 2 * COARSE)
    outward = shape.outward(angle)
    path = job.planner.plan(toolpath_of(moves(center + radius * outward, shape.quaternion, 0.01), "circle"))
    levers = tcp_levers(job.arm.robot, job.placement.tools.first, path.q)
    lever = np.einsum("nja,na->nj", levers, outward @ job.placement.workobject.rotation.T)
    begin, end = shape.arc
    data = (angle >= begin - 1e-9) & (angle <= end + 1e-9)
    from_end = FROM_END if shape.standing else 0.0
    turns = [r for r in reversals(angle, path.q, lever) if begin + from_end <= r.along <= end - from_end]
    return Circle(
        shape=shape,
        q=path.q,
        angle=angle,
        lever=lever,
        data=data,
        turns=tuple(turns),
        branch=int(path.branch[0]) if job.planner.inverse.labelled else 0,
    )


def _cover(circles: Sequence[Circle], joints: int) -> list[Circle]:
    """As few circles of one arm configuration as tell all joints that can be told."""
    best: list[Circle] = []
    for branch in dict.fromkeys(c.branch for c in circles):
        pool, chosen = [c for c in circles if c.branch == branch], list[Circle]()
        left = set(range(joints))
        while len(chosen) < MOST:
            gains = [sum(1.0 + min(abs(r.lever), 1.0) for j in left if (r := c.best(j))) for c in pool]
            if not gains or max(gains) == 0:
                break
            chosen.append(pool[int(np.argmax(gains))])
            left -= {j for j in left if chosen[-1].best(j)}
        if _score(chosen, joints) > _score(best, joints):
            best = chosen
    return best


def _score(circles: Sequence[Circle], joints: int) -> tuple[float, ...]:
    """The larger the better: joints told, few circles, long levers."""
    best = [max((abs(r.lever) for c in circles if (r := c.best(j))), default=0.0) for j in range(joints)]
    return float(np.count_nonzero(best)), -float(len(circles)), float(np.sum(np.log(np.maximum(best, LEVER))))


def _visible(circles: Sequence[Circle]) -> float:
    """How many joints move the bar at all; inf: no circle can be run."""
    if not circles:
        return np.inf
    return float(np.count_nonzero(np.max([np.abs(c.lever).max(axis=0) for c in circles], axis=0) >= LEVER))


def ballbar_moves(plan: BallbarPlan, feeds: Sequence[float]) -> TrialMoves:
    """The whole program: every circle there and back with each feed (mm/min), and the ways between them."""
    parts: list[TrialMoves] = []
    for number, circle in enumerate(plan.circles, 1):
        shape = circle.shape
        angle = shape.angles(STEP)
        place = plan.center + plan.radius * shape.outward(angle)
        above = place[[0]] + [0.0, 0.0, CLEAR]
        parts.append(moves(above, shape.quaternion, np.nan))
        parts.append(moves(place[[0]], shape.quaternion, feeds[0] / 6e4))
        begin, end = shape.arc
        data = (angle >= begin - 1e-9) & (angle <= end + 1e-9)
        for lap, feed in enumerate(feeds):
            for way in (1, -1):
                first = lap == 0 and way == 1
                run = moves(
                    place[::way],
                    shape.quaternion,
                    feed / 6e4,
                    read=data[::way],
                    wait=f"mount the ball-bar, circle {number}" if first else "",
                    circle=float(number),
                    angle=np.degrees(angle)[::way],
                    direction=float(way),
                )
                parts.append(run.after_first())
        parts.append(moves(above, shape.quaternion, feeds[0] / 6e4, wait="take the ball-bar off"))
    return joined(parts)
