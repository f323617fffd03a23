"""The six questions of `init`: asked on standard error where no option answers them."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import Any

import click

from compensator.errors import CompensatorError

#: Option -> question, and an example or what there is.
QUESTIONS = {
    "robot": ("Which robot? A built-in name, or a .toml or .urdf file", "{robots}"),
    "tool": ("Tool: the tip of the cutter in the flange frame, x y z mm, and the mass in kg if known", "0 0 250 35"),
    "part": ("Zero of the CAM file in the base, x y z mm, then roll pitch yaw, deg, if turned", "1500 -100 800"),
    "cam": ("Which CAM file?", "part.nc"),
    "stiffness": ("Stiffness: a model file, a built-in set, or unknown", "unknown"),
    "controller": ("Which controller?", "{languages}"),
}


def answered(given: Mapping[str, Any], languages: tuple[str, ...]) -> dict[str, str]:
    """The answers, asked for one by one where an option is None.

    Raises:
        CompensatorError: standard input ends before all are answered; names the options.
    """
    from stiffness.robot.load import builtin_robots

    known = {"robots": ", ".join(builtin_robots()), "languages": ", ".join(languages)}
    out = {name: str(value) for name, value in given.items() if value is not None}
    for name, (question, example) in QUESTIONS.items():
        if name in out:
            continue
        try:
            words = f"{question} ({example.format(**known)})"
            out[name] = click.prompt(words, err=True, type=click.Choice(languages) if name == "controller" else str)
        except click.Abort:
            if sys.stdin is not None and sys.stdin.isatty():
                raise
            missing = ", ".join(f"--{option}" for option in QUESTIONS if option not in out)
            what = f"init: not answered: {missing}; give them as options, or answer on a terminal"
            raise CompensatorError(what) from None
    return out
