"""VAL3 in the contract suites."""

from __future__ import annotations

from tests.contracts.sample import Sample, WrittenSample

#: Data, project, start and stop stand beside the program.
SAMPLE = Sample(
    written=WrittenSample(
        rapid_speed=True,
        files=5,
        most_lines=5100,
        no_names=("1110_wall", "a-b", "a" * 16, "start", "Stop", "tool", "größe", "a b", "pMove001", "fWork"),
        no_name="is no VAL3 name",
        longest=(15, 11),
    )
)
