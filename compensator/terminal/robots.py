"""The built-in robots as a table, and one robot; shown when piped too."""

from __future__ import annotations

import numpy as np
from rich.console import Console

from compensator.terminal.screen import print_lines, table
from stiffness.model.model import builtin_model, load_model
from stiffness.robot.load import builtin_robots, load_robot
from stiffness.robot.robot import Robot

WIDTH = 110


def show_robots() -> None:
    """One line per built-in robot."""
    listed = table("name", "reach by its maker, mm", "stiffness set", "masses", title="built-in robots")
    for name in builtin_robots():
        robot = load_robot(name)
        masses = "yes" if robot.mass is not None else "no"
        if any("mass" in a for a in robot.assumptions):
            masses = "assumed"
        listed.add_row(name, _reach(robot), _stiffness_set(name), masses)
    Console(width=WIDTH, markup=False).print(listed)


def _reach(robot: Robot) -> str:
    return "unknown" if robot.reach is None else f"{robot.reach * 1e3:.0f}"


def _stiffness_set(name: str) -> str:
    """The kind of the built-in set, in the word of its file."""
    path = builtin_model(name)
    return "none" if path is None else str(load_model(path).provenance["kind"])


def show_robot(name: str) -> None:
    """Limits, masses, sources and assumptions of a robot."""
    robot = load_robot(name)
    console = Console(width=WIDTH, markup=False)
    console.print(repr(robot), highlight=False)
    heads = ("joint", "limits, deg", "speed, deg/s", "acceleration, deg/s2", "mass, kg")
    joints = table(*heads, "centre of mass in its link frame, mm")
    unknown = np.full(robot.n, np.nan)
    given = (robot.lower, robot.upper, robot.velocity, unknown if robot.acceleration is None else robot.acceleration)
    lower, upper, speed, acceleration = (np.degrees(v) for v in given)
    for k in range(robot.n):
        cells = [
            robot.joint_names[k],
            f"{lower[k]:.1f} ... {upper[k]:.1f}",
            *(f"{v:.0f}" if np.isfinite(v) else "unknown" for v in (speed[k], acceleration[k])),
            "unknown" if robot.mass is None else f"{robot.mass[k]:.1f}",
            "unknown" if robot.com is None else ", ".join(f"{v * 1e3:.0f}" for v in robot.com[k]),
        ]
        joints.add_row(*cells)
    console.print(joints)
    console.print(f"reach by its maker: {_reach(robot)} mm", highlight=False)
    if robot.mass_problem:
        console.print(f"masses: {robot.mass_problem}", highlight=False)
    print_lines(console, (f"assumption: {text}" for text in robot.assumptions))
    print_lines(console, (f"source: {text}" for text in robot.sources))
    if name in builtin_robots() and (path := builtin_model(name)):
        print_lines(console, (f"stiffness set: {key}: {value}" for key, value in load_model(path).provenance.items()))
