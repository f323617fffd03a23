"""The JSON reports of ``clamped`` and ``datasheet``: models that no session made."""

from __future__ import annotations

from typing import Any

import numpy as np

from compensator.report.json.text import Report, known_numbers
from stiffness.effects import BASE, backlash
from stiffness.model.clamped import JointFit
from stiffness.model.model import ComplianceModel


def datasheet_report(made: ComplianceModel) -> Report:
    """The numbers of a model that reducer data make."""
    stiffness = made.values[BASE.name]["k_nm_per_rad"]
    known = made.identified.get(BASE.name, np.ones(len(stiffness), dtype=bool))
    sd = made.sd[BASE.name]["k_nm_per_rad"]
    report: Report = {
        "effects": [e.name for e in made.effects],
        "stiffness_nm_per_rad": known_numbers(stiffness, known),
        "stiffness_sd_nm_per_rad": known_numbers(sd, known),
        "identifiable": known.tolist(),
    }
    gap = backlash.EFFECT.name
    if gap in made.values:
        report["gap_rad"] = made.values[gap]["gap_rad"].tolist()
        report["gap_sd_rad"] = made.sd[gap]["gap_rad"].tolist()
    return report


def clamped_report(made: ComplianceModel, fits: tuple[JointFit, ...], joints: int) -> Report:
    """The model that clamped readings make, and what they tell of every joint of ``joints``; null where there are
    none."""
    by_joint = {f.joint: f for f in fits}

    def each(name: str) -> list[Any]:
        return [getattr(by_joint[k], name) if k in by_joint else None for k in range(joints)]

    return {
        "effects": [e.name for e in made.effects],
        "stiffness_nm_per_rad": each("stiffness"),
        "stiffness_sd_nm_per_rad": each("sd"),
        "identifiable": [k in by_joint for k in range(joints)],
        "stiffness_unloading_nm_per_rad": each("unloading"),
        "gap_rad": each("gap"),
        "gap_sd_rad": each("gap_sd"),
        "friction_in_gap": each("friction_in_gap"),
        "hysteresis_rad": each("hysteresis"),
        "largest_torque_nm": each("largest"),
        "misfit_nm": each("misfit"),
        "n_used": each("used"),
        "n_left_out": each("left_out"),
    }
