"""Every kind of process that [process] of a cell may name. A new one is one file and one entry here."""

from __future__ import annotations

from compensator.process.constant import ConstantTable
from compensator.process.process import ProcessTable
from compensator.process.table import FileTable

PROCESSES: dict[str, type[ProcessTable]] = {"constant": ConstantTable, "table": FileTable}
