"""How many rows a program csv has: what an index of a trace counts."""

from __future__ import annotations

from compensator.devices.readings import DeviceFile
from compensator.errors import DeviceError

NEEDED = ("index", "kind", "q1_deg")


def program_rows(file: DeviceFile) -> int:
    """Rows of a program as compensate, preview or plan writes it as csv.

    Raises:
        DeviceError: it is another file.
    """
    heading, *rows = [line for line in file.lines if line.strip()]
    names = [name.strip() for name in heading.split(",")]
    if missing := [name for name in NEEDED if name not in names]:
        raise DeviceError(
            f"{file.label}: line 1: no column {', '.join(missing)}: expected the program as csv, as `compensator "
            "preview --csv` or compensate writes it"
        )
    return len(rows)
