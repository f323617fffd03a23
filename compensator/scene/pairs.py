"""Pairs: which bodies may meet, and which are declared to touch."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from compensator.cell.scene_tables import CollisionsTable
from compensator.errors import CellError
from compensator.scene.body import BASE, TOOL, WORKOBJECT, Body
from stiffness.robot.robot import Robot

CLOSE = 2  # places in the chain between bodies whose distance is a matter of design: contact counts, nearness does not


@dataclass(frozen=True)
class Pair:
    """Two bodies that are looked at.

    Attributes:
        inner, outer: index of the bodies; ``outer`` is the one farther out on the arm.
        joints: of the arm that move them against each other, as a slice of the angles.
        tool: number of the tool that has to be on; None: any.
        margin: whether nearness is told, too.
        cut: whether a feed may bring them together.
    """

    inner: int
    outer: int
    joints: slice
    tool: int | None
    margin: bool
    cut: bool = False


def depth(body: Body, n: int) -> int:
    """Place in the chain: how many joints move it."""
    if isinstance(body.carrier, int):
        return body.carrier
    return n if body.carrier == TOOL else 0


def pairs_of(
    bodies: Sequence[Body],
    robot: Robot,
    settings: CollisionsTable,
    source: str,
    *,
    on_rail: bool = False,
    on_table: bool = False,
) -> tuple[Pair, ...]:
    """All pairs that are looked at. Links that follow each other are neighbours, as are those that robot file and cell
    declare; the tool is one with the flange; the cutter, shank and holder against the stock are the process's affair.

    Args:
        on_rail: a rail carries the robot: its base, and what rides with it, goes past what stands on the floor.
        on_table: a table turns the part: what stands on it goes past all else.

    Raises:
        CellError: the cell declares a body as neighbour that is not there.
    """
    allowed = _allowed(bodies, settings, source)
    linked = {frozenset(p) for p in robot.shapes.neighbours}
    out = []
    for i, a in enumerate(bodies):
        for k, b in enumerate(bodies[:i]):
            inner, outer = (k, i) if _place(b, robot.n) <= _place(a, robot.n) else (i, k)
            first, second = bodies[inner], bodies[outer]
            if frozenset((first.name, second.name)) in allowed:
                continue
            passing = on_rail and (first.carrier == BASE) != (second.carrier == BASE)
            passing |= on_table and (first.carrier == WORKOBJECT) != (second.carrier == WORKOBJECT)
            if _apart(first, second, robot, settings=settings, linked=linked, passing=passing):
                continue
            begin, end = depth(first, robot.n), depth(second, robot.n)
            out.append(Pair(
                inner, outer, slice(begin, end), second.tool, margin=not first.on_arm or end - begin > CLOSE,
                cut=first.sacrificial and second.role == "cutter",
            ))  # fmt: skip
    return tuple(out)


def _place(body: Body, n: int) -> tuple[int, bool]:
    """As ``depth``; what rides with the base is farther out than what stands on the floor."""
    return depth(body, n), body.carrier == BASE


def _allowed(bodies: Sequence[Body], settings: CollisionsTable, source: str) -> set[frozenset[str]]:
    names = {b.name for b in bodies}
    for name in (name for pair in settings.neighbours for name in pair):
        if name not in names:
            listed = ", ".join(sorted(names))
            raise CellError(f"{source}: collisions.neighbours: {name!r} is no body; there are: {listed}")
    return {frozenset(pair) for pair in settings.neighbours}


def _apart(
    first: Body,
    second: Body,
    robot: Robot,
    *,
    settings: CollisionsTable,
    linked: Iterable[frozenset[int]],
    passing: bool,
) -> bool:
    """Whether a pair is not looked at; ``second`` is the outer one; ``passing``: they move past each other without a
    joint."""
    begin, end = depth(first, robot.n), depth(second, robot.n)
    if (begin == end and not passing) or (first.tool is not None and first.tool != second.tool):
        return True  # nothing moves between them
    taken = "part" if settings.stock == "part" else "stock"
    if first.role in ("stock", "part"):
        return first.role != taken or second.role in ("cutter", "shank", "holder")
    if begin == end and second.role in ("stock", "part"):
        return second.role != taken
    if first.role == "link" and second.role == "link":
        return end - begin < 2 or frozenset((begin, end)) in linked
    return False
