"""Counted twice: a mass that a model found at a tool beside what its session declared, and that is declared since."""

from __future__ import annotations

import numpy as np

from stiffness.model.model import ComplianceModel

KEY = "tool_mass_kg"  # of the provenance: tool -> what the sessions declared for it
REMEDY = "Identify again from that session with the mass declared in it, or declare the mass in one place only"
ALIKE = 0.2  # of a mass: a spindle with another holder is still the same spindle


def counted_twice(model: ComplianceModel, tool: str, mass: float) -> list[str]:
    """Sentences on masses of the model at a tool that its ``mass``, kg, as it is declared now, may hold too.

    They are alike where what is declared more than in the sessions differs from what was found by less than a fifth, or
    by less than three standard deviations.
    """
    declared = model.provenance.get(KEY, {})
    if not isinstance(declared, dict) or tool not in declared:
        return []
    more, told = mass - float(declared[tool]), []
    for effect in model.effects:
        if effect.mass is None or model.tools.get(effect.name) != tool:
            continue
        name = next(p.name for p in effect.parameters if p.unit == "kg")
        found = float(np.sum(model.values[effect.name][name]))
        doubt = 3.0 * float(np.nan_to_num(np.sum(model.sd.get(effect.name, {}).get(name, 0.0))))
        if more > 0 and abs(more - found) < max(ALIKE * found, doubt):
            told.append(
                f"{effect.name} of {found:.3g} kg was found at tool {tool!r} beside {declared[tool]:.3g} kg that its "
                f"sessions declared, and {mass:.3g} kg are declared here: if that holds the same mass, its weight "
                "counts twice"
            )
    return told
