"""Tables of a cell file about the run: bounds of the solve, sampling, the written program."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, Strict

from compensator.toml_table import Number, TomlTable


class SolveTable(TomlTable):
    """Bounds and freedoms of the solve: mm, deg.

    ``fade``: how far from the part, along a rapid, a correction fades in and out.
    ``min_*``: how near a singularity a pose may come; ``min_singular_value`` (translations divided by half
    the reach) holds for arms without a spherical wrist, angles and distance (mm) for the others.
    """

    max_correction: Number = Field(default=5.0, gt=0, le=100)
    free_tool_axis: Annotated[bool, Strict()] = True
    complementary_stiffness: Annotated[bool, Strict()] = True
    fade: Number = Field(default=20.0, gt=0, le=1000)
    min_wrist_angle: Number = Field(default=2.0, gt=0, lt=90)
    min_elbow_angle: Number = Field(default=2.0, gt=0, lt=90)
    min_shoulder: Number = Field(default=20.0, gt=0, le=1000)
    min_singular_value: Number = Field(default=0.02, gt=0, lt=1)
    max_joint_step: Number = Field(default=30.0, gt=0, le=180)


class SamplingTable(TomlTable):
    """How arcs and long moves become points: mm and deg."""

    chord: Number = Field(default=0.01, gt=0, le=10)
    angle: Number = Field(default=0.1, gt=0, le=10)
    spacing: Number = Field(default=10.0, gt=0, le=1000)


class ProgramTable(TomlTable):
    """What the written program is called, its speed in the air and where the toolpath gives none (mm/min)."""

    name: str = "PART1"
    rapid_feed: Number = Field(default=30000.0, gt=0, le=300000)
    default_feed: Number = Field(default=1000.0, gt=0, le=300000)
