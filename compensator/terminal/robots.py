"""The built-in robots as a table, and one robot; shown when piped too."""

from __future__ import annotations

import numpy as np
from rich.console import Console

from compensator.terminal.screen import print_lines, table
from stiffness.model.model import builtin_model
from stiffness.robot.load import builtin_robots, load_robot

WIDTH = 110


def show_robots() -> None:
    """One line per built-in robot."""
    listed = table("name", "reach of the flange, mm", "stiffness set", "masses", title="built-in robots")
    for name in builtin_robots():
        robot = load_robot(name)
        links = np.concatenate([robot.before[1:, :3, 3], robot.after[:, :3, 3]])
        reach = np.linalg.norm(links, axis=1).sum()
        masses = "yes" if robot.mass is not None else "no"
        if any("mass" in a for a in robot.assumptions):
            masses = "assumed"
        stiffness = "published" if builtin_model(name) else "none"
        listed.add_row(name, f"{reach * 1e3:.0f} (links in line)", stiffness, masses)
    Console(width=WIDTH, markup=False).print(listed)


def show_robot(name: str) -> None:
    """Limits, masses, sources and assumptions of a robot."""
    robot = load_robot(name)
    console = Console(width=WIDTH, markup=False)
    console.print(repr(robot), highlight=False)
    heads = ("joint", "limits, deg", "speed, deg/s", "mass, kg", "centre of mass in its link frame, mm")
    joints = table(*heads)
    lower, upper, speed = (np.degrees(v) for v in (robot.lower, robot.upper, robot.velocity))
    for k in range(robot.n):
        cells = [
            robot.joint_names[k],
            f"{lower[k]:.1f} ... {upper[k]:.1f}",
            f"{speed[k]:.0f}" if np.isfinite(speed[k]) else "unknown",
            "unknown" if robot.mass is None else f"{robot.mass[k]:.1f}",
            "unknown" if robot.com is None else ", ".join(f"{v * 1e3:.0f}" for v in robot.com[k]),
        ]
        joints.add_row(*cells)
    console.print(joints)
    if robot.mass_problem:
        console.print(f"masses: {robot.mass_problem}", highlight=False)
    print_lines(console, (f"assumption: {text}" for text in robot.assumptions))
    print_lines(console, (f"source: {text}" for text in robot.sources))
