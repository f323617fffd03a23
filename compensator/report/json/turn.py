"""The turn about the tool axis that was chosen along a path, in the JSON report."""

from __future__ import annotations

from compensator.path.chosen_turn import ChosenTurn, TurnValue
from compensator.report.json.text import Report


def turn_report(chosen: ChosenTurn) -> Report:
    """What the choice was worth; ``constant`` is null where no constant turn serves."""
    windows, failed = chosen.windows
    return {
        "constant": None if chosen.constant is None else _value(chosen.constant),
        "chosen": _value(chosen.chosen),
        "windows": windows,
        "windows_failed": failed,
    }


def _value(v: TurnValue) -> Report:
    parts = {"variance": v.variance, "crossings": v.crossings, "acceleration": v.acceleration, "sum": v.cost}
    return {
        "cost_um2": {name: value * 1e12 for name, value in parts.items()},
        "deflection_sd_um": v.sd * 1e6,
        "reversals_in_cut": v.reversals,
    }
