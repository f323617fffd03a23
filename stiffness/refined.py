"""The refined model: the one at hand with what a diagnosis found in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stiffness.additions import Addition
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
    return replace(model, values=values, sd=sd, tools=tools, correlations=None)

