"""Loads: the wrench of every reading, its axes, the point it is taken about, and the link it acts on."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from stiffness.robot.robot import Robot
from stiffness.schema import meant
from stiffness.session.file import Reflector, SessionTool, Units, WrenchTable
from stiffness.session.table import CsvTable, SessionError

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

WRENCH = ("fx", "fy", "fz", "mx", "my", "mz")


@dataclass(frozen=True, repr=False, eq=False)
class Loads:
    """What pulls at every reading, ready for the statics.

    Attributes:
        wrench: (N, 6) N and N*m, environment on the robot, as the sensor reads it; zero without columns.
        link: (N,) the link it acts on.
        in_tool: (N,) its axes are those of the TCP as it stands; else those of the base.
        point, point_link: (N, 3) m in the frame of link (N,): the point that the moment is taken about. It
            need not sit on the link that carries the load: link 0 where the moment is about the base.
        at: (N,) the reflector that is this point, else -1. Where it is not exact, so is ``point``.
    """

    wrench: Floats
    link: Ints
    in_tool: Bools
    point: Floats
    point_link: Ints
    at: Ints


@dataclass(frozen=True)
class SessionHeader:
    """What session.toml tells that the cells of samples.csv are read with; ``label``: how messages call the file."""

    label: str
    robot: Robot
    units: Units
    tool: SessionTool | None
    wrench: WrenchTable | None
    reflectors: tuple[Reflector, ...]
    tracker: float


def reflector_index(table: CsvTable, column: str, header: SessionHeader) -> Ints:
    """Indices of the reflectors named in a column; -1 for an empty cell of ``load_at``."""
    index = {r.name: k for k, r in enumerate(header.reflectors)}
    if column == "load_at":
        index[""] = -1
    found = np.array([index.get(cell, -2) for cell in table.cells[column]], dtype=np.int64)
    if (found == -2).any():
        row = int(np.argmax(found == -2))
        names = [r.name for r in header.reflectors]
        hint = meant(table.cells[column][row], names)
        why = f"{header.label} has no such reflector, it has {', '.join(names)}{hint}"
        table.refuse(found == -2, [column], why)
    return found


def read_loads(table: CsvTable, header: SessionHeader) -> Loads:
    """The loads of all readings.

    Raises:
        SessionError: columns without [wrench] or the reverse, a link or reflector that does not exist.
    """
    count, n, given, tool = len(table.line), header.robot.n, header.wrench, header.tool
    present = table.has(WRENCH)
    _check_wrench(table, header, present)
    link = np.full(count, n)
    if "load_link" in table.cells:
        filled = {**table.cells, "load_link": tuple(cell or str(n) for cell in table.cells["load_link"])}
        link = replace(table, cells=filled).integers(["load_link"])[:, 0]
        table.refuse((link < 0) | (link > n), ["load_link"], f"the robot has the links 0 ... {n}")
    about, where = np.zeros(3), n
    if given is not None and given.about == "tcp" and tool is not None:
        about = tool.position
    elif given is not None and given.about == "base":
        where = 0
    at = reflector_index(table, "load_at", header) if "load_at" in table.cells else np.full(count, -1)
    if "load_at" in table.cells:
        bare = np.array([cell == "" for cell in table.cells["load_link"]])
        table.refuse((at >= 0) & bare, ["load_at"], "load_link is empty; say which link the load acts on")
    places = np.array([about, *(r.position for r in header.reflectors)])
    links = np.array([where, *(r.link for r in header.reflectors)], dtype=np.int64)
    return Loads(
        wrench=table.numbers(WRENCH) if present else np.zeros((count, 6)),
        link=link,
        in_tool=np.full(count, given is not None and given.frame == "tool"),
        point=places[at + 1],
        point_link=links[at + 1],
        at=at,
    )


def _check_wrench(table: CsvTable, header: SessionHeader, present: bool) -> None:
    given, label = header.wrench, header.label
    if present and given is None:
        raise SessionError(f"{table.label}: column fx: {label} has no [wrench]; add it, with frame and about")
    loaded = any(cell.strip("0") for cell in table.cells["state"])
    if given is not None and not present and loaded and "payload" not in table.cells:
        raise SessionError(
            f"{label}: [wrench], and {table.label} has loaded states, but no columns {', '.join(WRENCH)}; add them "
            "or take [wrench] out"
        )
    if given is not None and present and header.tool is None and (given.frame == "tool" or given.about == "tcp"):
        key = f"frame = {given.frame!r}, about = {given.about!r}"
        raise SessionError(f"{label}: [wrench] {key}, and there is no [tool]; add it, with xyz and rpy")
    for name in ("load_link", "load_at"):
        if name in table.cells and not present:
            missing = ", ".join(WRENCH)
            raise SessionError(f"{table.label}: column {name}: no load to place; add {missing} or take it out")
    if "load_at" in table.cells and "load_link" not in table.cells:
        raise SessionError(f"{table.label}: column load_at without load_link; say which link the load acts on")
