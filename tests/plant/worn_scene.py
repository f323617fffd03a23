"""The worn arm as a MuJoCo model: flexures inside links, struts and ties as tendons, lumps, lengths that grow."""

from __future__ import annotations

import mujoco
import numpy as np

from .arm import Arm
from .geometry import Array, rigid_inverse
from .scene import PLACE, Scene
from .wear import Wear


class WornScene(Scene):
    """Coordinates: the n joint angles, then six of every flexure, in the order of `wear.flexures`."""

    def __init__(self, arm: Arm, wear: Wear, gravity: bool = True) -> None:
        self.wear = wear
        self.pulled = bool(wear.ties or wear.strut)
        super().__init__(arm, (), gravity)
        extra = [self.model.joint(f"w{i}_{j}").dofadr[0] for i in range(len(wear.flexures)) for j in range(PLACE)]
        self._columns = np.concatenate([self._columns, np.array(extra, dtype=self._columns.dtype)])
        self._length = self.model.body_pos.copy()  # at the reference temperature
        self._grows = [
            [self.model.body(name).id for name in names] for names in (self._bodies(k) for k in range(arm.n + 1))
        ]

    def _bodies(self, k: int) -> list[str]:
        """Bodies whose position is a length of link k: from its joint to its frame, and on to the next joint."""
        own = [f"link{k}"] if k else []
        inside = [f"flexure{i}" for i, f in enumerate(self.wear.flexures) if f.link == k and k]
        return own + inside + ([f"joint{k}"] if k < self.arm.n else [])

    def _build(self, gravity: bool) -> mujoco.MjSpec:
        arm, wear, spec = self.arm, self.wear, mujoco.MjSpec()
        spec.compiler.degree = False
        spec.option.gravity = arm.gravity if gravity else np.zeros(3)
        moved: dict[int, Array] = {}
        for k, T in wear.moved:
            moved[k] = moved.get(k, np.eye(4)) @ T
        body = self._inside(spec.worldbody, 0, np.eye(4), moved)
        for k in range(arm.n):
            body = self._body(body, f"joint{k}", arm.before[k])
            body.add_joint(name=f"q{k}", type=mujoco.mjtJoint.mjJNT_HINGE, axis=arm.axis[k])
            body = self._inside(body, k + 1, arm.after[k], moved)
            if arm.mass is not None and arm.com is not None and arm.mass[k] > 0:
                body.mass, body.ipos = arm.mass[k], arm.com[k]
        tool = self._body(body, "tool", np.eye(4))
        if arm.tool.mass > 0:
            tool.mass, tool.ipos = arm.tool.mass, arm.tool.com
        for i, lump in enumerate(wear.lumps):
            if lump.mass > 0:
                hung = self._body(spec.body(f"link{lump.link}"), f"lump{i}", np.eye(4))
                hung.mass, hung.ipos = lump.mass, lump.com
        self._tendons(spec)
        return spec

    def _inside(self, body: mujoco.MjsBody, k: int, along: Array, moved: dict[int, Array]) -> mujoco.MjsBody:
        """The flexures of link k, one after the other, and the body of its frame at `along` (4,4)."""
        here = np.eye(4)
        for i, flexure in enumerate(self.wear.flexures):
            if flexure.link != k:
                continue
            body = self._body(body, f"flexure{i}", rigid_inverse(here) @ flexure.place)
            here = flexure.place
            self._hinges(body, i)
        return self._body(body, f"link{k}", rigid_inverse(here) @ along @ moved.get(k, np.eye(4)))

    @staticmethod
    def _hinges(body: mujoco.MjsBody, i: int) -> None:
        kinds = [mujoco.mjtJoint.mjJNT_SLIDE] * 3 + [mujoco.mjtJoint.mjJNT_HINGE] * 3
        for j, kind in enumerate(kinds):
            body.add_joint(name=f"w{i}_{j}", type=kind, axis=np.eye(3)[j % 3])

    def _tendons(self, spec: mujoco.MjSpec) -> None:
        for i, tie in enumerate(self.wear.ties):
            tendon = spec.add_tendon(name=f"tie{i}", stiffness=tie.stiffness, springlength=[0.0, 0.0])
            for k in np.flatnonzero(tie.coef):
                tendon.wrap_joint(f"q{k}", tie.coef[k])
        strut = self.wear.strut
        if strut is not None:
            for name, link, at in (("inner", 1, strut.inner), ("outer", 2, strut.outer)):
                spec.body(f"link{link}").add_site(name=name, pos=at)
            tendon = spec.add_tendon(name="strut", stiffness=strut.stiffness, springlength=[strut.length] * 2)
            tendon.wrap_site("inner")
            tendon.wrap_site("outer")

    def relax(self, command: Array) -> None:
        """Ties pull nowhere where every joint (n,) is where it is commanded."""
        for i, tie in enumerate(self.wear.ties):
            self.model.tendon_lengthspring[self.model.tendon(f"tie{i}").id] = float(tie.coef @ command)

    def warm(self, kelvin: float) -> None:
        """Lengths at a temperature above the reference."""
        if not np.any(self.wear.growth):
            return
        self.model.body_pos[:] = self._length
        for k, bodies in enumerate(self._grows):
            self.model.body_pos[bodies] *= 1 + self.wear.growth[k] * kelvin

    def pull(self) -> Array:
        """(size,) generalised force of ties and strut where `move` put the arm."""
        mujoco.mj_tendon(self.model, self.data)
        mujoco.mj_passive(self.model, self.data)
        out: Array = self.data.qfrc_spring[self._columns]
        return out

    def forces(self, loads: object) -> Array:
        """As Scene.forces, with the springs inside the arm."""
        outer = super().forces(loads)  # type: ignore[arg-type]
        return outer + self.pull() if self.pulled else outer
