"""The questions of `init`: asked on standard error where no option answers them."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import Any

import click

from compensator.cell.new_cut import CUTTER_EXAMPLE, NONE
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
#: Of the cut; an empty answer takes the default, and without a cutter the others are not asked for.
OF_THE_CUT = {
    "cutter": (f"Cutter: shape, diameter, flutes, length of edge, mm ({CUTTER_EXAMPLE}); several: 1=...; 2=...", NONE),
    "material": ("Material: a .toml file, or {materials}", ""),
    "stock": ("Stock in the frame of the CAM file, mm: a mesh, box X Y Z X Y Z, cylinder X Y RADIUS Z Z", "unknown"),
    "spindle_rpm": ("Spindle, 1/min, where the CAM file gives no S", ""),
}


def answered(given: Mapping[str, Any], languages: tuple[str, ...]) -> dict[str, str]:
    """The answers, asked for one by one where an option is None.

    Raises:
        CompensatorError: standard input ends before all that is needed is answered; names the options.
    """
    from compensator.process.milling.material import builtin_materials
    from stiffness.robot.load import builtin_robots

    known = {"robots": ", ".join(builtin_robots()), "languages": ", ".join(languages)}
    out = {name: str(value) for name, value in given.items() if value is not None}
    asked = [name for name in QUESTIONS if name not in out]
    for name in asked:
        question, example = QUESTIONS[name]
        try:
            words = f"{question} ({example.format(**known)})"
            out[name] = click.prompt(words, err=True, type=click.Choice(languages) if name == "controller" else str)
        except click.Abort:
            if _on_terminal():
                raise
            missing = ", ".join(f"--{option}" for option in QUESTIONS if option not in out)
            what = f"init: not answered: {missing}; give them as options, or answer on a terminal"
            raise CompensatorError(what) from None
    if asked or _on_terminal() or "cutter" in out:
        _ask_about_the_cut(out, ", ".join(builtin_materials()))
    return out


def _ask_about_the_cut(out: dict[str, str], materials: str) -> None:
    """What options do not tell, while there is somebody who answers."""
    for name, (question, default) in OF_THE_CUT.items():
        if name in out or (name == "spindle_rpm" and not _on_terminal()):
            continue
        try:
            words = question.format(materials=materials)
            out[name] = click.prompt(words, err=True, default=default, show_default=bool(default))
        except click.Abort:
            if _on_terminal():
                raise
            return
        if name == "cutter" and out[name].strip() in ("", NONE):
            return


def _on_terminal() -> bool:
    return sys.stdin is not None and sys.stdin.isatty()
