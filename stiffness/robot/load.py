"""Robots by name or file: the built-in ones, robot TOML files and URDFs."""

from __future__ import annotations

from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path

from stiffness.errors import RobotError
from stiffness.robot import toml_file, urdf
from stiffness.robot.robot import Robot

JOINTS = 6


def builtin_robots() -> tuple[str, ...]:
    """Names of the built-in robots, sorted."""
    return tuple(sorted(_builtin_files()))


def load_robot(
    name_or_path: str, *, folder: Path | None = None, base: str | None = None, tip: str | None = None
) -> Robot:
    """Load a built-in robot, a robot TOML file or a URDF.

    Args:
        name_or_path: a name of ``builtin_robots()``, or a path to a .toml or .urdf file.
        folder: what a relative path starts from; default the working folder.
        base, tip: links of a URDF that poses lead from and to. Defaults: the link ``base`` if there
            is one, else the root; the last moving link. Of a robot TOML: ``tip`` may be one of its [tips].

    Raises:
        RobotError: no such robot, or its file is refused.
    """
    builtin = _builtin_files().get(name_or_path)
    if builtin is not None:
        return _checked(toml_file.read(builtin, label=f"built-in robot {name_or_path}", tip=tip), base)
    path = (folder or Path()) / name_or_path
    if path.suffix not in (".toml", ".urdf"):
        names = ", ".join(builtin_robots())
        raise RobotError(f"{name_or_path!r} is no robot: expected a path to a .toml or .urdf file, or one of {names}")
    if path.suffix == ".urdf":
        return _checked(urdf.read(path, base=base, tip=tip), None)
    return _checked(toml_file.read(path, label=str(path), tip=tip), base)


def _builtin_files() -> dict[str, Traversable]:
    return {f.name[:-5]: f for f in (files("stiffness") / "robot" / "data").iterdir() if f.name.endswith(".toml")}


def _checked(robot: Robot, base: str | None) -> Robot:
    """The robot, unless its base is not the one that was asked for or it has not six joints."""
    if base is not None and base != robot.base:
        raise RobotError(
            f"robot {robot.name} has the base {robot.base!r}, not {base!r}: only a URDF has links to choose from"
        )
    if robot.n != JOINTS:
        ends = f"{robot.base} and {robot.tip}"
        raise RobotError(f"robot {robot.name}: {robot.n} joints between {ends}, expected {JOINTS}")
    return robot
