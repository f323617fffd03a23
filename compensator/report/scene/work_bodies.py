"""What stands in the work object, as bodies."""

from __future__ import annotations

from compensator.process.acting_process import ActingProcess
from compensator.process.milling.milling_load import MillingLoad
from compensator.process.process import Process, ProcessLoad
from compensator.report.scene.drawn_body import DrawnBody


def work_bodies(process: Process, load: ProcessLoad) -> list[DrawnBody]:
    """Bodies in the work object; none where nothing is milled."""
    if not isinstance(load, MillingLoad):
        return []
    from compensator.report.scene.stock_bodies import stock_bodies  # loads the compiler of the kernels

    return stock_bodies(process.said if isinstance(process, ActingProcess) else process, load)
