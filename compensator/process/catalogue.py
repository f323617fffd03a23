"""Every kind of process that [process] of a cell may name. A new one is one file and one entry here."""

from __future__ import annotations

from compensator.process.constant import ConstantWrenchTable
from compensator.process.milling.milling_table import MillingTable
from compensator.process.process import ProcessTable
from compensator.process.table import WrenchFileTable

PROCESSES: dict[str, type[ProcessTable]] = {
    "constant": ConstantWrenchTable,
    "table": WrenchFileTable,
    "milling": MillingTable,
}
