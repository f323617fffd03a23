"""The paper's experiment on the plant: the set-ups of Table 2, a dead weight over a pulley, tracker, force sensor.

Berntsen, Bertheussen, Tyapin, Combined Stiffness Identification of 6-DoF Industrial Robot, sections 2, 3 and 5. The
paper gives no reflector positions and no spindle (its figures show them without figures): POINTS and SPINDLE are
chosen here to sit where the captions say.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from . import Arm, Plant, Tool
from .arm import STANDARD_GRAVITY
from .geometry import Array
from .lab import Form, Noise, Notes, Setup, Step, Target, measure

ROBOT = "abb-irb6600-175-255"
TIP = "paper"  # Table 1 measures to a point 380 mm from the wrist centre
FILE = Path(__file__).parents[2] / "stiffness" / "robot" / "data" / f"{ROBOT}.toml"
RATIOS = np.array([1, 0.887, 0.6892, 0.141, 0.048, 0.0187])  # Table 3
CASES = (1.015, 0.758)  # Table 4: joint 1 pre-loaded and non-loaded, in the unit of Table 3
K1 = 2e6  # N*m/rad, assumed: the paper withholds it
ROPE = 20.120 * STANDARD_GRAVITY  # N: over a pulley it pulls the same whatever the arm does
NOISE = Noise(tracker=2e-5, force=0.3, torque=0.1)
QUIET = Noise(tracker=1e-10, force=0.0, torque=0.0)
SPINDLE = Tool((0.0, 0.0, 0.25), mass=35.0, com=(0.0, 0.0, 0.12))
MOVE = 0.1  # rad, every joint's last move

# m, in the frame of the link. Link 3: x along the upper arm's end, z along the forearm; link 4: z along axis 5;
# link 6 is the frame of the paper: z out of the flange, x down at home.
POINTS = {
    "base": Target("base", 1, (0.35, 0.2, 0.55)),  # on the turning base
    "pin": Target("pin", 2, (0.0, 0.0, 0.0)),  # middle of axis 3: the rope for joint 2
    "ring": Target("ring", 2, (0.0, 0.0, 0.2)),  # the ring of joint 3
    "elbow": Target("elbow", 3, (0.1, -0.15, 0.35)),  # on link 3, before axis 4
    "shoulder": Target("shoulder", 3, (0.1, -0.18, 0.4)),
    "wrist": Target("wrist", 4, (0.0, 0.0, 0.18)),  # on axis 5
    "spindle": Target("spindle", 6, (-0.05, 0.18, 0.2)),
    "tip": Target("tip", 6, (0.0, 0.0, 0.25)),  # the TCP: the rope is tied here
    "link": Target("link", 6, (0.4, 0.0, 0.25)),  # end of the external link: the rope for joint 6
}
UP, ALONG, ACROSS = np.eye(3)[[2, 0, 1]]
QUARTER = np.pi / 2


@dataclass(frozen=True)
class Trial:
    """A set-up for one joint: angles away from home, where and which way the rope pulls, the points A, B, C."""

    joint: int
    away: dict[int, float]
    tied: str
    way: Array
    points: tuple[str, ...]


TRIALS = (
    Trial(1, {}, "tip", ACROSS, ("base",)),
    Trial(2, {3: -np.pi / 6}, "pin", ALONG, ("ring",)),
    Trial(3, {5: QUARTER}, "tip", -UP, ("spindle",)),
    Trial(4, {4: QUARTER, 5: -QUARTER, 6: QUARTER}, "tip", -UP, ("elbow", "spindle")),
    Trial(5, {}, "tip", -UP, ("shoulder", "wrist", "spindle")),
    Trial(6, {5: QUARTER}, "link", ACROSS, ("spindle",)),
)
# a joint's angle of 1e-4 ... 2e-3 rad on 0.2 ... 1.3 m: repeats that bring its mean to about half a percent
REPEATS = (4000, 4000, 3000, 1500, 600, 1500)


def plant(k1: float = K1, ratio: float = 1.0) -> Plant:
    """The paper's robot: stiffness by Table 3, only joint 1 by ``k1``; ``ratio``: non-loaded over pre-loaded."""
    stiffness = RATIOS * K1
    stiffness[0] = k1
    return Plant(Arm.load(FILE, tool=SPINDLE, tip=TIP), stiffness=stiffness, ratio=ratio)


def table_3(
    *,
    noise: Noise = NOISE,
    repeats: Sequence[int] = REPEATS,
    seed: int = 0,
    trials: Sequence[Trial] = TRIALS,
    on: Plant | None = None,
    form: Form | None = None,
) -> Notes:
    """Sections 3 and 5: all joints pre-loaded, one set-up per joint."""
    arm = plant(ratio=CASES[1] / CASES[0]) if on is None else on
    pages = [
        _page(arm, trial, noise, repeats[trial.joint - 1], seed + k, 1.0, form or Form())
        for k, trial in enumerate(trials)
    ]
    return bound(pages, [_purpose(t) for t in trials])


def table_4(*, noise: Noise = NOISE, repeats: int = REPEATS[0], seed: int = 100) -> Notes:
    """Table 4: joint 1 jogged with the load (case 1) and against it (case 2)."""
    arm = plant(CASES[0] * K1, CASES[1] / CASES[0])
    pages = [_page(arm, TRIALS[0], noise, repeats, seed + k, side, Form()) for k, side in enumerate((1.0, -1.0))]
    return bound(pages, [_purpose(TRIALS[0])] * 2)


def _page(arm: Plant, trial: Trial, noise: Noise, repeats: int, seed: int, side: float, form: Form) -> Notes:
    """One set-up, with readings of its own points alone."""
    q = np.zeros(arm.arm.n)
    for joint, angle in trial.away.items():
        q[joint - 1] = angle
    names = [n for n in POINTS if n in (*trial.points, trial.tied)]
    targets = [POINTS[n] for n in names]
    steps = (Step(), Step(force=ROPE * trial.way, pull=trial.tied))

    def read(move: Array, noise: Noise, repeats: int) -> Notes:
        written = replace(form, repeats=repeats)
        return measure(arm, [Setup(q, move, steps)], targets, noise=noise, form=written, seed=seed)

    loaded = read(np.full(arm.arm.n, MOVE), QUIET, 1).truth.walk.torque[-1]
    # jogged the way the joint is pushed, by gravity and load: pre-loaded
    toward = np.where(np.abs(loaded) > 1e-6, np.sign(loaded), 1.0)
    toward[trial.joint - 1] *= side
    notes = read(MOVE * toward, noise, repeats)
    rows = [row for row in notes.rows if row["reflector"] in trial.points]
    return replace(notes, rows=rows)


def _purpose(trial: Trial) -> dict[str, Any]:
    return {"purpose": f"joint-{trial.joint}", "points": dict(zip("ABC", trial.points, strict=False))}


def bound(pages: Sequence[Notes], purposes: Sequence[dict[str, Any]]) -> Notes:
    """Set-ups that were measured one by one as one session; ``truth`` is that of the first."""
    rows = [{**row, "setup": k + 1} for k, page in enumerate(pages) for row in page.rows]
    reflectors = {name: table for page in pages for name, table in page.table["reflectors"].items()}
    setups = {str(k + 1): p for k, p in enumerate(purposes)}
    return Notes({**pages[0].table, "tip": TIP, "reflectors": reflectors, "setups": setups}, rows, pages[0].truth)
