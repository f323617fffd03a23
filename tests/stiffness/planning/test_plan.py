"""Plans, judged by what an independent plant shows when they are measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stiffness.effects import BY_NAME
from stiffness.errors import StiffnessError
from stiffness.identification.readings import ReadingModel
from stiffness.identify import identify
from stiffness.planning.design import Design, Loading, planned_layout
from stiffness.planning.plan import Plan, choose, condition_number
from stiffness.planning.postures import FLOOR, MARGIN, PosturePool, link_frames, reachable_postures
from stiffness.robot.load import load_robot
from stiffness.robot.robot import STANDARD_GRAVITY
from stiffness.session.file import Instruments, Reflector
from stiffness.session.session import Session, load_session
from stiffness.statics.predictor import Predictor
from stiffness.statics.tool import Tool
from tests.plant.lab import Form, Setup, Step, Target, measure
from tests.plant.lab_design import random_setups
from tests.stiffness.bench_lab import FORCE, Lab

ROBOT = "abb-irb6600-175-255"
GRAVITY = np.array(STANDARD_GRAVITY)
TOOL = Tool(np.eye(3), np.array([0.02, -0.01, 0.25]), 5.0, np.array([0.01, 0.0, 0.12]))
REFLECTORS = (
    Reflector(name="tcp", link=6, position=np.array([0.02, -0.01, 0.25]), exact=True, group=None),
    Reflector(name="side", link=6, position=np.array([0.15, 0.0, 0.2]), exact=True, group=None),
    Reflector(name="elbow", link=3, position=np.array([0.1, 0.1, 0.1]), exact=True, group=None),
)
TARGETS = [Target(r.name, r.link, r.position) for r in REFLECTORS]
WRONG = np.array([1.5, 0.7, 1.3, 0.6, 1.4, 0.7])  # a model to plan with is not the truth


def design(
    stiffness: np.ndarray, gap: np.ndarray | None = None, reflectors: Sequence[Reflector] = REFLECTORS
) -> Design:
    values = {"joint-stiffness": {"k_nm_per_rad": stiffness}}
    if gap is not None:
        values["backlash"] = {"gap_rad": gap, "breakaway_nm": np.zeros(6), "side": np.ones(6)}
    effects = [BY_NAME[name] for name in values]
    robot = load_robot(ROBOT)
    reading = ReadingModel(robot, planned_layout(effects, 6), values, TOOL, gravity=GRAVITY, calibrated_out=False)
    return Design(reading, values, reflectors)


def loading(*levels: float) -> Loading:
    return Loading(FORCE[ROBOT], levels or (1.0,), Instruments(2e-5, None, 0.3, 0.1))


def postures(count: int, seed: int) -> PosturePool:
    return reachable_postures(load_robot(ROBOT), TOOL, count, seed)


def carried_out(plan: Plan, lab: Lab, folder: Path, seed: int) -> Session:
    """The plan as the plant answers it, with the planned readings only."""
    pool, setups = plan.candidates, []
    for c in plan.chosen:
        steps = [Step(pool.wrench[c, :3] * s, pool.wrench[c, 3:] * s) for s in plan.loading.steps]
        k = pool.posture[c]
        setups.append(Setup(plan.postures.q[k], 0.1 * plan.postures.approach[k], steps))
    session = load_session(measure(lab.plant(), setups, TARGETS, seed=seed).write(folder, ROBOT))
    s = session.samples
    return session.take(pool.reflector[plan.chosen][s.setup - 1] == s.reflector)


def random_session(lab: Lab, folder: Path, seed: int, setups: int) -> Session:
    plan = random_setups(lab.plant().arm, setups, seed, force=FORCE[ROBOT], levels=(0.4, 1.0))
    return load_session(measure(lab.plant(), plan, TARGETS, seed=seed + 500).write(folder, ROBOT))


class HeldOut:
    """Poses that no plan has seen, with loads in all directions."""

    def __init__(self, seed: int, count: int = 150) -> None:
        self.q = postures(count, seed).q
        way = np.random.default_rng(seed).normal(size=(count, 3))
        force = FORCE[ROBOT] * way / np.linalg.norm(way, axis=1, keepdims=True)
        self.wrench = np.hstack([force, np.zeros((count, 3))])

    def deflected(self, stiffness: np.ndarray) -> np.ndarray:
        values = {"joint-stiffness": {"k_nm_per_rad": stiffness}}
        p = Predictor(load_robot(ROBOT), [BY_NAME["joint-stiffness"]], values, TOOL, gravity=GRAVITY)
        return p.forward(self.q, self.wrench, np.zeros((len(self.q), 0))).position

    def error(self, session: Session, truth: np.ndarray) -> float:
        """m, RMS error of the model that a session gives."""
        k = identify([session], ["joint-stiffness"]).values()["joint-stiffness"]["k_nm_per_rad"]
        off = self.deflected(k) - self.deflected(truth)
        return float(np.sqrt(np.mean(np.sum(off**2, axis=1))))

    def matters(self, d: Design) -> np.ndarray:
        return d.of_path(self.q, self.wrench, np.zeros((len(self.q), 0)))


def test_a_third_of_the_readings_reaches_the_error_of_a_random_plan(tmp_path: Path) -> None:
    """36 planned readings against 120 random ones, planned with stiffnesses that are up to 50 % off."""
    lab, held = Lab(), HeldOut(999)
    d, truth = design(lab.stiffness * WRONG), design(lab.stiffness)
    other = HeldOut(5).matters(d)  # a path elsewhere, for V
    nothing, matters = np.zeros((6, 6)), held.matters(truth)
    errors: dict[str, list[float]] = {"D": [], "V": [], "random": []}
    expected: dict[str, list[float]] = {"D": [], "V": [], "random": []}
    for seed in range(6):
        pool = postures(200, seed)
        known = choose(design=d, postures=pool, loading=loading(), count=12, before=nothing)
        path = choose(design=d, postures=pool, loading=loading(), count=12, before=nothing, matters=other)
        made = {
            "D": carried_out(known, lab, tmp_path / f"d{seed}", seed + 50),
            "V": carried_out(path, lab, tmp_path / f"v{seed}", seed + 50),
            "random": random_session(lab, tmp_path / f"r{seed}", seed + 7, 8),
        }
        assert len(made["D"]) == len(made["V"]) == 36
        assert len(made["random"]) == 120
        for name, session in made.items():
            errors[name].append(held.error(session, lab.stiffness))
            covariance = np.linalg.inv(truth.measured(session) + 1e-6 * np.eye(6))
            expected[name].append(float(np.sqrt(np.trace(matters @ covariance))))
    mean = {name: float(np.mean(e)) for name, e in errors.items()}
    hoped = {name: float(np.mean(e)) for name, e in expected.items()}
    assert mean["D"] < mean["random"]
    assert mean["V"] < mean["random"]
    assert np.median(expected["D"]) < min(expected["random"])
    assert hoped["V"] < hoped["D"] < 0.9 * hoped["random"]


GAP = np.array([1.2e-4, 1.0e-4, 1.2e-4, 2.2e-4, 3.2e-4, 4.4e-4])


@pytest.mark.parametrize("gap", [None, GAP], ids=["springs", "gaps"])
def test_what_a_plan_promises_a_session_holds(gap: np.ndarray | None, tmp_path: Path) -> None:
    """Two ways to the same information: the plan's own, and that of the readings the plant gave."""
    lab = Lab(gap=None if gap is None else tuple(gap))
    d = design(lab.stiffness, gap)
    size = len(d.layout)
    plan = choose(design=d, postures=postures(40, 1), loading=loading(0.4, 1.0), count=8, before=np.zeros((size, size)))
    session = carried_out(plan, lab, tmp_path, 3)
    promised, held = plan.sd(plan.after), plan.sd(d.measured(session))
    assert held == pytest.approx(promised, rel=0.05)
    assert np.all(promised[:6] < 0.05)
    assert np.linalg.slogdet(d.measured(session))[1] == pytest.approx(np.linalg.slogdet(plan.after)[1], abs=0.5)


def test_exchange_beats_chance_and_uses_every_posture_once() -> None:
    d = design(Lab().stiffness)
    plan = choose(design=d, postures=postures(30, 2), loading=loading(), count=5, before=np.zeros((6, 6)))
    used = plan.candidates.posture[plan.chosen]
    assert len(np.unique(used)) == 5
    best = np.linalg.slogdet(plan.after + np.eye(6))[1]
    rng = np.random.default_rng(0)
    for _ in range(3000):
        some = plan.candidates.information[rng.choice(len(plan.candidates.posture), 5)].sum(axis=0)
        assert np.linalg.slogdet(some + np.eye(6))[1] < best
    # no single swap is better: of the whole pool, each in a new posture
    for k in range(5):
        others = np.delete(plan.chosen, k)
        rest = plan.candidates.information[others].sum(axis=0) + np.eye(6)
        free = ~np.isin(plan.candidates.posture, plan.candidates.posture[others])
        assert np.linalg.slogdet(rest + plan.candidates.information[free])[1].max() <= best + 1e-5


def test_what_was_measured_counts_and_the_plan_goes_for_the_rest(tmp_path: Path) -> None:
    lab = Lab()
    d = design(lab.stiffness)
    session = random_session(lab, tmp_path / "a", 3, 10)
    elbow = d.measured(session.take(session.samples.reflector == 2))
    plan = choose(design=d, postures=postures(60, 3), loading=loading(), count=3, before=elbow)
    assert plan.undetermined(plan.before) == [
        f"torsional stiffness per joint (joint-stiffness) of joint {k}" for k in (4, 5, 6)
    ]
    assert plan.undetermined(plan.after) == []
    assert np.all(plan.sd(plan.after) < plan.sd(plan.before))
    assert np.all(plan.candidates.reflector[plan.chosen] != 2)
    afresh = choose(design=d, postures=postures(60, 3), loading=loading(), count=3, before=np.zeros((6, 6)))
    assert np.all(plan.sd(plan.after)[3:] <= 1.06 * afresh.sd(afresh.after)[3:])
    assert (condition_number(elbow) or 0) > 1e4
    assert condition_number(np.zeros((6, 6))) is None
    assert condition_number(np.diag([4.0, 1.0, 0.25])) == pytest.approx(4.0)
    # the tracker's own pose costs information, and is not counted as if it were known
    moved = load_session(
        measure(lab.plant(), random_setups(lab.plant().arm, 10, 3, force=800.0, levels=(0.4, 1.0)), TARGETS,
                form=Form(registered=False), seed=503).write(tmp_path / "b", ROBOT)
    )  # fmt: skip
    known, placed = d.measured(session), d.measured(moved)
    assert np.linalg.slogdet(placed)[1] < np.linalg.slogdet(known)[1]
    assert np.linalg.slogdet(placed)[1] > np.linalg.slogdet(known)[1] - 2


def test_a_link_that_no_reflector_sees_stays_unknown_and_is_named() -> None:
    d = design(Lab().stiffness, reflectors=REFLECTORS[2:])
    plan = choose(design=d, postures=postures(40, 4), loading=loading(), count=6, before=np.zeros((6, 6)))
    assert [words[-1] for words in plan.undetermined(plan.after)] == ["4", "5", "6"]
    with pytest.raises(StiffnessError, match=r"--count 41: expected 1 \.\.\. 40"):
        choose(design=d, postures=postures(40, 4), loading=loading(), count=41, before=np.zeros((6, 6)))


@pytest.mark.parametrize("name", [ROBOT, "ur10"])
def test_postures(name: str) -> None:
    robot = load_robot(name)
    p, same, other = (reachable_postures(robot, TOOL, 100, seed) for seed in (8, 8, 9))
    assert np.array_equal(p.q, same.q)
    assert not np.array_equal(p.q, other.q)
    frames = link_frames(robot, p.q)
    for k in (0, 50, 99):
        assert frames[-1, k] == pytest.approx(robot.pose(p.q[k]), abs=1e-12)
        assert p.rotation[k] == pytest.approx(robot.pose(p.q[k])[:3, :3] @ TOOL.rotation, abs=1e-12)
    assert np.all(p.q - robot.lower > 0.99 * MARGIN)
    assert np.all(robot.upper - p.q > 0.99 * MARGIN)
    assert (frames[-1] @ np.append(TOOL.position, 1.0))[:, 2].min() > FLOOR
    sunk = robot.before.copy()
    sunk[0, 2, 3] -= 10.0
    with pytest.raises(StiffnessError, match="above the floor"):
        reachable_postures(replace(robot, before=sunk), TOOL, 100, 0)


def test_the_variance_of_a_path_by_finite_differences() -> None:
    k, held = Lab().stiffness, HeldOut(77, 40)
    matters = held.matters(design(k))
    for joint in range(6):
        step = 1 + 1e-4 * (np.arange(6) == joint)
        # in units of the compliance's own size: c -> c (1 + h)
        slope = (held.deflected(k / step) - held.deflected(k * step)) / 2e-4
        assert matters[joint, joint] == pytest.approx(np.mean(np.sum(slope**2, axis=1)), rel=1e-3)
