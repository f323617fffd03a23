"""The path without a correction beside the one that was solved: what both share is kept once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from compensator.path.planned_path import PlannedPath
from compensator.path.thinned_path import ThinnedPath, thinned_path
from compensator.process.milling.milling_load import MilledForce
from compensator.process.process import ProcessLoad
from compensator.solve.compensation import Compensation
from compensator.solve.made_command import MadeCommand
from toolpaths.columns import made_from

Floats = npt.NDArray[np.float64]


class ThinnedLoad(ProcessLoad):
    """The load of a path before poses were put in; wrenches that are those of the path with them are kept there."""

    def __init__(self, load: ProcessLoad, path: ThinnedPath, finer: ProcessLoad) -> None:
        wrench = finer.wrench
        self.__dict__.update(
            {name: value for name, value in vars(load).items() if name != "wrench"},
            _wrench=made_from(lambda: wrench[path.rows], load.wrench),
        )

    @property
    def wrench(self) -> Floats:
        """(N, 6) N and N*m on the robot, base axes, about the TCP."""
        return np.asarray(self.__dict__["_wrench"]())


class ThinnedForce(ThinnedLoad, MilledForce):
    """The same of a milled path."""


def thinned(plain: Compensation, finer: PlannedPath, load: ProcessLoad) -> Compensation:
    """``plain``, the nominal path commanded as it is, without what ``finer``, the same path with poses put in, and the
    ``load`` along it have as well. Where they differ by more than a few poses it stays what it is."""
    path = thinned_path(plain.path, finer)
    if path is None:
        return plain
    command, own = plain.command, plain.load
    kind = {ProcessLoad: ThinnedLoad, MilledForce: ThinnedForce}.get(type(own))
    return replace(
        plain, path=path, target=path.tcp, load=own if kind is None else kind(own, path, load),
        command=MadeCommand(
            q=lambda: path.q, actual=lambda: path.q, torque=command.torque, nominal=lambda q: path.tcp,
            error=command.error, extra=command.extra, steps=command.steps,
        ),
    )  # fmt: skip
