"""The refined model: the one at hand with what a diagnosis found in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stiffness.diagnosis.added_effects import Addition
from stiffness.identification.fit import Fit
from stiffness.model.model import ComplianceModel
from stiffness.session.processes import in_words, process_of
from stiffness.session.session import Session


def refined_model(
    model: ComplianceModel, fit: Fit, free: Fit, additions: Sequence[Addition], removed: Sequence[str]
) -> ComplianceModel:
    """``model`` with the numbers of a fit, without the ``removed`` effects; standard deviations of ``free``, where
    nothing was held."""
    free_effects = {u.effect for u in free.unknowns.free}
    held = {e.name for e in free.unknowns.effects if e.name not in free_effects}
    gone = set(removed) - {e.name for e in fit.unknowns.effects}
    fitted = fit.model(model.robot, model.provenance)
    model = replace(
        model,
        values={e: v for e, v in model.values.items() if e not in gone},
        sd={e: v for e, v in model.sd.items() if e not in gone},
        identified={e: v for e, v in model.identified.items() if e not in gone and e not in free_effects},
        tools={e: v for e, v in model.tools.items() if e not in gone},
        processes={e: v for e, v in model.processes.items() if e not in gone},
    )
    values = {
        name: {k: np.array(v) for k, v in numbers.items()}
        for name, numbers in {**model.values, **fitted.values}.items()
    }
    deviations = {e: v for e, v in free.deviations().items() if e not in held}
    sd = {
        name: {k: np.array(v) for k, v in numbers.items()}
        for name, numbers in {**model.sd, **deviations}.items()
    }
    tools, processes = dict(model.tools), dict(model.processes)
    for a in additions:
        if a.effect.scope == "tool":
            tools[a.effect.name] = fit.sessions[0].session.tool.name
        if a.effect.scope == "process":
            processes[a.effect.name] = process_of([s.session for s in fit.sessions])
    identified = {**model.identified, **free.identified()}
    provenance = {**model.provenance, "not_identified": free.not_identified()}
    return replace(
        model,
        values=values,
        sd=sd,
        identified=identified,
        tools=tools,
        processes=processes,
        provenance=provenance,
        correlations=None,
    )


def given_way(model: ComplianceModel, sessions: Sequence[Session], additions: Sequence[Addition]) -> list[str]:
    """Notes on effects of the process that the refined model has for another material or cutter than ``model``: a model
    holds one of each effect."""
    now, notes = process_of(sessions), []
    for a in additions:
        before = model.processes.get(a.effect.name)
        if before is None or before == now:
            continue
        numbers = ", ".join(
            f"{name} = {[float(f'{v:.4g}') for v in values]}" for name, values in model.values[a.effect.name].items()
        )
        notes.append(
            f"{a.effect.name}: the refined model has that of {in_words(now)}, and no longer that of {in_words(before)} "
            f"({numbers}): a model holds one process per effect; keep {model.source} for {in_words(before)}"
        )
    return notes
