"""The table of devices: one entry each. Everything else about a device is in its file beside this one.

To add a device: its file with ``recognised`` and ``read``, its entry here, a row in docs/traces-from-devices.md, a
sample in tests/compensator/devices/device_samples.py. No device imports this module, nor another device.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

from compensator.errors import DeviceError

if TYPE_CHECKING:  # the command line reads the table to show its help
    from compensator.devices.readings import DeviceFile, DeviceReadings


@dataclass(frozen=True, kw_only=True)
class Device:
    """A kind of file that measuring devices write; its module is imported when it is first asked for.

    Attributes:
        name: as ``--from`` has it. module: its file. title: in messages and docs.
    """

    name: str
    module: str
    title: str

    def recognised(self, file: DeviceFile) -> bool:
        """Whether a file looks like it."""
        return bool(self._module().recognised(file))

    def read(self, file: DeviceFile) -> DeviceReadings:
        """What stands in a file.

        Raises:
            DeviceError: it is refused, by line.
        """
        made: DeviceReadings = self._module().read(file)
        return made

    def _module(self) -> Any:
        return import_module(f"compensator.devices.{self.module}")


#: In the order in which they are tried.
DEVICES = (
    Device(name="ball-bar", module="ball_bar", title="ball-bar file of Renishaw (.b5r)"),
    Device(name="qif", module="qif", title="QIF 3 results"),
    Device(name="spatial-analyzer", module="spatial_analyzer", title="SpatialAnalyzer point export"),
    Device(name="pc-dmis", module="pcdmis", title="PC-DMIS text report"),
    Device(name="probe-results", module="probe_results", title="Fusion, PowerInspect or Haas results (G800, G801)"),
    Device(name="csv", module="column_file", title="columns of text"),
)


def device_of(file: DeviceFile, name: str | None = None) -> Device:
    """The device of a file: that of a name, else the first that recognises it.

    Raises:
        DeviceError: none does.
    """
    if file.columns and name not in (None, "csv"):
        raise DeviceError(f"{file.label}: --column names columns of a csv, not of --from {name}; leave one of them out")
    if file.columns:
        name = "csv"
    if name is not None:
        return next(d for d in DEVICES if d.name == name)
    found = next((d for d in DEVICES if d.recognised(file)), None)
    if found is None:
        known = "; ".join(f"{d.name} ({d.title})" for d in DEVICES)
        raise DeviceError(
            f"{file.label}: no device known here writes such a file. Give --from with one of: {known}; or name the "
            'columns of a table: --column x="Heading of x" --column y=...'
        )
    return found
