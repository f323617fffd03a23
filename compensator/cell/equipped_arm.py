"""An arm with the tools of a placement: the statics of every pose of a path with the tool that it calls."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import partial

import numpy as np
import numpy.typing as npt

from compensator.cell.arm import Arm, Conditions
from compensator.errors import CellError, SolveError
from compensator.path.tool_set import ToolSet
from stiffness.effects.effect import Effect, Numbers
from stiffness.errors import EquilibriumError
from stiffness.kinematics.inverse import Inverse
from stiffness.memory.preload import PreloadState, base_stiffness, unknown
from stiffness.memory.state_columns import state_columns
from stiffness.model.model import ComplianceModel
from stiffness.robot.robot import Robot
from stiffness.statics.prediction import COLUMNS, Command, Prediction, StartValues
from stiffness.statics.predictor import Predictor
from stiffness.statics.shares import DeflectionShares, ShareFinder
from toolpaths.columns import blocks
from toolpaths.frame import Frame
from toolpaths.made_frames import MadeFrames
from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int32]
Rows = npt.NDArray[np.intp] | slice


@dataclass(frozen=True, repr=False, eq=False)
class EquippedArm:
    """An arm with its tools.

    Attributes:
        robot, inverse, model: of the arm.
        tools: what hangs on the flange.
        effects, values: of the model, that act on a path with these tools.
        not_applied: names of effects of the model that do not.
        predictors: number of the tool -> statics with it.
        taken_off: how the part stands away from where the controller has its work object, base axes: the deflection
            that the work object was touched off with. Predictions are as seen from the part. None: it stands there.
    """

    robot: Robot
    inverse: Inverse
    model: ComplianceModel
    tools: ToolSet
    effects: tuple[Effect, ...]
    values: Mapping[str, Numbers]
    not_applied: tuple[str, ...]
    predictors: Mapping[int, Predictor]
    taken_off: Frame | None = None

    def __repr__(self) -> str:
        return f"EquippedArm({self.robot.name}, {self.tools!r}, effects {[e.name for e in self.effects]})"

    @property
    def unknown_state(self) -> PreloadState:
        """Before the first move nothing is known of the flanks."""
        return unknown(self.effects, self.values)

    @property
    def closed_form(self) -> bool:
        """Whether commands follow from actual angles in one step, so that it does not matter where a solve begins."""
        return all(p.closed_form for p in self.predictors.values())

    def command(
        self,
        toolpath: Toolpath,
        target: Frame,
        *,
        wrench: Floats,
        state: Floats,
        seed: Floats,
        near: StartValues | None = None,
    ) -> Command:
        """Commands whose deflected TCP stands at ``target`` (N), with the tool of every pose; see Predictor.command.

        Args:
            wrench: (N, 6) N and N*m on the robot, base axes, about the TCP.
            state: (N, m) memory. seed: (N, n) rad, nominal inverse kinematics of the targets.
        """
        done, nominal = [], partial(self.printed, toolpath)
        target = target if self.taken_off is None else self.taken_off.then(target)
        for number, r in self.tools.rows(toolpath):
            begin = near and StartValues(near.q[r], near.actual[r], near.extra[r])
            predictor = self.predictors[number]
            found = predictor.command(target.take(r), wrench[r], state[r], start=seed[r], near=begin)
            done.append((r, found))
        columns = {name: _merged(len(seed), [(r, getattr(c, name)) for r, c in done]) for name in COLUMNS}
        return Command(**columns, nominal=nominal, steps=max(c.steps for _, c in done))

    def printed(self, toolpath: Toolpath, q: Floats) -> Frame:
        """(N) nominal TCP poses, base, of commands (N, n) rad: what a program prints."""
        called = toolpath.tool

        def made(rows: npt.NDArray[np.intp]) -> Frame:
            some = q[rows]
            parts = [(r, self.predictors[number].nominal(some[r])) for number, r in self.tools.rows_of(called[rows])]
            rotation, origin = ([(r, getattr(p, name)) for r, p in parts] for name in ("rotation", "origin"))
            return Frame(_merged(len(rows), rotation), _merged(len(rows), origin))

        return MadeFrames(len(q), made)

    def forward(self, toolpath: Toolpath, q: Floats, wrench: Floats, state: Floats) -> Prediction:
        """Equilibrium of commands (N, n) rad, with the tool of every pose; see Predictor.forward.

        Raises:
            SolveError: there is none; names the pose.
        """
        done = []
        for number, r in self.tools.rows(toolpath):
            try:
                done.append((r, self.predictors[number].forward(q[r], wrench[r], state[r])))
            except EquilibriumError as e:
                k = int(np.arange(len(q))[r][e.row])
                where = f"{toolpath.where(k)} (pose {toolpath.row[k]:g} of the file)"
                raise SolveError(f"{where}: {e.problem}") from e
        names = ("rotation", "position", "torque", "residual")
        found = {name: _merged(len(q), [(r, getattr(f, name)) for r, f in done]) for name in names}
        if self.taken_off is not None:
            seen = Frame(found["rotation"], found["position"]).relative_to(self.taken_off)
            found |= {"rotation": seen.rotation, "position": seen.origin}
        return Prediction(**found)

    def links(self, toolpath: Toolpath, q: Floats, wrench: Floats, state: Floats) -> tuple[Frame, Frame]:
        """Frames (N, n + 1) of the links in the base, rigid and in equilibrium; see Predictor.links."""
        parts = []
        for number, r in self.tools.rows(toolpath):
            rigid, deflected = self.predictors[number].links(q[r], wrench[r], state[r])
            parts.append((r, (rigid.rotation, rigid.origin, deflected.rotation, deflected.origin)))
        rotation, origin, turned, moved = (_merged(len(q), [(r, part[k]) for r, part in parts]) for k in range(4))
        return Frame(rotation, origin), Frame(turned, moved)

    def shares(
        self, toolpath: Toolpath, q: Floats, wrench: Floats, *, seen: Floats, at: npt.NDArray[np.intp]
    ) -> dict[str, Floats]:
        """Shares of the deflection of the TCP by cause, (K, 3) m each, base axes; they add up to it. See shares_of.

        ``touched_off`` is what touching off the work object takes off, where that is given.

        Args:
            seen: (N, 3) m, the TCP that ``forward`` predicts for commands ``q`` (N, n) rad.
            at: (K,) poses that are asked about.
        """
        found = dict[str, Floats]()
        for b, shares in self.shares_by_block(toolpath.tool, q, wrench, seen=seen, at=at):
            for name, share in shares.items():
                found.setdefault(name, np.zeros((len(at), 3)))[b] = share
        return found

    def shares_by_block(
        self, tool: Ints, q: Floats, wrench: Floats, *, seen: Floats, at: npt.NDArray[np.intp]
    ) -> Iterator[tuple[slice, dict[str, Floats]]]:
        """As ``shares``, block by block: rows of ``at``, and their shares; ``tool``: (N,) its number."""
        finders = dict[int, ShareFinder]()
        for b in blocks(len(at)):
            rows = at[b]
            as_seen = seen[rows]
            actual, parts = as_seen if self.taken_off is None else self.taken_off.at(as_seen), []
            for number, r in self.tools.rows_of(tool[rows]):
                finder = finders.setdefault(number, ShareFinder(self.predictors[number]))
                parts.append((r, finder.of(q[rows][r], wrench[rows][r], actual[r])))
            names = [f.name for f in fields(DeflectionShares)]
            found = {name: _merged(len(rows), [(r, getattr(part, name)) for r, part in parts]) for name in names}
            if self.taken_off is not None:
                found["touched_off"] = as_seen - actual
            yield b, found

    def nominal(self, toolpath: Toolpath, q: Floats) -> Floats:
        """(N, 3) m: the TCP of commands as a controller shows it, base axes."""
        parts = [(r, self.predictors[number].nominal(q[r]).origin) for number, r in self.tools.rows(toolpath)]
        return _merged(len(q), parts)

    def joint_deflection(self, q: Floats, torque: Floats, state: Floats) -> Floats:
        """dq (N, n) of the joint laws alone."""
        return next(iter(self.predictors.values())).joint_deflection(q, torque, state)

    def joint_states(self, state: Floats) -> Floats:
        """(N, n) rad: the part of ``state`` that is itself a joint deflection."""
        columns = state_columns(self.effects, self.robot.n)
        stiffness = base_stiffness(self.effects, self.values, self.robot.n)
        total = np.zeros((len(state), self.robot.n))
        for e in self.effects:
            if e.memory and e.memory.deflection:
                total += e.memory.deflection(state[:, columns[e.name]], stiffness)
        return total


def _merged(rows: int, parts: Sequence[tuple[Rows, Floats]]) -> Floats:
    if len(parts) == 1:
        return parts[0][1]
    out = np.empty((rows, *parts[0][1].shape[1:]))
    for r, values in parts:
        out[r] = values
    return out


def equipped(
    arm: Arm,
    tools: ToolSet,
    conditions: Conditions,
    *,
    source: str,
    process: tuple[str, str] | None = None,
    walls: bool = False,
) -> EquippedArm:
    """An arm with tools, under these conditions.

    Args:
        source: the file that gives them, for messages. process: names of material and cutter; None: nothing is cut.
        walls: the process tells which wall a cutter cuts.

    Raises:
        CellError: the model has effects of one tool and there are several; masses are not known where they count.
    """
    names = {t.name for t in tools.by_number.values()}
    if len(names) > 1 and any(e.scope == "tool" for e in arm.model.effects):
        listed = ", ".join(sorted(names))
        raise CellError(f"{source}: the model has effects of one tool; the cell has tools {listed}")
    effects, not_applied = arm.acting(tools.first.name, process, walls=walls)
    _refuse_without_masses(source, arm.robot, effects, arm.sag(conditions))
    return EquippedArm(
        robot=arm.robot,
        inverse=arm.inverse,
        model=arm.model,
        tools=tools,
        effects=effects,
        values={e.name: arm.model.values[e.name] for e in effects},
        not_applied=not_applied,
        predictors={number: arm.predictor(tool, conditions) for number, tool in tools.by_number.items()},
    )


def _refuse_without_masses(source: str, robot: Robot, effects: Sequence[Effect], sag: str) -> None:
    if robot.mass is None and sag == "uncompensated":
        raise CellError(
            f"{source}: gravity = 'uncompensated' needs the link masses of {robot.name}: {robot.mass_problem}; "
            "give them in the robot file, or set gravity = \"calibrated-out\" if the controller takes the sag off"
        )
    if robot.mass is None and any(e.needs_torque_sign for e in effects):
        names = ", ".join(e.name for e in effects if e.needs_torque_sign)
        raise CellError(
            f"{source}: {names} depends on the gravity torque of every joint, but {robot.mass_problem}; "
            "give link masses in the robot file or leave the effect out of the model"
        )
