"""The external axes that were chosen for a path, in the JSON report."""

from __future__ import annotations

from compensator.path.chosen_axes import AxisUse, ChosenAxes
from compensator.report.json.text import Report
from compensator.report.json.turn import value_report


def axes_report(chosen: ChosenAxes) -> Report:
    """Where each axis stands and what that was worth; ``constant`` is null where no constant place serves."""
    windows, failed = chosen.windows
    best = None
    if chosen.constant is not None:
        best = {"places": dict(chosen.constant_places), **value_report(chosen.constant)}
    return {
        "axes": {use.name: _use(use) for use in chosen.uses},
        "constant": best,
        "chosen": value_report(chosen.chosen),
        "windows": windows,
        "windows_failed": failed,
    }


def _use(use: AxisUse) -> Report:
    unit = use.unit
    return {
        "carries": use.carries,
        f"range_{unit}": list(use.range),
        f"least_{unit}": use.least,
        f"greatest_{unit}": use.greatest,
        f"travel_{unit}": use.travel,
        **({} if use.limits is None else {f"fastest_{unit}_per_s": use.fastest}),
        "moves": use.moves,
    }
