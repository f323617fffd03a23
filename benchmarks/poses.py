"""Poses per second of prediction and solve, against the naive loop on the same model."""

from __future__ import annotations

import statistics
from collections.abc import Iterator

import numpy as np

from benchmarks.rig import Floats, Rig, Task, flange, rig, task
from benchmarks.table import Row
from benchmarks.timing import cores, hashing, interleaved, on_cores, ratio
from stiffness.statics.prediction import Command

ABB = "abb-irb6600-175-255"
MANY, FEW = 100_000, 200  # poses of the product and of the loop in one round
ROUNDS = 7


def command(rig: Rig, task: Task) -> Command:
    """The product: commands and everything that comes with them."""
    return rig.predictor.command(task.tcp, task.wrench, np.zeros((len(task), 0)), task.start)


def whole_chain(rig: Rig, task: Task) -> Command:
    """Nominal inverse kinematics, then the command."""
    batch = rig.inverse.along(flange(rig, task.tcp), task.branch, task.start[0])
    none = np.zeros((len(task), 0))
    return rig.predictor.command(task.tcp, task.wrench, none, batch.q)


def forward(rig: Rig, task: Task) -> Floats:
    """Deflected TCP positions of the nominal commands."""
    return rig.predictor.forward(task.start, task.wrench, np.zeros((len(task), 0))).position


def naive_command(rig: Rig, task: Task) -> Floats:
    """The loop: each solve from the nominal angles."""
    arm = rig.naive
    given = zip(task.rotation, task.position, task.wrench, task.start, strict=True)
    return np.array([arm.command(r, p, w, q) for r, p, w, q in given])


def naive_least_squares(rig: Rig, task: Task) -> Floats:
    """The loop with the other solver of scipy."""
    arm = rig.naive
    given = zip(task.rotation, task.position, task.wrench, task.start, strict=True)
    return np.array([arm.command_by_least_squares(r, p, w, q) for r, p, w, q in given])


def naive_chain(rig: Rig, task: Task) -> Floats:
    """The loop without inverse kinematics: each solve from the command before."""
    q, commands = task.start[0], []
    for r, p, w in zip(task.rotation, task.position, task.wrench, strict=True):
        q = rig.naive.command(r, p, w, q)
        commands.append(q)
    return np.array(commands)


def naive_closed_form(rig: Rig, task: Task) -> Floats:
    """The loop with the closed form of joint springs: Pinocchio alone."""
    return np.array([rig.naive.closed_form(q, w) for q, w in zip(task.start, task.wrench, strict=True)])


def naive_forward(rig: Rig, task: Task) -> Floats:
    """The loop: deflected TCP positions."""
    return np.array([rig.naive.forward(q, w)[1] for q, w in zip(task.start, task.wrench, strict=True)])


def run(many: int = MANY, few: int = FEW, rounds: int = ROUNDS) -> Iterator[Row]:
    """All of it."""
    yield from joint_model(many, few, rounds)
    yield from model("joint hardening and a spring at the flange", rig(ABB, richer=True), many, few, rounds, "300")
    yield from model("gravity taken off by the controller", rig(ABB, calibrated_out=True), many, few, rounds)
    yield from model("ur10: no spherical wrist", rig("ur10"), many, few, rounds, "1000")


def joint_model(many: int, few: int, rounds: int) -> Iterator[Row]:
    """Joint springs and gravity: every part of it."""
    group = f"joint springs ({ABB}, gravity; {many:,} poses, the loop {few})"
    arm = rig(ABB)
    path = task(arm, many)
    some = path.first(few)
    seconds = interleaved(
        {
            "command": on_cores(1, lambda: command(arm, path)),
            "command 2": on_cores(2, lambda: command(arm, path)),
            "forward": on_cores(1, lambda: forward(arm, path)),
            "chain": on_cores(1, lambda: whole_chain(arm, path)),
            "chain 2": on_cores(2, lambda: whole_chain(arm, path)),
            "root": lambda: naive_command(arm, some),
            "least squares": lambda: naive_least_squares(arm, some),
            "from before": lambda: naive_chain(arm, some),
            "closed": lambda: naive_closed_form(arm, some),
            "loop forward": lambda: naive_forward(arm, some),
            "hash": lambda: hashing(1),
            "hash 2": lambda: hashing(2),
        },
        rounds,
    )
    each = many / few

    def against(loop: str, fast: str) -> float:
        return ratio(seconds[loop], seconds[fast]) * each

    def rate(name: str, count: int) -> float:
        return count / statistics.median(seconds[name])

    yield Row(group, "loop, scipy least_squares", rate("least squares", few), "poses/s")
    yield Row(group, "loop, scipy root", rate("root", few), "poses/s")
    yield Row(group, "command, all outputs, 1 thread", rate("command", many), "poses/s")
    yield Row(group, "  against the loop, least_squares", against("least squares", "command"), "x", "1000")
    yield Row(group, "  against the loop, root", against("root", "command"), "x", "1000")
    yield Row(group, "  against the closed form in a loop", against("closed", "command"), "x")
    with cores(2) as got:
        pass
    if got == 2:
        yield Row(group, "  2 threads against 1", ratio(seconds["command"], seconds["command 2"]), "x", "1.9")
    yield Row(group, "forward, all outputs, 1 thread", rate("forward", many), "poses/s")
    yield Row(group, "  against the loop", against("loop forward", "forward"), "x")
    yield Row(group, "inverse kinematics + command, 1 thread", rate("chain", many), "poses/s")
    yield Row(group, "  against the loop from pose to pose", against("from before", "chain"), "x")
    if got == 2:
        yield Row(group, "  2 threads against 1", ratio(seconds["chain"], seconds["chain 2"]), "x")
        free = ratio(seconds["hash"], seconds["hash 2"])
        yield Row(group, "plain hashing, 2 threads against 1", free, "x", "2 on a free machine")


def model(what: str, arm: Rig, many: int, few: int, rounds: int, goal: str = "") -> Iterator[Row]:
    """A model for which Newton steps are needed, or another arm."""
    path = task(arm, many)
    some = path.first(few)
    steps = command(arm, path).steps
    group = f"{what} ({arm.robot.name}; {steps} Newton steps)"
    seconds = interleaved(
        {
            "command": on_cores(1, lambda: command(arm, path)),
            "forward": on_cores(1, lambda: forward(arm, path)),
            "chain": on_cores(1, lambda: whole_chain(arm, path)),
            "root": lambda: naive_command(arm, some),
            "from before": lambda: naive_chain(arm, some),
            "loop forward": lambda: naive_forward(arm, some),
        },
        rounds,
    )
    each = many / few
    yield Row(group, "loop, scipy root", few / statistics.median(seconds["root"]), "poses/s")
    yield Row(group, "command, all outputs, 1 thread", many / statistics.median(seconds["command"]), "poses/s")
    yield Row(group, "  against the loop", ratio(seconds["root"], seconds["command"]) * each, "x", goal)
    yield Row(group, "  forward against the loop", ratio(seconds["loop forward"], seconds["forward"]) * each, "x")
    chain = ratio(seconds["from before"], seconds["chain"]) * each
    yield Row(group, "  inverse kinematics + command against the loop", chain, "x")
