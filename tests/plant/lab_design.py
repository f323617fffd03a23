"""Random set-ups as a lab would choose them: reachable, above the floor, loads in all directions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .arm import Arm
from .geometry import Array
from .lab_request import Setup, Step
from .scene import Scene

TRIES = 10_000


def random_setups(
    arm: Arm,
    count: int,
    seed: int,
    *,
    force: float = 300.0,
    lever: float = 0.1,
    levels: Sequence[float] = (0.5, 1.0),
    directions: int = 2,
    preload: float = 0.0,
    payload: float = 0.0,
    pulls: Sequence[str | None] = (None,),
    move: tuple[float, float] = (0.03, 0.15),
) -> list[Setup]:
    """Set-ups with state 0 and, in each of some random directions, the load levels one after the other.

    force: N at level 1; lever: m, moments are up to force x lever (none on pulls). preload: N, a rope in state
    0, in the first direction. payload: kg, one more state that hangs it on. pulls: where the loads of the
    set-ups act in turn, None for the TCP. move: rad, size of the last move of every joint.
    """
    rng = np.random.default_rng(seed)
    scene = Scene(arm, gravity=False)
    setups = []
    for k in range(count):
        q, last = _posture(arm, scene, rng, move)
        pull = pulls[k % len(pulls)]
        ways = rng.normal(size=(directions, 3))
        ways /= np.linalg.norm(ways, axis=1, keepdims=True)
        twists = np.zeros((directions, 3)) if pull else rng.uniform(-lever, lever, (directions, 3))
        steps = [Step(preload * ways[0], pull=pull if preload else None) if directions else Step()]
        steps += [
            Step(force * level * way, force * level * twist, pull)
            for way, twist in zip(ways, twists, strict=True)
            for level in levels
        ]
        if payload:
            steps.append(Step(payload=payload))
        setups.append(Setup(q, last, tuple(steps)))
    return setups


def _posture(arm: Arm, scene: Scene, rng: np.random.Generator, move: tuple[float, float]) -> tuple[Array, Array]:
    """Angles (n,) and last move (n,), both ends of it inside the limits."""
    low, high = np.maximum(arm.lower, -np.pi) + move[1], np.minimum(arm.upper, np.pi) - move[1]
    reach = float(
        np.linalg.norm(arm.before[1:, :3, 3], axis=1).sum() + np.linalg.norm(arm.after[:, :3, 3], axis=1).sum()
    )
    for _ in range(TRIES):
        q = rng.uniform(low, high)
        last = rng.uniform(*move, size=arm.n) * rng.choice([-1.0, 1.0], size=arm.n)
        scene.move(q)
        places = np.vstack([scene.links()[2:, :3, 3], scene.tcp()[:3, 3]])
        aside = float(np.hypot(places[-1, 0], places[-1, 1]))
        bent = np.linalg.svd(scene.jacobian())[1][-1] > 0.05 if arm.n >= 6 else True
        if places[:, 2].min() > 0.1 and aside > 0.2 * reach and bent:
            return q, last
    raise ValueError(f"{arm.name}: no posture above the floor in {TRIES} tries")
