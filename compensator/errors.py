"""What goes wrong between a toolpath and a robot."""

from __future__ import annotations


class CompensatorError(Exception):
    """A job is refused. The message names the file or pose, the value, the bound and the remedy."""


class OutputError(CompensatorError):
    """An output of a run would be written over one of its inputs."""


class CellError(CompensatorError):
    """A cell file is refused."""


class PathError(CompensatorError):
    """The robot cannot follow the toolpath."""


class SolveError(CompensatorError):
    """The compensation of a pose is refused or did not converge."""


class DeviceError(CompensatorError):
    """A file of a measuring device is refused."""


class TraceError(CompensatorError):
    """A trace of a program that ran is refused."""
