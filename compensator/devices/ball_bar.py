"""Ball-bar files of Renishaw (.b5r): a closed format, refused with the way around it."""

from __future__ import annotations

from typing import NoReturn

from compensator.devices.readings import DeviceFile
from compensator.errors import DeviceError

NAME = "ball-bar"


def recognised(file: DeviceFile) -> bool:
    """By its suffix: of what is in it nothing is published."""
    return file.suffix == ".b5r"


def read(file: DeviceFile) -> NoReturn:
    """Refuse it.

    Raises:
        DeviceError: always.
    """
    raise DeviceError(
        f"{file.label}: is a ball-bar file of Renishaw, a closed format: have its software list the readings (angle "
        "and radius, or deviation, of every reading), save them as csv, and add a column index, the row of the program "
        "at each reading, as the samples.csv of `compensator plan --ballbar` has it. Then: compensator trace run.csv "
        '-o trace.toml --column index=index --column radius="Radius" --units mm --center X Y Z --radius 150'
    )
