"""What each assumption about a path is worth: how far the predicted TCP moves when it is another way.

Every alternative is predicted on the nominal path, uncompensated, at POSES poses of it: what is assumed wrongly is left
on the part by that much.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import numpy.typing as npt

from compensator.cell.arm import Arm
from compensator.cell.job import Job, job_of
from compensator.cell.placement import Placement
from compensator.path.planned_path import PlannedPath
from compensator.path.tool_set import ToolSet
from compensator.solve.compensation import Compensation
from compensator.solve.joint_state import equilibrium_along, spread_of_unknown
from compensator.solve.touching_off import touched_off
from compensator.solve.worth_of_cut import cut_worths
from stiffness.effects import BASE
from stiffness.effects.effect import Numbers
from stiffness.model.model import ComplianceModel
from toolpaths.finding import NOTE, WARNING, Finding
from toolpaths.toolpath import CUT

Floats = npt.NDArray[np.float64]

POSES = 300
SHARE = 0.1  # of the wrench, and of a stiffness without standard deviation: what a tenth is worth
SOFTEST = 0.1  # of a stiffness: a standard deviation as large as the value leaves that much
TOOL_MASS = 10.0  # kg
WARMER = 5.0  # K
NOTHING = 1e-8  # m: an assumption that moves the TCP by less does not matter to this path


@dataclass(frozen=True)
class Worth:
    """An assumption; ``size``: m, largest move of the predicted TCP over the cutting poses."""

    finding: Finding
    size: float


def worths(c: Compensation) -> tuple[Worth, ...]:
    """What is assumed, or not known, of an uncompensated path; the largest first."""
    at = _Thinned.of(c)
    found = [*_stiffness(at), *_sag(at), *_touching(at), *_wrench(at), *_weight(at), *_warmth(at)]
    cut = cut_worths(c, at.rows, lambda wrench: at.off(_seen(at.job, at.path, wrench)))
    found += [Worth(finding, size) for finding, size in cut]
    found += _start(c, at.source)
    return tuple(sorted((w for w in found if w.size > NOTHING), key=lambda w: -w.size))


@dataclass(frozen=True, eq=False)
class _Thinned:
    """Some poses of a path, with their wrench, and where the TCP is predicted there."""

    job: Job
    rows: npt.NDArray[np.intp]
    path: PlannedPath
    wrench: Floats
    seen: Floats

    @classmethod
    def of(cls, c: Compensation) -> _Thinned:
        plain = c.uncompensated
        rows = np.unique(np.linspace(0, len(plain) - 1, min(POSES, len(plain))).round().astype(np.intp))
        p = plain.path
        q, turn, branch = p.q[rows], p.turn[rows], p.branch[rows]
        path = PlannedPath(toolpath=p.toolpath.take(rows), tcp=p.tcp.take(rows), q=q, turn=turn, branch=branch)
        wrench = plain.wrench[rows]
        job = replace(plain.job, arm=replace(plain.job.arm, taken_off=None))
        return cls(job, rows, path, wrench=wrench, seen=_seen(job, path, wrench))

    @property
    def source(self) -> str:
        return self.job.placement.source

    def moved(self, *, model: ComplianceModel | None = None, placement: Placement | None = None) -> float:
        """m, by which the TCP moves at most where it cuts, with another model or another placement."""
        arm = self.job.arm
        other = Arm(arm.robot, arm.inverse, model or arm.model)
        job = job_of(other, placement or self.job.placement)
        return self.off(_seen(job, self.path, self.wrench))

    def off(self, seen: Floats) -> float:
        """m, largest distance from what is predicted."""
        cut = self.path.toolpath.kind == CUT
        return float(np.linalg.norm(seen - self.seen, axis=1)[cut].max(initial=0.0))


def _seen(job: Job, path: PlannedPath, wrench: Floats) -> Floats:
    job = touched_off(job, path)
    found, _ = equilibrium_along(job.arm, job.placement.start, path.toolpath, q=path.q, wrench=wrench)
    return found.position


def _stiffness(at: _Thinned) -> Iterator[Worth]:
    """Every joint softer by its standard deviation; by a tenth, all of them, where the model gives none."""
    model = at.job.arm.model
    k = model.values[BASE.name]["k_nm_per_rad"]
    sd = model.sd.get(BASE.name, {}).get("k_nm_per_rad")
    if sd is None:
        size = at.moved(model=_with_stiffness(model, k * (1 - SHARE)))
        what = f"no standard deviations of the stiffness: every {SHARE:.0%} that all joints are softer than given"
        yield Worth(_finding(NOTE, model.source, what, "Measure it: compensator plan, identify", kind="model"), size)
        return
    sizes = []
    for j in range(len(k)):
        softer = k.copy()
        softer[j] = max(k[j] - sd[j], SOFTEST * k[j])
        sizes.append(at.moved(model=_with_stiffness(model, softer)) if sd[j] > 0 else 0.0)
        share = sd[j] / k[j]
        what = f"joint {j + 1}: stiffness {k[j]:.3g} N*m/rad, standard deviation {share:.0%}"
        if sizes[-1] > 0:
            found = _finding(NOTE, model.source, what, kind="model")
            yield Worth(found, sizes[-1])
    whole = float(np.linalg.norm(sizes))
    level = WARNING if whole > at.job.placement.sampling.chord / 1e3 else NOTE
    what = "stiffness of all joints, each softer by its standard deviation (root of the sum of squares)"
    yield Worth(_finding(level, model.source, what, "Measure it: compensator plan, identify", kind="model"), whole)


def _with_stiffness(model: ComplianceModel, k: Floats) -> ComplianceModel:
    base: Mapping[str, Numbers] = {**model.values, BASE.name: {**model.values[BASE.name], "k_nm_per_rad": k}}
    return replace(model, values=base)


def _sag(at: _Thinned) -> Iterator[Worth]:
    """Whether the controller knows the sag of arm and tool: the other way round."""
    placement, robot = at.job.placement, at.job.arm.robot
    now = placement.conditions.sag or at.job.arm.model.gravity
    other: Literal["uncompensated", "calibrated-out"] = "calibrated-out"
    if now == other:
        other = "uncompensated"
    if robot.mass is None:
        return
    size = at.moved(placement=replace(placement, conditions=replace(placement.conditions, sag=other)))
    what = f"gravity = {now!r}; were it {other!r}"
    remedy = "Ask whether the controller's absolute accuracy or load model is on, and set gravity and [controller]"
    level = NOTE if placement.conditions.sag else WARNING
    yield Worth(_finding(level, f"{at.source}: gravity", what, remedy), size)


def _touching(at: _Thinned) -> Iterator[Worth]:
    """A work object that was touched off, where the cell does not tell."""
    placement = at.job.placement
    if placement.touches is not None:
        return
    cut = np.flatnonzero(at.path.toolpath.kind == CUT)
    point = at.path.toolpath.position[cut[len(cut) // 2]]
    size = at.moved(placement=replace(placement, touches=(point,)))
    what = "how the work object was found is not given; had this tool touched it off in the middle of the path"
    remedy = "Give [workobject] touched_off, the points in mm; [] where it was measured otherwise"
    yield Worth(_finding(NOTE, f"{at.source}: workobject", what, remedy), size)


def _start(c: Compensation, source: str) -> Iterator[Worth]:
    """Where the path starts from decides the first flanks: between the lowest and the highest state, at every pose."""
    if c.job.placement.start is not None:
        return
    plain = c.uncompensated
    toolpath = plain.path.toolpath
    spread = spread_of_unknown(plain.job.arm, toolpath, q=plain.path.q, wrench=plain.wrench, state=plain.state)
    what = "where the arm starts from is not known, so neither on which flank its joints rest at first"
    found = _finding(NOTE, f"{source}: start", what, "Give [start] joints, deg, or a longer approach")
    yield Worth(found, float(spread[plain.cutting].max(initial=0.0)))


def _wrench(at: _Thinned) -> Iterator[Worth]:
    """A tenth of the process."""
    size = at.off(_seen(at.job, at.path, at.wrench * (1 + SHARE)))
    what = f"the wrench of the process: every {SHARE:.0%} of it"
    remedy = "Compare it with measured or computed cutting forces"
    yield Worth(_finding(NOTE, f"{at.source}: process", what, remedy, kind="process"), size)


def _weight(at: _Thinned) -> Iterator[Worth]:
    """A tool whose mass is not given."""
    placement = at.job.placement
    bare = {n: t for n, t in placement.tools.by_number.items() if not t.mass}
    if not bare or at.job.arm.robot.mass is None:
        return
    heavy = {n: replace(t, mass=TOOL_MASS, com=t.position / 2) for n, t in bare.items()}
    tools = ToolSet({**placement.tools.by_number, **heavy}, any_number=placement.tools.any_number)
    size = at.moved(placement=replace(placement, tools=tools))
    names = ", ".join(t.name for t in bare.values())
    what = f"no mass given: every {TOOL_MASS:g} kg, half way to the TCP"
    yield Worth(_finding(NOTE, f"tool {names}", what, "Give mass and com of the tool"), size)


def _warmth(at: _Thinned) -> Iterator[Worth]:
    """Temperature, where the model has something that follows it."""
    conditions = at.job.placement.conditions
    if conditions.temperature is not None or not any(e.thermal for e in at.job.arm.effects):
        return
    warm = replace(conditions, temperature=at.job.arm.model.reference_temperature + WARMER)
    size = at.moved(placement=replace(at.job.placement, conditions=warm))
    what = f"the temperature while cutting is not given: every {WARMER:g} K from that of the model"
    yield Worth(_finding(NOTE, f"{at.source}: temperature", what, "Give temperature, deg C"), size)


def _finding(level: str, place: str, what: str, remedy: str = "", kind: str = "cell") -> Finding:
    return Finding(level, place, what, remedy, kind=kind)
