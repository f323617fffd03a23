"""Causes of the study: those of the plant for sessions, and what a shop adds: process, fixture, servos."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from tests.plant import ailments_body as body
from tests.plant import ailments_joint as joint
from tests.plant.ailment import Ailment, only
from tests.plant.ailments_joint import with_law
from tests.plant.ailments_unknown import ripple
from tests.plant.arm import Arm
from tests.plant.wear import Wear
from tests.traces_report.shop import KINDS, Kind, Shop

Done = tuple[Wear, Mapping[str, float]]


def force() -> Ailment:
    """Coefficients of the material are too small."""
    return Ailment("cutting-force", ("process",), "force times 1 + s", _shop("force", lambda s: 1 + s), 0.2)


def cutter() -> Ailment:
    """A cutter that is smaller than it is called."""
    return Ailment("cutter-size", ("cutter",), "s x 10 um left along the normal", _shop("left", lambda s: 1e-5 * s))


def softer(k: int) -> Ailment:
    """A joint whose spring has become softer."""

    def apply(wear: Wear, arm: Arm, s: float) -> Done:
        stiff = wear.stiffness.copy()
        stiff[k - 1] /= 1 + s
        return replace(wear, stiffness=stiff), {f"stiffness joint-{k} N*m/rad": float(stiff[k - 1])}

    return Ailment("joint-stiffness", (f"joint-{k}",), "stiffness K/(1+s)", apply, 0.2)


def lag(k: int) -> Ailment:
    """A servo that follows later the faster its joint turns."""

    def apply(wear: Wear, arm: Arm, s: float) -> Done:
        late = 1e-3 * s
        worn = with_law(wear, lambda at: only(arm.n, k, -late * at.moment.columns[f"speed{k}"]))
        return worn, {f"lag joint-{k} s": late}

    return Ailment("unknown", (f"joint-{k}", "speed"), f"joint {k} stays s ms x its speed behind", apply)


def fixture(way: str) -> Ailment:
    """A fixture that tips: on a spring, on a clamp that gives way as time goes on, or from one foot to the other."""
    laws = {
        "edge": ("turns about x by s x 1e-7 rad/(N*m) under the force", lambda s: s * np.array([1e-7, 0, 0])),
        "slip": ("turns about x by s x 0.1 mrad from the first row to the last", lambda s: 1e-4 * s),
        "rock": ("turns about x by s x 0.1 mrad, the way that the force pushes", lambda s: 1e-4 * s),
    }
    law, value = laws[way]
    return Ailment("unknown", ("fixture", way), law, _shop(way, value))


def _shop(name: str, value):  # type: ignore[no-untyped-def]
    def apply(wear: Wear, arm: Arm, s: float) -> Done:
        assert isinstance(wear, Shop)
        return replace(wear, **{name: value(s)}), {f"{name} process": s}

    return apply


@dataclass(frozen=True)
class Scenario:
    """One cause, two or none, seen by traces of one kind."""

    name: str
    kind: Kind
    causes: tuple[Ailment, ...] = ()


SEEN: Mapping[Kind, Mapping[str, Ailment]] = {
    "positions": {
        "softer joint-1": softer(1),
        "softer joint-3": softer(3),
        "backlash joint-1": joint.backlash(1, breakaway=np.inf),
        "backlash joint-3": joint.backlash(3, breakaway=np.inf),
        "preload-softening joint-1": joint.softening(1),
        "joint-friction joint-2": joint.friction(2),
        "joint-hardening joint-2": joint.hardening(2),
        "kinematic-offset joint-3": body.zero(3),
        "kinematic-offset link-3": body.geometry(3),
        "gravity-compensator": body.strut(),
        "payload": body.payload(),
        "base-compliance": body.base(),
        "tool-compliance": body.tool(),
        "thermal-drift link-2": body.thermal((2,)),
        "cutting-force": force(),
    },
    "ballbar": {
        "backlash joint-1": joint.backlash(1, breakaway=np.inf),
        "backlash joint-2": joint.backlash(2, breakaway=np.inf),
        "backlash joint-3": joint.backlash(3, breakaway=np.inf),
        "joint-friction joint-1": joint.friction(1),
        "joint-friction joint-2": joint.friction(2),
        "thermal-drift link-2": body.thermal((2,)),
    },
    "surface": {
        "softer joint-1": softer(1),
        "backlash joint-1": joint.backlash(1, breakaway=np.inf),
        "backlash joint-2": joint.backlash(2, breakaway=np.inf),
        "preload-softening joint-1": joint.softening(1),
        "joint-friction joint-1": joint.friction(1),
        "joint-friction joint-2": joint.friction(2),
        "base-compliance": body.base(),
        "tool-compliance": body.tool(),
        "cutting-force": force(),
        "cutter-size": cutter(),
    },
}
PAIRS: Mapping[Kind, tuple[tuple[str, str], ...]] = {
    "positions": (
        ("backlash joint-1", "cutting-force"),
        ("softer joint-3", "kinematic-offset link-3"),
    ),
    "ballbar": (("backlash joint-1", "joint-friction joint-2"), ("backlash joint-1", "thermal-drift link-2")),
    "surface": (("cutting-force", "cutter-size"), ("backlash joint-1", "cutter-size")),
}
UNKNOWN: Mapping[Kind, Mapping[str, Ailment]] = {
    "positions": {"servo lag joint-1": lag(1), "servo lag joint-2": lag(2), "ripple joint-3": ripple(3, 24)},
    "ballbar": {"servo lag joint-1": lag(1), "servo lag joint-2": lag(2), "servo lag joint-3": lag(3)},
    "surface": {f"fixture {way}": fixture(way) for way in ("edge", "slip", "rock")},
}
CLEAN = 5  # per kind and flow


def scenarios() -> list[Scenario]:
    """All of them."""
    out = []
    for kind in KINDS:
        out += [Scenario(name, kind, (cause,)) for name, cause in SEEN[kind].items()]
        out += [Scenario(f"{a} + {b}", kind, (SEEN[kind][a], SEEN[kind][b])) for a, b in PAIRS[kind]]
        out += [Scenario(f"unknown {name}", kind, (cause,)) for name, cause in UNKNOWN[kind].items()]
        out += [Scenario(f"clean {k + 1}", kind) for k in range(CLEAN)]
    return out
