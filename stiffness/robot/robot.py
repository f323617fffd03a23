"""Robot: a rigid serial arm of rotary joints, its kinematics, joint limits and masses.

Frames: ``L_0`` is the base, ``L_k = L_{k-1} @ before[k-1] @ Rot(axis[k-1], q_k) @ after[k-1]``, ``L_n`` the
flange. Numbers come from Pinocchio, symbols from CasADi; both are built from these same placements.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np
import numpy.typing as npt
import pinocchio as pin

from stiffness.errors import RobotError
from stiffness.robot.controller_frame import ControllerFrame
from stiffness.robot.link_shape import NO_SHAPES, RobotShapes
from stiffness.robot.reducer import Reducer
from stiffness.robot.tips import FormerFlange

Floats = npt.NDArray[np.float64]

STANDARD_GRAVITY = (0.0, 0.0, -9.80665)  # m/s2, base axes (CGPM 1901)


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class Robot:
    """A rigid serial arm. All arrays are read-only.

    Attributes:
        name: name of the built-in robot, or stem of the file.
        joint_names: n names, base to flange.
        before: (n, 4, 4) from link k-1 to joint k at zero.
        axis: (n, 3) unit vector of positive rotation, in the joint's frame.
        after: (n, 4, 4) from joint k, turned, to link k.
        lower, upper: (n,) rad; infinite for a joint without stops.
        velocity: (n,) rad/s; NaN where not known.
        acceleration: (n,) rad/s2; NaN where not known, None where the file has none at all.
        mass: (n,) kg, or None where not known.
        com: (n, 3) m, centre of mass in the link frame L_k, or None.
        mass_problem: why the masses are not known; empty when they are.
        assumptions: figures without a source, in words; every summary lists them.
        sources: where the figures come from.
        base, tip: names of the frames that poses lead from and to.
        reducers: n data sheets, None for a joint without one; None where the file has none at all.
        tip_why: why no controller has the tip as its flange, so that no program is made for it; empty where one has.
        former_flange: what the flange of a built-in robot was in earlier versions.
        flange_frame: what controllers measure tools from, where a URDF has it and no tip was asked for.
        base_frame: what its controller measures positions from, where a URDF has it and no base was asked for.
        reach: m, as the maker gives it; None: not known.
        shapes: what the links look like.
    """

    name: str
    joint_names: tuple[str, ...]
    before: Floats
    axis: Floats
    after: Floats
    lower: Floats
    upper: Floats
    velocity: Floats
    mass: Floats | None
    com: Floats | None
    mass_problem: str
    assumptions: tuple[str, ...]
    sources: tuple[str, ...]
    base: str
    tip: str
    reducers: tuple[Reducer | None, ...] | None = None
    tip_why: str = ""
    former_flange: FormerFlange | None = None
    flange_frame: ControllerFrame | None = None
    base_frame: ControllerFrame | None = None
    reach: float | None = None
    acceleration: Floats | None = None
    shapes: RobotShapes = NO_SHAPES

    def __post_init__(self) -> None:
        for array in (self.before, self.axis, self.after, self.lower, self.upper, self.velocity):
            array.setflags(write=False)
        for optional in (self.mass, self.com, self.acceleration):
            if optional is not None:
                optional.setflags(write=False)

    def __repr__(self) -> str:
        weight = f"{self.mass.sum():.0f} kg moving" if self.mass is not None else "masses unknown"
        return f"Robot({self.name}, {self.n} joints, {self.base} to {self.tip}, {weight})"

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.joint_names)

    def same_kinematics(self, other: Robot) -> bool:
        """Whether both are one arm between the same frames: placements and axes agree to 1e-9 plus 1e-5 of each."""
        pairs = ((self.before, other.before), (self.axis, other.axis), (self.after, other.after))
        return all(a.shape == b.shape and np.allclose(a, b, atol=1e-9) for a, b in pairs)

    def pose(self, q: npt.ArrayLike) -> Floats:
        """(4, 4) pose of the flange in the base at joint angles ``q`` (n,) rad."""
        model, data, frame = self._pinocchio
        pin.framesForwardKinematics(model, data, self._angles(q))
        return np.array(data.oMf[frame].homogeneous)

    def jacobian(self, q: npt.ArrayLike) -> Floats:
        """(6, n) Jacobian of the flange origin in base axes, linear rows (m/rad) first."""
        model, data, frame = self._pinocchio
        world_aligned = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        return np.array(pin.computeFrameJacobian(model, data, self._angles(q), frame, world_aligned))

    def gravity_torque(self, q: npt.ArrayLike, gravity: Sequence[float] = STANDARD_GRAVITY) -> Floats:
        """(n,) N*m, the generalised force OF gravity: minus Pinocchio's computeGeneralizedGravity.

        Args:
            gravity: (3,) m/s2 in base axes.

        Raises:
            RobotError: the masses are not known.
        """
        if self.mass is None:
            raise RobotError(f"robot {self.name}: no gravity torque without masses: {self.mass_problem}")
        shared, data, _ = self._pinocchio
        model = shared.copy()  # the cached one belongs to all callers
        model.gravity.linear = np.asarray(gravity, dtype=float)
        return -np.array(pin.computeGeneralizedGravity(model, data, self._angles(q)))

    def flange_symbolic(self, q: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Rotation (3, 3) and origin (3,) of the flange in the base, for symbolic ``q`` (n,)."""
        rotation, origin = ca.SX.eye(3), ca.SX(3, 1)
        for k in range(self.n):
            before, after = constant(self.before[k]), constant(self.after[k])
            origin = origin + ca.mtimes(rotation, before[:3, 3])
            rotation = ca.mtimes(ca.mtimes(rotation, before[:3, :3]), axis_rotation(self.axis[k], q[k]))
            origin = origin + ca.mtimes(rotation, after[:3, 3])
            rotation = ca.mtimes(rotation, after[:3, :3])
        return rotation, origin

    def _angles(self, q: npt.ArrayLike) -> Floats:
        angles = np.asarray(q, dtype=float)
        if angles.shape != (self.n,) or not np.isfinite(angles).all():
            raise RobotError(f"robot {self.name}: {self.n} finite joint angles are needed, got {angles!r}")
        return angles

    @cached_property
    def _pinocchio(self) -> tuple[pin.Model, pin.Data, int]:
        model = pin.Model()
        parent, placement = 0, np.eye(4)
        for k in range(self.n):
            joint = pin.JointModelRevoluteUnaligned(np.array(self.axis[k]))
            parent = model.addJoint(parent, joint, pin.SE3(placement @ self.before[k]), self.joint_names[k])
            placement = self.after[k]
            if self.mass is not None and self.com is not None:
                # Rotational inertia plays no part in statics.
                com = self.after[k][:3, :3] @ self.com[k] + self.after[k][:3, 3]
                model.appendBodyToJoint(
                    parent, pin.Inertia(self.mass[k], com, np.zeros((3, 3))), pin.SE3.Identity()
                )
        frame = model.addFrame(
            pin.Frame(self.tip, parent, pin.SE3(np.array(placement)), pin.FrameType.OP_FRAME)
        )
        return model, model.createData(), frame


def placement(rotation: Floats, origin: npt.ArrayLike) -> Floats:
    """(4, 4) homogeneous matrix."""
    matrix = np.eye(4)
    matrix[:3, :3] = rotation
    matrix[:3, 3] = origin
    return matrix


def constant(matrix: Floats) -> ca.SX:
    """Sparse constant without the rounding that cos(pi/2) leaves, so that zeros cost nothing."""
    return ca.SX(ca.sparsify(ca.DM(np.where(np.abs(matrix) < 1e-15, 0.0, matrix))))


def axis_rotation(axis: Floats, angle: ca.SX) -> ca.SX:
    """(3, 3) Rodrigues rotation by ``angle`` about a constant unit axis."""
    x, y, z = (0.0 if abs(c) < 1e-15 else float(c) for c in axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return ca.SX.eye(3) + ca.sin(angle) * constant(cross) + (1 - ca.cos(angle)) * constant(cross @ cross)
