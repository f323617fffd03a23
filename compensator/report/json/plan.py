"""The JSON report of ``plan``."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from compensator.report.json.text import MM, Report
from compensator.report.words.plan import plan_sentence
from stiffness.planning.plan import Plan, condition_number


def plan_report(plan: Plan, seed: int, notes: Sequence[str]) -> Report:
    """What is known of every parameter before and after the set-ups of a plan."""
    layout, design = plan.design.layout, plan.design
    value = np.where(layout.inverse, 1 / np.where(layout.inverse, design.vector, 1.0), design.vector)
    per_unit = design.scale * np.where(layout.inverse, value**2, 1.0)
    before, after = (plan.sd(m) * per_unit for m in (plan.before, plan.after))
    unsaid, open_ = plan.undetermined(plan.before), plan.undetermined(plan.after)
    parameters = []
    for k, u in enumerate(layout.free):
        name = f"{u.parameter.meaning} ({u.effect}) of joint {u.index + 1}"
        parameters.append({
            "effect": u.effect, "parameter": u.parameter.name, "joint": u.index + 1, "unit": u.parameter.unit,
            "value": float(value[k]), "sd_before": None if name in unsaid else float(before[k]),
            "sd_after": None if name in open_ else float(after[k]),
        })  # fmt: skip
    report: Report = {
        "criterion": "D" if plan.matters is None else "V",
        "n_setups": len(plan.chosen),
        "n_readings": plan.readings,
        "force_n": plan.loading.force,
        "levels": list(plan.loading.levels),
        "seed": seed,
        "parameters": parameters,
        "condition_number": {"before": condition_number(plan.before), "after": condition_number(plan.after)},
        "path_deflection_sd_mm": None,
        "undetermined": open_,
        "notes": list(notes),
        "sentence": plan_sentence(plan),
    }
    if plan.matters is not None:
        sds = {"before": plan.path_sd(plan.before), "after": plan.path_sd(plan.after)}
        report["path_deflection_sd_mm"] = {k: None if v is None else v * MM for k, v in sds.items()}
    return report
