"""The refined model: the one at hand with what a diagnosis found in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stiffness.additions import Addition
from stiffness.effects import BY_NAME
from stiffness.fit import Fit
from stiffness.model import ComplianceModel


def refined_model(model: ComplianceModel, fit: Fit, additions: Sequence[Addition]) -> ComplianceModel:
    """``model`` with the numbers of a fit; what the fit does not determine keeps value and deviation of the model."""
    fitted = fit.model(model.robot, model.provenance)
    values = {
        name: {k: np.array(v) for k, v in numbers.items()}
        for name, numbers in {**model.values, **fitted.values}.items()
    }
    sd = {name: {k: np.array(v) for k, v in numbers.items()} for name, numbers in {**model.sd, **fitted.sd}.items()}
    tools = dict(model.tools)
    for a in additions:
        if a.effect.scope == "tool":
            tools[a.effect.name] = fit.evidence[0].session.tool.name
    wrong = {name: BY_NAME[name].check(numbers) for name, numbers in values.items()}
    for name in [n for n, problem in wrong.items() if problem]:
        values[name], sd[name] = dict(_sound(name, values[name])), sd.get(name, {})
    return replace(model, values=values, sd=sd, tools=tools, correlations=None)


def _sound(name: str, values: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Values whose couplings are shrunk until the effect's own check has nothing against them."""
    out = dict(values)
    for _ in range(60):
        if not BY_NAME[name].check(out):
            break
        for p in BY_NAME[name].parameters:
            if p.neutral == 0 and p.low < 0:
                out[p.name] = 0.95 * out[p.name]
    return out
