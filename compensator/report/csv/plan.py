"""A plan as CSV."""

from __future__ import annotations

import csv
import io

import numpy as np

from stiffness.planning.plan import Plan

WRENCH = ("fx", "fy", "fz", "mx", "my", "mz")


def plan_csv(plan: Plan) -> str:
    """A row per reading, in the order of the day."""
    n = plan.postures.q.shape[1]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([
        "setup", "state", "reflector", *(f"q{k + 1}_deg" for k in range(n)), *(f"approach{k + 1}" for k in range(n)),
        *WRENCH, "pull_x_mm", "pull_y_mm", "pull_z_mm",
    ])  # fmt: skip
    pool = plan.candidates
    for setup, c in enumerate(plan.chosen):
        q = np.degrees(plan.postures.q[pool.posture[c]])
        approach = plan.postures.approach[pool.posture[c]].astype(int)
        name = plan.design.reflectors[pool.reflector[c]].name
        for state, share in enumerate(plan.loading.steps):
            load = [f"{v + 0.0:.4f}" for v in pool.wrench[c] * share]
            at = [f"{v * 1e3:g}" for v in pool.pulled_at[c]]
            writer.writerow([setup + 1, state, name, *(f"{v:.4f}" for v in q), *approach.tolist(), *load, *at])
    return text.getvalue()
