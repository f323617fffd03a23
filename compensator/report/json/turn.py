"""The turn about the tool axis that was chosen along a path, in the JSON report."""

from __future__ import annotations

import numpy as np

from compensator.path.chosen_turn import ChosenTurn, LeanWorth, TurnValue
from compensator.report.json.text import Report


def turn_report(chosen: ChosenTurn) -> Report:
    """What the choice was worth; ``constant`` is null where no constant turn serves."""
    windows, failed = chosen.windows
    return {
        "constant": None if chosen.constant is None else value_report(chosen.constant),
        "chosen": value_report(chosen.chosen),
        "windows": windows,
        "windows_failed": failed,
        **({} if chosen.lean is None else {"lean": _lean(chosen.lean)}),
    }


def _lean(lean: LeanWorth) -> Report:
    return {
        "upright": None if lean.upright is None else value_report(lean.upright),
        "max_deg": float(np.degrees(lean.most)),
        "mean_deg": float(np.degrees(lean.mean)),
        "allowed_deg": round(float(np.degrees(lean.cone)), 9),
        "largest_at": lean.place,
    }


def value_report(v: TurnValue) -> Report:
    """Of a path: the parts of its cost and what they come from."""
    parts = {"variance": v.variance, "crossings": v.crossings, "acceleration": v.acceleration}
    parts |= {name: price for name, price in (("lean", v.lean), ("axes", v.axes)) if price}
    parts["sum"] = v.cost
    return {
        "cost_um2": {name: value * 1e12 for name, value in parts.items()},
        "deflection_sd_um": v.sd * 1e6,
        "reversals_in_cut": v.reversals,
    }
