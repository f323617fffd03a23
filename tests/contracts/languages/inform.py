"""INFORM in the contract suites."""

from __future__ import annotations

from tests.contracts.sample import Sample, WrittenSample

#: Printed are 0.001 mm, 0.0001 deg and 0.1 mm/s, in the robot's frame.
SAMPLE = Sample(
    written=WrittenSample(
        position=0.88e-6,
        rotation=1.7e-6,
        feed=0.03,
        rapid_speed=True,
        stands_or_passes=True,
        most_lines=16000,
        no_names=("a.b", "a" * 33, "größe", "a b", "_a", "a+b"),
        no_name="is no INFORM name",
        longest=(32, 28),
    )
)
