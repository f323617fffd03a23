"""What stands for the words of each page: files of a small job, fewer of what takes minutes, answers that are typed."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from tests.pages import page_folders as folders

Act = Callable[[Path], None]


@dataclass(frozen=True)
class PageJob:
    """What stands for the words of a page; every other word of its commands is run as it stands.

    Attributes:
        count: how many commands the page has.
        files: word of the page -> file of the small job.
        folder: makes the folder that the commands run in; None: what the small jobs of all verbs read.
        before: number of a command, from 0 -> what the reader does before it.
        fewer: word of the page -> what takes seconds instead of minutes.
        more: verb -> options in addition, for the same reason.
        typed: what the reader types at the terminal.
    """

    count: int
    files: Mapping[str, str] = field(default_factory=dict)
    folder: Act | None = None
    before: Mapping[int, Act] = field(default_factory=dict)
    fewer: Mapping[str, str] = field(default_factory=dict)
    more: Mapping[str, str] = field(default_factory=dict)
    typed: str = ""

    def given(self, verb: str, words: Sequence[str]) -> list[str]:
        """What is run for the words of a command."""
        instead = {**self.files, **self.fewer}
        return [*(instead.get(word, word) for word in words), *shlex.split(self.more.get(verb, ""))]


POSTURES = 60
"""What `plan` chooses from here, instead of 300."""
PART_NC, MODEL = {"part.nc": "path.csv"}, {"stiffness.toml": "model.toml"}
PART_CSV = {"part.nc": "part.csv"}
ANSWERS = (
    *("abb-irb6600-175-255", "0 0 250 35", "1500 -100 800", "part.nc", "unknown", "krl"),
    *("flat 10 2 25", "aluminium-6082-t6", "box 0 0 -25 140 100 0"),
)
JOBS = {
    "axis-map": PageJob(1, {"TOOLPATH": "path.csv", "CELL.toml": "cell.toml"}),
    "check": PageJob(2, PART_NC),
    "clamped": PageJob(1, {"READINGS.csv": "readings.csv", "ROBOT": "geared.toml"}),
    "compare": PageJob(2, {"before.json": "one.json", "after.json": "other.json"}),
    "compensate": PageJob(2, PART_NC),
    "cutting": PageJob(3, {**PART_NC, "cell.toml": "mill.toml"}),
    "datasheet": PageJob(1, {"ROBOT": "geared.toml"}),
    "diagnose": PageJob(1, MODEL),
    "filter": PageJob(1, {"PART.mod": "plain/part.mod", "cell.toml": "plain/cell.toml"}),
    "first-part": PageJob(
        4,
        PART_NC,
        folder=folders.first_cell,
        before={2: folders.cut_and_measured, 3: folders.with_the_refined_model},
    ),
    "identify": PageJob(2, {"other.toml": "session.toml"}),
    "init": PageJob(2, folder=folders.cam_file, before={1: folders.no_cell}, typed="\n".join(ANSWERS) + "\n"),
    "measure-in-a-day": PageJob(
        4, PART_CSV, folder=folders.plan_day, before={1: folders.measured}, fewer={"20": "4"}
    ),
    "place": PageJob(
        1,
        PART_NC,
        fewer={"x=1200:1800:13,y=-400:400:9,yaw=0:90:3": "x=1500:1600:2,y=-100:0:2,yaw=0:90:2"},
        more={"place": "--poses 10 --turns 2 --workers 1"},
    ),
    "plan": PageJob(
        3,
        PART_CSV,
        folder=folders.plan_day,
        before={2: folders.measured},
        more={"plan": "--count 5"},
    ),
    "plan-trials": PageJob(2),
    "stiffness-map": PageJob(1, {"MODEL.toml": "model.toml"}),
    "toolpaths-in": PageJob(3, folder=folders.krl_job),
    "traces": PageJob(2, folder=folders.traces),
    "traces-from-devices": PageJob(3, folder=folders.devices),
    "tutorial": PageJob(6, folder=folders.wave),
    "verify": PageJob(2, {"part.mod": "program.mod", **PART_NC}),
    "view": PageJob(1, PART_NC),
}
"""Page -> its job."""
IN_A_SHELL: dict[str, Act] = {"command-line": Path.mkdir, "own-effect": folders.own_effect}
"""Pages whose lines need a shell or an environment of their own -> what makes the folder."""
