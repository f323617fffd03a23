"""How a compensation becomes a program on the disk, and is read back from there: the contract of its two ways."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from compensator.cell.job import Job
from compensator.cell.placement import Placement
from compensator.errors import CellError
from compensator.solve.compensation import Compensation
from compensator.solve.verify import Verified
from stiffness.robot.tips import MAKERS
from toolpaths.finding import Finding
from toolpaths.toolpath import Toolpath


@dataclass(frozen=True, repr=False)
class MadeProgram:
    """A program on the disk.

    Attributes:
        files: staged, the program first.
        findings: about it.
        result: the commands that were written.
    """

    files: tuple[Path, ...]
    findings: tuple[Finding, ...]
    result: Compensation

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.files[0].name}, {len(self.findings)} findings)"

    @property
    def poses(self) -> npt.NDArray[np.intp]:
        """(M,) poses of ``result`` that stand in the program, in their order."""
        return np.arange(len(self.result))

    def verified(self) -> MadeProgram:
        """The same, without what only its verification asks for."""
        return self


def refuse_study_frame(job: Job) -> None:
    """Refuse to make a program for a tip that no controller has as its flange.

    Raises:
        CellError: names the tip, and the one to take.
    """
    robot = job.arm.robot
    if robot.tip_why:
        raise CellError(
            f"{job.placement.source}: tip = {robot.tip!r} of {robot.name}: {robot.tip_why}. No program is made for it: "
            "its tools would be off by the difference. Measure them from the maker's flange and take "
            f"tip = \"{MAKERS}\", or preview"
        )


def refuse_what_is_kept(job: Job, in_place: bool) -> None:
    """Refuse to lower feeds, or to lean the tool, where the program keeps those of its source.

    Raises:
        CellError: names the key, and what to do.
    """
    if in_place and job.placement.solve.feed == "limit":
        raise CellError(
            f'{job.placement.source}: solve.feed = "limit": a program that is filtered in place keeps its feeds; write '
            "another language, or take the key away: what is too fast is listed all the same"
        )
    if in_place and job.placement.solve.lean > 0:
        raise CellError(
            f"{job.placement.source}: solve.lean = {job.placement.solve.lean:g}: a program that is filtered in place "
            "keeps its rapids and its tool axes; write another language, or take the key away"
        )


class ProgramMaker(ABC):
    """A way to write a compensation.

    Attributes:
        in_place: the program is a source file with other poses; its rapids stay as they are, and ``findings`` are what
            else changed.
    """

    in_place: bool

    @abstractmethod
    def check(self, placement: Placement, toolpath: Toolpath, program: Path) -> None:
        """Refuse what can be known to be wrong before anything is solved: names, places, lines of [program.events].

        Args:
            toolpath: with the poses that are known so far.
            program: where the program goes.

        Raises:
            WriteError, CellError: names what is wrong and what the language takes.
        """

    @abstractmethod
    def write(self, c: Compensation, staged: Path) -> MadeProgram:
        """Write the commands of ``c`` to ``staged``, and what belongs beside it.

        Raises:
            WriteError: the language cannot take the program; names the pose or line.
            PathError, SolveError: as ``compensate``, where the commands had to change for the language.
        """

    @abstractmethod
    def verify(self, made: MadeProgram, shown: Path) -> Verified:
        """Read the program back from the disk, and let the model deflect it.

        Args:
            shown: the program as messages name it.

        Raises:
            SolveError: the file does not hold what was solved.
        """
