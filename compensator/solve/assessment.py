"""Assessment: what is judged about a result beside its commands, and what all stages of its run found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from compensator.path.pose_text import place
from compensator.path.tool_direction import ToolDirection, tool_direction
from compensator.scene.bodies import Bodies, bodies_of
from compensator.scene.path_collisions import PathCollisions, collisions_along
from compensator.solve.added_acceleration import AddedAcceleration, added_acceleration
from compensator.solve.compensation import Compensation, ShareSizes
from compensator.solve.joint_state import spread_of_unknown
from compensator.solve.motion_limits import MotionCheck, lowered_findings, motion_check
from compensator.solve.share_sizes import share_sizes
from compensator.solve.turnarounds import Turnaround, reversals, sign_changes
from compensator.solve.uncertainty import ErrorBand, error_band
from compensator.solve.unlearned_angles import OpenAngles, open_angles
from stiffness.numerics.beside import Beside, beside
from toolpaths.finding import NOTE, WARNING, Finding, merged, of_kind

Floats = npt.NDArray[np.float64]

MATTERS = 0.1  # of the deflection: a share of the weight above it is asked about


@dataclass(frozen=True, repr=False)
class Assessment:
    """What is judged about a result.

    Attributes:
        result: the commands.
        open: angles that the model did not learn.
        spread: (M,) m at each cutting pose: how far the unknown flanks leave the TCP open.
        share_sizes: of the causes of the uncompensated deflection.
        direction: of the tool.
        band: how sure the uncompensated error is; None: not known.
        motion: of the joints at the feeds of the cuts.
        added: what the corrections add to their accelerations; None: nothing is corrected.
        collisions: along the path.
        reversals: where joints turn around. sign_changes: where the torque of gravity and process on one changes sign.
        findings: of all stages, repeats merged, the worst level first.
    """

    result: Compensation
    open: OpenAngles
    spread: Floats
    share_sizes: ShareSizes
    direction: ToolDirection
    band: ErrorBand | None
    motion: MotionCheck
    added: AddedAcceleration | None
    collisions: PathCollisions
    reversals: Sequence[Turnaround]
    sign_changes: Sequence[Turnaround]
    findings: tuple[Finding, ...]

    def __repr__(self) -> str:
        return f"Assessment({len(self.findings)} findings)"

    @property
    def shares(self) -> Mapping[str, Floats]:
        """Cause -> (K, 3) m at each cutting pose of the uncompensated path, base axes, made anew; they add up."""
        plain = self.result.uncompensated
        rows = np.flatnonzero(plain.cutting)
        return plain.job.arm.shares(plain.path.toolpath, plain.path.q, plain.wrench, seen=plain.before, at=rows)


def assessed(c: Compensation, written: Sequence[Finding] = (), *, corrected: bool = True) -> Assessment:
    """Judge a result.

    Args:
        written: what the writer of its program found.
        corrected: False where the nominal path is commanded.
    """
    return with_findings(judged(c, corrected=corrected), written)


def assessed_beside(c: Compensation) -> AbstractContextManager[Beside[Assessment]]:
    """A result is judged by another process, while this one writes and verifies; without the findings."""
    bodies = bodies_of(c.job)  # here: it reads files, which this process takes down
    return beside(lambda: judged(c, bodies), known=(c, bodies), poses=len(c))


def judged(c: Compensation, bodies: Bodies | None = None, *, corrected: bool = True) -> Assessment:
    """As ``assessed``, without the findings; ``bodies`` of the job, None: they are read."""
    arm, cut, plain = c.job.arm, c.cutting, c.uncompensated
    spread = spread_of_unknown(arm, c.path.toolpath, q=c.command.q, wrench=c.wrench, state=c.state)[cut]
    q = c.command.q if corrected else c.path.q
    return Assessment(
        result=c,
        open=open_angles(c, q),
        spread=spread,
        share_sizes=share_sizes(c),
        direction=tool_direction(plain.path, c.job.placement.conditions.gravity),
        band=error_band(plain),
        motion=motion_check(arm.robot, c.path.toolpath, q, c.job.placement.program.default_feed / 60e3),
        added=added_acceleration(c) if corrected else None,
        collisions=collisions_along(c.job, c.path.toolpath, q, bodies),
        reversals=reversals(c, q),
        sign_changes=sign_changes(c),
        findings=(),
    )


def with_findings(a: Assessment, written: Sequence[Finding] = ()) -> Assessment:
    """With what all stages found; ``written``: the writer of the program."""
    c, added = a.result, a.added
    plain = c.uncompensated
    findings = merged((
        *of_kind("toolpath", plain.path.toolpath.findings),
        *of_kind("cell", (*c.job.findings, *_asks_where_touched_off(c, a.share_sizes))),
        *of_kind("path", () if c.path.axes is None else c.path.axes.findings),
        *of_kind("path", () if c.path.chosen is None else c.path.chosen.findings),
        *of_kind("path", (*a.direction.findings, *a.motion.findings(c.path.toolpath), *lowered_findings(c.path))),
        *of_kind("path", added.findings(c) if added else ()),
        *of_kind("process", c.load.findings),
        *of_kind("collision", a.collisions.findings),
        *of_kind("solve", _unknown_flanks(c, a.spread)),
        *of_kind("model", a.open.findings),
        *of_kind("program", written),
    ))
    return replace(a, findings=findings)


def _unknown_flanks(c: Compensation, spread: Floats) -> list[Finding]:
    """A warning where unknown flanks leave more open than an arc of the toolpath may be off, else a note."""
    open_ = np.flatnonzero(spread > 0)
    if not len(open_):
        return []
    largest = float(spread.max())
    level = WARNING if largest > c.job.placement.sampling.chord / 1e3 else NOTE
    what = (
        f"on which flank every joint rests is not known at {len(open_):,} cutting poses: up to {largest * 1e3:.3f} mm "
        "at the TCP, from one extreme to the other"
    )
    first = place(c.path.toolpath, int(np.flatnonzero(c.cutting)[open_[0]]))
    return [Finding(level, first, what, "Give [start] joints or a longer approach", count=len(open_))]


def _asks_where_touched_off(c: Compensation, shares: ShareSizes) -> list[Finding]:
    """A warning where weight matters and the cell does not tell how its work object was taught."""
    weight, whole = float(shares.size["gravity"].max()), shares.largest
    matters = weight > c.job.placement.sampling.chord / 1e3 and weight > MATTERS * whole
    if c.job.placement.touches is not None or not matters:
        return []
    what = (
        f"arm and tool sag by up to {weight * 1e3:.2f} mm under their weight, of {whole * 1e3:.2f} mm in all. A work "
        "object that was touched off with this tool has that in it: corrected once more, the cut is off by as much"
    )
    remedy = (
        "Give [workobject] touched_off = [[x, y, z], ...], the points that were touched, in mm of the work object (or "
        "postures); touched_off = [] where it was measured otherwise"
    )
    return [Finding(WARNING, f"{c.job.placement.source}: workobject", what, remedy)]
