"""The refined model: the one at hand with what a diagnosis found in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stiffness.diagnosis.added_effects import Addition
from stiffness.identification.fit import Fit
from stiffness.model.model import ComplianceModel


def refined_model(model: ComplianceModel, fit: Fit, free: Fit, additions: Sequence[Addition]) -> ComplianceModel:
    """``model`` with the numbers of a fit; standard deviations of ``free``, where nothing was held."""
    fitted = fit.model(model.robot, model.provenance)
    values = {
        name: {k: np.array(v) for k, v in numbers.items()}
        for name, numbers in {**model.values, **fitted.values}.items()
    }
    sd = {
        name: {k: np.array(v) for k, v in numbers.items()}
        for name, numbers in {**model.sd, **free.deviations()}.items()
    }
    tools = dict(model.tools)
    for a in additions:
        if a.effect.scope == "tool":
            tools[a.effect.name] = fit.sessions[0].session.tool.name
    return replace(model, values=values, sd=sd, tools=tools, correlations=None)
