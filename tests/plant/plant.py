"""An independent elastic robot: commanded angles and loads in, where every link really is out.

Statics is solved on MuJoCo's generalised forces with a finite-difference Jacobian; joint laws and the memory
of flanks are in joints.py. Nothing here comes from the packages under test.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from .arm import Arm
from .geometry import Array, between, rotation_vector
from .joints import Bearings, Extra, Friction, Joints, Memory, per_joint
from .moment import Moment
from .scene import PLACE, Load, Scene
from .walk import Walk, reported

TOLERANCE = 1e-13  # rad and m, on the equilibrium
STEP = 1e-7  # rad and m, of the finite differences


class Plant:
    """An arm with elastic joints and, where asked for, elastic places."""

    def __init__(
        self,
        arm: Arm,
        *,
        stiffness: ArrayLike,
        ratio: ArrayLike | None = None,
        gap: ArrayLike | None = None,
        breakaway: ArrayLike | None = None,
        hardening: Extra | None = None,
        side_sign: float = 1.0,
        still: float = 1e-9,
        tool_spring: ArrayLike | None = None,
        springs: Mapping[int, ArrayLike] | None = None,
        gravity_on: bool = True,
        calibrated_out: bool = False,
        friction: Friction | Bearings | None = None,
    ) -> None:
        """Stiffness N*m/rad; springs: link (0 base ... n flange) -> 6 values (N/m x3, N*m/rad x3) or 6x6."""
        n = arm.n
        places = dict(springs or {})
        if tool_spring is not None:
            places[n] = tool_spring
        self.arm, self.calibrated_out = arm, calibrated_out
        self.joints = Joints(
            stiffness=per_joint(stiffness, n, np.inf),
            ratio=per_joint(ratio, n, 1.0),
            gap=per_joint(gap, n, 0.0),
            breakaway=per_joint(breakaway, n, np.inf),
            side_sign=side_sign,
            still=still,
            hardening=hardening,
            friction=friction,
        )
        self.scene = Scene(arm, tuple(places), gravity=gravity_on)
        self._yield = [_flexibility(places[k]) for k in self.scene.places]
        self._slope: Array | None = None  # inverse of the last finite-difference Jacobian

    # ---- rigid arm: what the controller believes

    def _rigid(self, q: Array) -> None:
        self.scene.move(np.concatenate([q, np.zeros(self.scene.size - self.arm.n)]))

    def nominal(self, q: ArrayLike) -> Array:
        """(4,4) TCP of the rigid arm."""
        self._rigid(np.asarray(q, dtype=float))
        return self.scene.tcp()

    def inverse(self, pose: Array, seed: ArrayLike) -> Array:
        """(n,) joint angles near `seed` whose nominal TCP is `pose` (4,4), by Newton, 1e-12 m and rad."""
        q = np.array(seed, dtype=float)
        for _ in range(50):
            T = self.nominal(q)
            turn = T[:3, :3] @ rotation_vector(T[:3, :3].T @ pose[:3, :3])
            error = np.concatenate([pose[:3, 3] - T[:3, 3], turn])
            if np.max(np.abs(error)) < 1e-12:
                return q
            step = np.linalg.lstsq(self.scene.jacobian(), error, rcond=None)[0]
            q = q + step * min(1.0, 0.5 / max(float(np.max(np.abs(step))), 1e-300))
        raise ValueError(f"no inverse kinematics near {np.degrees(seed).round(3)} deg: left over {error}")

    def follow(self, poses: Array, seed: ArrayLike) -> Array:
        """(N,n) joint angles along TCP poses (N,4,4), one after the other, from near `seed`."""
        out = [np.asarray(seed, dtype=float)]
        for pose in poses:
            out.append(self.inverse(pose, out[-1]))
        return np.array(out[1:])

    # ---- one pose

    def _residual(self, z: Array, q: Array, loads: Sequence[Load], memory: Memory) -> Array:
        n = self.arm.n
        angle = q + z[:n]
        self.scene.move(np.concatenate([angle, z[n:]]))
        force = self.scene.forces(loads)
        lawful = [self.joints.deflection(force[:n], angle, memory) + self._more(force[:n], q, angle, memory)]
        for i, flexible in enumerate(self._yield):
            lawful.append(flexible @ force[n + PLACE * i : n + PLACE * (i + 1)])
        return z - np.concatenate(lawful)

    def _more(self, torque: Array, q: Array, angle: Array, memory: Memory) -> Array:
        """(n,) rad: what else turns the joints. Nothing does in this plant."""
        return np.zeros(self.arm.n)

    def _now(self, moment: Moment | None) -> None:
        """The clock and the climate, which this plant does not feel."""

    def _difference(self, z: Array, q: Array, loads: Sequence[Load], memory: Memory) -> Array:
        columns = [
            (self._residual(z + h, q, loads, memory) - self._residual(z - h, q, loads, memory)) / (2 * STEP)
            for h in STEP * np.eye(len(z))
        ]
        return np.array(np.linalg.inv(np.array(columns).T))

    def equilibrium(
        self, q: Array, loads: Sequence[Load], memory: Memory, guess: Array | None = None
    ) -> Array:
        """(size,) deflections of joints and places at rest; leaves the scene there."""
        z = np.zeros(self.scene.size) if guess is None else guess.copy()
        before = np.inf
        for _ in range(100):
            rest = self._residual(z, q, loads, memory)
            size = float(np.max(np.abs(rest)))
            if size < TOLERANCE:
                return z
            if not np.isfinite(size):
                break
            if self._slope is None or not size < 0.2 * before:
                self._slope = self._difference(z, q, loads, memory)
            before = size
            z = z - self._slope @ rest
        raise ValueError(f"no equilibrium at q = {np.degrees(q).round(3)} deg: residual {size:.1e}")

    def _settle(self, memory: Memory, loads: Sequence[Load], guess: Array | None) -> tuple[Array, Memory]:
        """Equilibrium with every joint whose torque breaks away on the flank that its torque pushes it to."""
        moved, side = memory.play, np.zeros(self.arm.n)  # side: 0 where the motion decides
        z = self.equilibrium(memory.command, loads, memory, guess)
        while self.joints.load_matters:
            torque = self.scene.forces(loads)[: self.arm.n]
            carried = (side == 0) & (np.abs(torque) > self.joints.breakaway)
            side = np.where(carried, np.sign(torque), side)  # once carried in this pose, it stays: this ends
            play = np.where(side == 0, moved, side * self.joints.gap / 2)
            if np.array_equal(play, memory.play):
                break
            memory = replace(memory, play=play)
            z = self.equilibrium(memory.command, loads, memory, z)
        return z, self.joints.rested(memory, self.scene.forces(loads)[: self.arm.n])

    def _sag(self, q: Array, rigid: Array) -> Array:
        """(n+1,4,4) link frames under gravity alone: pre-loaded, no gap, no process; rigid if not known."""
        if not self.calibrated_out:
            return rigid
        self.equilibrium(q, (), Memory.fresh(q))
        return self.scene.links()

    # ---- a path

    def walk(
        self,
        q_cmd: ArrayLike,
        wrench: ArrayLike | None = None,
        *,
        start: Memory | ArrayLike | None = None,
        loads: Sequence[Sequence[Load]] | None = None,
        moments: Sequence[Moment] | None = None,
    ) -> Walk:
        """Command by command through q_cmd (N,n) under wrench (N,6) | (6,) and further loads per pose.

        start: where the arm stood before (n,), or the memory of an earlier walk; None: nothing is known.
        """
        q = np.atleast_2d(np.asarray(q_cmd, dtype=float))
        w = _wrenches(wrench, len(q))
        return self._run(q, w, _memory(start, q[0]), loads, np.ones(len(q), dtype=bool), keep=True, moments=moments)

    def run(
        self,
        q_cmd: ArrayLike,
        wrench: ArrayLike | None = None,
        *,
        start: Memory | ArrayLike | None = None,
        interpolate: int = 1,
        keep_between: bool = False,
    ) -> Walk:
        """As `walk`, but each move from pose to pose is `interpolate` steps on a straight TCP line (MoveL).

        The controller's own kinematics turns the line into angles. From `start` to the first pose: one joint
        move. keep_between: rows of the steps between the poses as well (see Walk.knot).
        """
        q = np.atleast_2d(np.asarray(q_cmd, dtype=float))
        w = _wrenches(wrench, len(q))
        fine_q, fine_w = [q[0]], [w[0]]
        for k in range(1, len(q)):
            fine_q += self._line(q[k - 1], q[k], interpolate)
            fine_w += [w[k - 1] + (w[k] - w[k - 1]) * (i + 1) / interpolate for i in range(interpolate)]
        knot = np.arange(len(fine_q)) % interpolate == 0
        return self._run(np.array(fine_q), np.array(fine_w), _memory(start, q[0]), None, knot, keep_between)

    def _line(self, q_from: Array, q_to: Array, steps: int) -> list[Array]:
        """Joint angles along the straight TCP line, ending exactly at q_to."""
        T_from, T_to = self.nominal(q_from), self.nominal(q_to)
        out, q = [], q_from
        for i in range(1, steps):
            q = self.inverse(between(T_from, T_to, i / steps), q + (q_to - q) / (steps - i + 1))
            out.append(q)
        if steps > 1 and np.max(np.abs(self.inverse(T_to, q + (q_to - q) * 0.5) - q_to)) > 1e-6:
            raise ValueError(f"a straight line from {q_from} does not end at {q_to}: another configuration")
        return [*out, q_to]

    def _run(
        self,
        q: Array,
        w: Array,
        memory: Memory,
        loads: Sequence[Sequence[Load]] | None,
        knot: Array,
        keep: bool,
        moments: Sequence[Moment] | None = None,
    ) -> Walk:
        rows: list[dict[str, object]] = []
        at = np.asarray(self.arm.tool.xyz, dtype=float)
        guess: Array | None = None
        for k, command in enumerate(q):
            self._now(moments[k] if moments is not None else None)
            memory = self.joints.turned(memory, command)
            wanted = keep or bool(knot[k])
            if not wanted and not self.joints.load_matters:
                continue  # between two poses only the motion counts
            here = [Load(self.arm.n, at, w[k, :3], w[k, 3:]), *(loads[k] if loads is not None else ())]
            guess, memory = self._settle(memory, here, guess)
            if wanted:
                row = self._row(command, here, memory, guess)
                rows.append({"q_cmd": command, "wrench": w[k], "knot": knot[k], **row})
        columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
        return Walk(**columns, memory=memory)

    def _row(self, q: Array, loads: Sequence[Load], memory: Memory, z: Array) -> dict[str, Array]:
        n = self.arm.n
        torque, links = self.scene.forces(loads)[:n], self.scene.links()
        self._rigid(q)
        rigid, nominal = self.scene.links(), self.scene.tcp()
        sag = self._sag(q, rigid)
        tcp = links[n] @ self.arm.tool.pose
        tcp[:3, :3] = nominal[:3, :3] @ (sag[n] @ self.arm.tool.pose)[:3, :3].T @ tcp[:3, :3]
        tcp[:3, 3] = reported(links[n], rigid[n], sag[n], self.arm.tool.xyz)
        return {
            "q_act": q + z[:n],
            "elastic": z[n:],
            "torque": torque,
            "play": memory.play,
            "direction": memory.direction,
            "links": links,
            "rigid": rigid,
            "sag": sag,
            "tcp": tcp,
            "nominal": nominal,
        }


def _flexibility(spring: ArrayLike) -> Array:
    """(6,6) m and rad per N and N*m, from 6 stiffnesses or a 6x6 stiffness; inf is rigid."""
    k = np.asarray(spring, dtype=float)
    return np.diag(1.0 / k) if k.ndim == 1 else np.linalg.inv(k)


def _memory(start: Memory | ArrayLike | None, first: Array) -> Memory:
    if isinstance(start, Memory):
        return start
    return Memory.fresh(first if start is None else np.asarray(start, dtype=float))


def _wrenches(wrench: ArrayLike | None, count: int) -> Array:
    return np.array(np.broadcast_to(np.zeros(6) if wrench is None else np.asarray(wrench, float), (count, 6)))
