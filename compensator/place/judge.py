"""Judge: what one placement is worth. The best of its turns and arm configurations stands for it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from compensator.cell.job import Job, job_of
from compensator.path.joint_motion import joint_motion
from compensator.path.motion_bounds import MotionBounds
from compensator.place.postures import PlacedPostures, placed_postures
from compensator.place.study import Study, in_axes
from compensator.scene.collider import Collider
from compensator.scene.pairs import pairs_of
from compensator.solve.joint_state import equilibrium_along
from compensator.solve.motion_limits import feeds, share_of_limits
from compensator.turn.reliance import ToolReliance
from stiffness.memory.last_direction import last_direction
from toolpaths.frame import Frame
from toolpaths.toolpath import CUT, RAPID

Floats = npt.NDArray[np.float64]
MM = 1e3

GOOD, COLLIDES, BEYOND, OUT = "good", "collides", "beyond-limits", "out-of-reach"
MOST = 12  # usable choices whose deflection is compared, those with the most room first, until one of them is free
PUSH = 100.0  # N along the normal: small against the load, large against rounding
REVERSAL = 1e-6  # m in the score, for every reversal in a metre of cut
HURRY = 1e-3  # m in the score, for every whole share of a joint's speed limit beyond the limit


@dataclass(frozen=True)
class Judgement:
    """One row of a study: mm, deg, N; NaN where it was not judged.

    Attributes:
        status: GOOD, COLLIDES, BEYOND (limits or a singularity) or OUT (of reach).
        reached: largest share of the poses that one turn and configuration reach.
        choices: turns and configurations that the arm can take.
        collision: the bodies that touch.
        turn_deg, branch: of the one chosen. start_deg: its first posture, six numbers.
        margin: to limits and singularities, comparable only.
        deflection_*: at the cutting poses; sd_mm: mean of its standard deviation.
        reversals_per_m: of joints, per metre of cut. speed_share: largest share of a limit of speed or acceleration.
        stiffness_n_per_um: least at the cutting poses, across feed and tool axis.
        score_mm: smaller is better.
    """

    status: str
    reached: float
    choices: int
    collision: str = ""
    turn_deg: float = np.nan
    branch: int = -1
    start_deg: tuple[float, ...] = (np.nan,) * 6
    margin: float = np.nan
    deflection_mean_mm: float = np.nan
    deflection_p95_mm: float = np.nan
    sd_mm: float = np.nan
    reversals_per_m: float = np.nan
    speed_share: float = np.nan
    stiffness_n_per_um: float = np.nan
    score_mm: float = np.nan


NUMBERS = tuple(f.name for f in fields(Judgement) if f.name not in ("status", "collision", "start_deg"))


class Judge:
    """Judges the placements of one study; made once in every process.

    Args:
        study: as it was sent.
    """

    def __init__(self, study: Study) -> None:
        self.study = study
        self.cut = study.path.kind == CUT

    def __repr__(self) -> str:
        return f"Judge({self.study!r})"

    @cached_property
    def job(self) -> Job:
        """The arm at the place of the cell."""
        return job_of(self.study.arm, self.study.placement)

    @cached_property
    def collider(self) -> Collider | None:
        """None: the cell asks for no check."""
        around, robot = self.study.placement.surroundings, self.job.arm.robot
        if not around.settings.check:
            return None
        pairs = pairs_of(self.study.bodies, robot, around.settings, self.study.placement.source)
        return Collider(robot, self.study.bodies, pairs)

    @cached_property
    def reliance(self) -> dict[int, ToolReliance]:
        """Number of the tool -> what a compensation with it relies on."""
        arm = self.job.arm
        return {number: ToolReliance.of(arm, predictor) for number, predictor in arm.predictors.items()}

    def row(self, k: int) -> Judgement:
        """The judgement of a candidate."""
        work = self.study.candidates.frame(k)
        planner = self.job.planner
        bounds: MotionBounds = planner.bounds
        found = placed_postures(self.study, planner.inverse, bounds, work)
        reached = float(found.reached.max(initial=0.0))
        usable = found.usable
        if not len(usable):
            return Judgement(BEYOND if found.reachable else OUT, reached, 0)
        words = ""
        for some in with_most_room(usable, found.margin[usable]):
            if words:  # where those with more room touch, most others do: the look costs less than the deflection
                some = np.array([c for c in some if not self._touching(found.q[c], work)], dtype=np.intp)
            sd = np.array([self._relied_on(found.q[c], self._wrench(found, c, work), found.origin) for c in some])
            for k in np.argsort(sd, kind="stable").tolist():
                touching = self._touching(found.q[some[k]], work)
                if not touching:
                    return self._judged(found, int(some[k]), work, seen=(reached, len(usable)), sd=float(sd[k]))
                words = words or touching
        return Judgement(COLLIDES, reached, len(usable), words)

    def _wrench(self, found: PlacedPostures, choice: int, work: Frame) -> Floats:
        """(P, 6) base axes."""
        axes = self.study.axes
        if axes == "base":
            return self.study.wrench
        return in_axes(self.study.wrench, found.rotation[choice] if axes == "tool" else work.rotation[None])

    def _relied_on(self, q: Floats, wrench: Floats, origin: Floats) -> float:
        """m: mean standard deviation of the deflection at the cutting poses."""
        sd = np.empty(len(q))
        for number, rows in self.job.arm.tools.rows(self.study.path):
            sd[rows] = self.reliance[number].of_postures(q[rows], wrench[rows], origin[rows])[1]
        return float(sd[self.cut].mean())

    def _touching(self, q: Floats, work: Frame) -> str:
        """Names of two bodies that touch somewhere; empty: none do."""
        if self.collider is None:
            return ""
        for number, rows in self.job.arm.tools.rows(self.study.path):
            tool = None if self.job.arm.tools.any_number else number
            for cutting in (True, False):
                mine = np.zeros(len(q), dtype=np.bool_)
                mine[rows] = True
                mine &= self.cut == cutting
                pair = self.collider.first_touching(q[mine], workobject=work, tool=tool, cutting=cutting)
                if pair is not None:
                    return " and ".join(pair)
        return ""

    def _judged(
        self, found: PlacedPostures, choice: int, work: Frame, *, seen: tuple[float, int], sd: float
    ) -> Judgement:
        arm, q, cut = self.job.arm, found.q[choice], self.cut
        path, wrench = self.study.path, self._wrench(found, choice, work)
        before, state = equilibrium_along(arm, None, path, q=q, wrench=wrench)
        size = np.linalg.norm(before.position - found.origin, axis=1)[cut]
        default = self.job.placement.program.default_feed / 60e3
        rows = np.where(self.study.begins, RAPID, path.kind).astype(path.kind.dtype)  # no move leads from row to row
        path = replace(path, kind=rows)
        motion = joint_motion(path, q, feeds(path, default))
        speed = float(share_of_limits(arm.robot, motion).max())
        reversals = self._reversals(q)
        score = sd + REVERSAL * reversals + HURRY * max(speed - 1.0, 0.0)
        return Judgement(
            GOOD, *seen, turn_deg=float(np.degrees(found.turn[choice])), branch=int(found.branch[choice]),
            start_deg=tuple(np.degrees(q[0]).tolist()), margin=float(found.margin[choice]),
            deflection_mean_mm=float(size.mean()) * MM, deflection_p95_mm=float(np.percentile(size, 95)) * MM,
            sd_mm=sd * MM, reversals_per_m=reversals, speed_share=speed,
            stiffness_n_per_um=self._stiffness(q, wrench, state.middle, found.rotation[choice]),
            score_mm=float(score) * MM,
        )  # fmt: skip

    def _reversals(self, q: Floats) -> float:
        """Of all joints, per metre of cut."""
        step = np.diff(q, axis=0, prepend=q[:1])
        counts = self.cut & ~self.study.begins
        step[~counts] = 0.0
        turned = last_direction(step)
        found = (turned[1:] * turned[:-1] < 0) & counts[1:, None] & ~np.roll(self.study.begins, 1)[1:, None]
        position = self.study.path.position
        way = np.linalg.norm(np.diff(position, axis=0, prepend=position[:1]), axis=1)[counts].sum()
        return float(found.sum() / max(way, 1e-9))

    def _stiffness(self, q: Floats, wrench: Floats, state: Floats, rotation: Floats) -> float:
        """N/um: the least at the cutting poses, along the normal: across the feed and the tool axis."""
        arm, path = self.job.arm, self.study.path
        way = np.diff(arm.nominal(path, q), axis=0)
        way = np.concatenate([way, way[-1:]])
        normal = np.cross(rotation[:, :, 2], way)
        length = np.linalg.norm(normal, axis=1)
        normal = np.where((length > 1e-9)[:, None], normal / np.maximum(length, 1e-9)[:, None], rotation[:, :, 1])
        push = wrench + np.concatenate([PUSH * normal, np.zeros_like(normal)], axis=1)
        moved = arm.forward(path, q, push, state).position - arm.forward(path, q, wrench, state).position
        yielded = np.sum(moved * normal, axis=1)[self.cut]
        return float(PUSH / np.maximum(yielded, 1e-12).max() * 1e-6)


def with_most_room(usable: npt.NDArray[np.intp], margin: Floats) -> Iterator[npt.NDArray[np.intp]]:
    """MOST choices at a time, those with the most room first, and with them what has as much room as the last."""
    order = np.argsort(-margin, kind="stable")
    begin = 0
    while begin < len(order):
        last = margin[order[min(begin + MOST, len(order)) - 1]]
        end = int(np.sum(margin >= last))
        yield usable[order[begin:end]]
        begin = end
