"""Predictor: the statics of one arm with one tool, over whole paths, forwards and backwards.

Forwards, a command is given and the equilibrium asked for. Backwards, the pose of the deflected TCP is given
and the command asked for; the ACTUAL joint angles are then the unknown, because the load depends on
them alone: a pure joint model needs no iteration (``q_cmd = q_act - law(J(q_act)^T W + g(q_act))`` is exact,
K_c included), any other a few Newton steps with the Jacobian of the deflected chain.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np
import numpy.typing as npt

from stiffness.effects.effect import Effect, Numbers
from stiffness.errors import EquilibriumError
from stiffness.numerics.kernel import Kernel
from stiffness.poses import PoseArray, Poses
from stiffness.robot.robot import Robot
from stiffness.statics.arm_functions import ArmFunctions
from stiffness.statics.prediction import TOLERANCE, Command, Prediction, StartValues
from stiffness.statics.statics import SWEEPS
from stiffness.statics.tool import Tool

Floats = npt.NDArray[np.float64]

MAX_STEPS = 25
LARGEST_TURN = 0.05  # rad; small_rotation.rotation is exact below
MAX_SWEEP_CALLS = 10


class Predictor:
    """Statics of ``robot`` with ``effects`` of the given ``values``, carrying ``tool``.

    Args:
        gravity: (3,) m/s2 in the base.
        calibrated_out: the controller knows the sag of arm and declared tool: it is taken off again,
            in base axes, with neutral joints (no gap, pre-loaded).
        complementary: False takes every load at the unloaded posture: no K_c.
        temperature: K above the reference temperature of the model.
    """

    def __init__(
        self,
        robot: Robot,
        effects: Sequence[Effect],
        values: Mapping[str, Numbers],
        tool: Tool,
        *,
        gravity: Floats,
        calibrated_out: bool = False,
        complementary: bool = True,
        temperature: float = 0.0,
    ) -> None:
        self.robot = robot
        self.effects = tuple(effects)
        self.values = values
        self.tool = tool
        self.gravity = gravity
        self.calibrated_out = calibrated_out
        self.complementary = complementary
        self.temperature = temperature
        self._functions = ArmFunctions(
            robot,
            effects,
            values,
            tool,
            gravity=gravity,
            calibrated_out=calibrated_out,
            complementary=complementary,
            temperature=temperature,
        )
        self.statics = self._functions.statics

    def __repr__(self) -> str:
        return f"Predictor({self.statics!r}, tool {self.tool.name!r})"

    def without(self, *, memory: bool = False, weight: bool = False, heat: bool = False) -> Predictor:
        """The same arm with causes of deflection taken away.

        Args:
            memory: of effects that remember the way they came: joints are preloaded, without a gap.
            weight: of arm and tool, and the springs that hold it. heat: it is as warm as the model's reference.
        """
        away = [e for e in self.effects if (memory and e.memory) or (weight and e.torque)]
        kept = [e for e in self.effects if e not in away]
        return Predictor(
            self.robot,
            kept,
            {e.name: self.values[e.name] for e in kept},
            self.tool,
            gravity=np.zeros(3) if weight else self.gravity,
            calibrated_out=self.calibrated_out,
            complementary=self.complementary,
            temperature=0.0 if heat else self.temperature,
        )

    def with_values(self, values: Mapping[str, Numbers]) -> Predictor:
        """The same arm with other values of some effects, by their names."""
        return Predictor(
            self.robot, self.effects, {**self.values, **values}, self.tool, gravity=self.gravity,
            calibrated_out=self.calibrated_out, complementary=self.complementary, temperature=self.temperature,
        )  # fmt: skip

    def forward(self, q: Floats, wrench: Floats, state: Floats) -> Prediction:
        """Equilibrium of commanded poses.

        Args:
            q: (N, n) rad.
            wrench: (N, 6) or (6,), on the robot, base axes, about the TCP.
            state: (N, m) or (m,) memory, ``PreloadState.middle`` or a bracket.

        Raises:
            EquilibriumError: no equilibrium: the arm is too soft for the load.
        """
        return self._equilibrium(q, wrench, state)[1]

    def links(self, q: Floats, wrench: Floats, state: Floats) -> tuple[PoseArray, PoseArray]:
        """Frames (N, n + 1) of the links 0..n in the base: of the rigid, nominal arm, and in equilibrium.

        For pictures: where the controller takes the sag off, it is taken off link by link, in joint angles.

        Args:
            q, wrench, state: as in ``forward``.

        Raises:
            EquilibriumError: as ``forward``.
        """
        x, _ = self._equilibrium(q, wrench, state)
        rigid, at, turned, moved = self._links_kernel.run(q, x)
        return _link_frames(rigid, at), _link_frames(turned, moved)

    def _equilibrium(self, q: Floats, wrench: Floats, state: Floats) -> tuple[Floats, Prediction]:
        """Elastic coordinates (N, n_forward), and where the TCP then is."""
        x = np.zeros((len(q), self._functions.n_forward))
        for _ in range(MAX_SWEEP_CALLS):
            x, torque, residual, rotation, position = self._forward_kernel.run(q, wrench, state, x)
            if not np.any(~(residual <= TOLERANCE)):
                self._refuse_large_turns(x)
                return x, Prediction(_matrices(rotation), position, torque, residual[:, 0])
        worst = int(np.argmax(np.where(np.isfinite(residual[:, 0]), residual[:, 0], np.inf)))
        raise EquilibriumError(
            worst,
            f"no static equilibrium (last change {residual[worst, 0]:.2e} rad after "
            f"{MAX_SWEEP_CALLS} x {SWEEPS} sweeps): the load is too large for these stiffnesses; check their unit "
            "(N*m/rad)",
        )

    def _refuse_large_turns(self, x: Floats) -> None:
        """The statics holds for places that turn by small angles: beyond, its numbers are wrong and the arm absurd."""
        n, places = self.robot.n, len(self.statics.places)
        turns = np.abs(x[:, n : n + 6 * places].reshape(len(x), places, 6)[:, :, 3:]).max(axis=(1, 2), initial=0.0)
        if np.any(turns > LARGEST_TURN):
            row = int(np.argmax(turns))
            raise EquilibriumError(
                row,
                f"a place that yields turns by {turns[row]:.3f} rad, above {LARGEST_TURN:g}: too soft for this load; "
                "check the units of the compliances in the model (m/N, rad/(N*m))",
            )

    def nominal(self, q: Floats) -> PoseArray:
        """TCP poses of the rigid, nominal arm in the base: what a controller prints."""
        rotation, position = self._nominal_kernel.run(q)
        return PoseArray(_matrices(rotation), position)

    def command(
        self,
        target: Poses,
        wrench: Floats,
        state: Floats,
        start: Floats,
        near: StartValues | None = None,
    ) -> Command:
        """Commands whose deflected TCP stands at the wanted pose.

        Args:
            target: N wanted poses of the TCP in the base.
            wrench: (N, 6), base axes, about the TCP.
            state: (N, m).
            start: (N, n) rad, nominal inverse kinematics of the wanted poses: it decides the arm configuration.
            near: where to begin instead, for models that need Newton steps.
        """
        flat, position = _flat(target.rotation), target.origin
        exact = self.closed_form
        if near is not None and not exact:
            q, actual, extra = near.q.copy(), near.actual.copy(), near.extra.copy()
        else:
            q, actual, extra = start.copy(), start.copy(), np.zeros((len(start), self._functions.n_extra))
            if not exact:
                q, extra, actual = self._opening_kernel.run(flat, position, wrench, state, actual, extra, q)
        torque, error = np.zeros_like(start), np.full(len(start), np.inf)
        rows, steps = np.arange(len(start)), 0
        while len(rows) and steps < MAX_STEPS:
            kernel = self._exact_kernel if exact and steps == 0 else self._newton_kernel
            given = (flat, position, wrench, state, actual, extra, q)
            new, new_extra, q_new, tau, e = kernel.run(*(_rows(array, rows, len(q)) for array in given))
            if self._implicit_in_command:
                e = np.maximum(e, np.abs(q_new - q[rows]).max(axis=1, keepdims=True))
            q[rows], torque[rows], error[rows] = q_new, tau, e[:, 0]
            open_rows = ~(e[:, 0] <= TOLERANCE)
            rows, steps = rows[open_rows], steps + 1
            q[rows] += new[open_rows] - actual[rows]  # the command goes along with the Newton step
            actual[rows], extra[rows] = new[open_rows], new_extra[open_rows]
        return Command(
            q=q,
            actual=actual,
            torque=torque,
            nominal=self.nominal,
            error=error,
            extra=extra,
            steps=steps - 1,
        )

    def joint_deflection(self, q: Floats, torque: Floats, state: Floats) -> Floats:
        """dq (N, n) of the joint laws alone at known torques: what a change of state is worth."""
        (dq,) = self._joint_kernel.run(q, torque, state)
        return dq

    @cached_property
    def _nominal_kernel(self) -> Kernel:
        return Kernel(self._functions.nominal())

    @cached_property
    def _links_kernel(self) -> Kernel:
        return Kernel(self._functions.links())

    @cached_property
    def _joint_kernel(self) -> Kernel:
        return Kernel(self._functions.joint_deflection())

    @cached_property
    def _forward_kernel(self) -> Kernel:
        return Kernel(self._functions.forward())

    @cached_property
    def _exact_kernel(self) -> Kernel:
        return Kernel(self._functions.step(newton=False))

    @cached_property
    def _newton_kernel(self) -> Kernel:
        return Kernel(self._functions.step(newton=True))

    @cached_property
    def _opening_kernel(self) -> Kernel:
        return Kernel(self._functions.opening(self._newton_kernel.function))

    @cached_property
    def _implicit_in_command(self) -> bool:
        return self._functions.implicit_in_command

    @property
    def closed_form(self) -> bool:
        """Whether ``command`` is exact without a Newton step, and takes no notice of ``near``."""
        return not (self.statics.places or self.calibrated_out or not self.complementary)


def _matrices(flat: Floats) -> Floats:
    """(N, 9) column-major -> (N, 3, 3)."""
    return np.swapaxes(flat.reshape(-1, 3, 3), 1, 2)


def _link_frames(flat: Floats, origin: Floats) -> PoseArray:
    """(N, 9 (n + 1)) column-major and (N, 3 (n + 1)) -> N times n + 1 frames."""
    rotation = np.swapaxes(flat.reshape(len(flat), -1, 3, 3), 2, 3)
    return PoseArray(rotation, origin.reshape(len(flat), -1, 3))


def _flat(matrices: Floats) -> Floats:
    return np.ascontiguousarray(np.swapaxes(matrices, 1, 2).reshape(-1, 9))


def _rows(array: Floats, rows: npt.NDArray[np.intp], count: int) -> Floats:
    return array if array.ndim == 1 or len(rows) == count else array[rows]
