"""What can be wrong with the body of an arm, what it stands on and what it carries; k counts from 1."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from .ailment import Ailment, only
from .ailments_joint import with_law
from .arm import Arm
from .geometry import Array, placement, rigid_inverse, shift
from .moment import REFERENCE
from .wear import Flexure, Lump, Situation, Strut, Wear

Done = tuple[Wear, Mapping[str, float]]


def zero(k: int) -> Ailment:
    """A joint whose zero is not where the file says."""

    def apply(wear: Wear, arm: Arm, s: float) -> Done:
        return replace(wear, zeros=wear.zeros + only(arm.n, k, 1e-4 * s)), {f"zero joint-{k} rad": 1e-4 * s}

    return Ailment("kinematic-offset", (f"joint-{k}",), "the link stands a constant angle beside the shown one", apply)


def geometry(k: int) -> Ailment:
    """Link k is a little longer, and its frame stands askew."""

    def apply(wear: Wear, arm: Arm, s: float) -> Done:
        xyz, rpy = np.array([1.0, -0.4, 0.7]) * 1e-4 * s, np.array([0.5, -1.0, 0.3]) * 1e-4 * s
        values = {f"{c} link-{k} m": v for c, v in zip("xyz", xyz.tolist(), strict=True)}
        values |= {f"{c} link-{k} rad": v for c, v in zip(("roll", "pitch", "yaw"), rpy.tolist(), strict=True)}
        return replace(wear, moved=(*wear.moved, (k, placement(xyz, rpy)))), values

    return Ailment("kinematic-offset", (f"link-{k}",), "frame k is displaced and turned by constants", apply)


def strut() -> Ailment:
    """A spring with preload between the carousel and the upper arm, behind axis 2."""

    def apply(wear: Wear, arm: Arm, s: float) -> Done:
        size = float(np.linalg.norm(arm.after[1][:3, 3]) or np.linalg.norm(arm.before[2][:3, 3]))
        stiff, length = 0.05 * s * float(wear.stiffness[1]) / size**2, 0.3 * size
        inner = (arm.before[1] @ np.array([-0.35 * size, 0.25 * size, 0.0, 1.0]))[:3]
        outer = (rigid_inverse(arm.after[1]) @ np.array([0.15 * size, 0.1 * size, 0.0, 1.0]))[:3]
        if wear.strut is not None:
            raise ValueError("one cell has one strut")
        values = {"stiffness link-1 link-2 N/m": stiff, "free length link-1 link-2 m": length}
        return replace(wear, strut=Strut(inner, outer, stiff, length)), values

    law = "tendon spring k (l - l0) between a point of link 1 and a point of link 2: torque on joint 2 by q2"
    return Ailment("gravity-compensator", ("joint-2",), law, apply, 0.3)


def payload() -> Ailment:
    """A mass on the flange that nobody declared."""

    def apply(wear: Wear, arm: Arm, s: float) -> Done:
        mass = 5e-5 * s * float(wear.stiffness[1]) / 10
        lump = Lump(arm.n, mass, np.array([0.06, -0.03, 0.15]))
        return replace(wear, lumps=(*wear.lumps, lump)), {"mass tool kg": mass}

    return Ailment("payload", ("tool",), "a dead mass at (60, -30, 150) mm of the flange", apply)


def base(depth: float = 0.35) -> Ailment:
    """The arm rocks about a point below its base plate: tilt shifts the plate as well."""

    def apply(wear: Wear, arm: Arm, s: float) -> Done:
        soft = 0.1 * s / float(wear.stiffness[1])
        diagonal = soft * np.array([0.02, 0.03, 0.01, 1.0, 0.7, 0.3])
        flexure = Flexure(0, shift((0, 0, -depth)), np.diag(diagonal))
        names = ("x m/N", "y m/N", "z m/N", "rx rad/(N*m)", "ry rad/(N*m)", "rz rad/(N*m)")
        values = {f"compliance base {c}": float(v) for c, v in zip(names, diagonal, strict=True)}
        return replace(wear, flexures=(*wear.flexures, flexure)), values | {"depth base m": depth}

    law = f"springs in 6 directions, {1e3 * depth:g} mm below the base plate"
    return Ailment("base-compliance", ("base",), law, apply, 0.5)


def link(k: int, share: float = 0.6) -> Ailment:
    """Link k bends about two axes and twists, at a point `share` of the way along it."""

    def apply(wear: Wear, arm: Arm, s: float) -> Done:
        along = arm.after[k - 1][:3, 3]
        soft = 0.1 * s / float(wear.stiffness[min(k, arm.n - 1)])
        diagonal = soft * np.array([0, 0, 0, 1.2, 1.0, 0.8])
        flexure = Flexure(k, shift(share * along), np.diag(diagonal))
        names = ("rx", "ry", "rz")
        values = {f"compliance link-{k} {c} rad/(N*m)": float(v) for c, v in zip(names, diagonal[3:], strict=True)}
        return replace(wear, flexures=(*wear.flexures, flexure)), values

    law = f"three hinge springs at {share:g} of the way from joint {k} to frame {k}"
    return Ailment("link-compliance", (f"link-{k}",), law, apply, 0.5)


def tool() -> Ailment:
    """The flange yields in 6 directions, side force coupled with tilt."""

    def apply(wear: Wear, arm: Arm, s: float) -> Done:
        soft = 0.2 * s / float(wear.stiffness[4])
        C = np.diag([0.02, 0.03, 0.008, 1.0, 0.7, 0.5])
        C[0, 4] = C[4, 0] = 0.06
        C[1, 3] = C[3, 1] = -0.05
        flexure = Flexure(arm.n, arm.after[-1], soft * C)
        values = {f"compliance tool {i}{j} SI": soft * C[i, j] for i in range(6) for j in range(i, 6) if C[i, j]}
        return replace(wear, flexures=(*wear.flexures, flexure)), values

    return Ailment("tool-compliance", ("tool",), "a full 6x6 spring at the flange, x with ry and y with rx", apply, 0.5)


def thermal(links: tuple[int, ...], joint: int | None = None) -> Ailment:
    """Links grow with temperature; a joint may creep with them."""

    def apply(wear: Wear, arm: Arm, s: float) -> Done:
        growth = wear.growth.copy()
        growth[list(links)] += 1e-5 * s
        worn, values = replace(wear, growth=growth), {f"growth link-{k} 1/K": 1e-5 * s for k in links}
        if joint is None:
            return worn, values

        def law(at: Situation) -> Array:
            return only(arm.n, joint, 5e-6 * s * (at.moment.temperature - REFERENCE))

        return with_law(worn, law), values | {f"creep joint-{joint} rad/K": 5e-6 * s}

    where = tuple(f"link-{k}" for k in links) + (() if joint is None else (f"joint-{joint}",))
    law = "lengths of the links times 1 + a (temperature - 20)"
    return Ailment("thermal-drift", where, law + ("" if joint is None else "; a joint zero creeps as well"), apply)
