"""Counted twice: a mass that a model found at a tool, and that the tool is declared with since."""

from __future__ import annotations

import numpy as np

from stiffness.model.model import ComplianceModel
from stiffness.statics.tool import Tool

REMEDY = "Identify again from that session with the mass declared in it, or declare the mass in one place only"
ALIKE = 0.2  # of a mass: a spindle with another holder is still the same spindle


def counted_twice(model: ComplianceModel, tool: Tool) -> list[str]:
    """Sentences on masses of the model at this tool that may be what the tool is declared with.

    They are alike where they differ by less than a fifth, or by less than three standard deviations.
    """
    told = []
    for effect in model.effects:
        if effect.mass is None or model.tools.get(effect.name) != tool.name:
            continue
        mass = next(p.name for p in effect.parameters if p.unit == "kg")
        found = float(np.sum(model.values[effect.name][mass]))
        sd = model.sd.get(effect.name, {}).get(mass)
        doubt = 0.0 if sd is None else 3.0 * float(np.nan_to_num(np.sum(sd)))
        if tool.mass and abs(tool.mass - found) < max(ALIKE * tool.mass, doubt):
            told.append(
                f"{effect.name} of {found:.3g} kg was found beside what its session declared for tool {tool.name!r}, "
                f"and {tool.mass:.3g} kg are declared here: if they are the same mass, its weight counts twice"
            )
    return told
