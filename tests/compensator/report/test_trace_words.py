"""Traces in words: what a terminal and a page tell of the measurement and of circles."""

from __future__ import annotations

from compensator.report.html.trace_tables import circles, reversals
from compensator.report.words.trace import trace_sentences


def numbers(both: float | None) -> dict[str, object]:
    return {
        "circular_error": {"clockwise": 0.05, "counter_clockwise": None}, "bidirectional_circular_error": both,
        "mean_bidirectional_radial_error": 0.01, "radial_error": {"max": 0.04, "min": -0.02},
    }  # fmt: skip


REVERSALS = [
    {"joint": "joint-4", "joint_deg": 8.6, "at_deg": 23.0, "step_mm": 0.0048, "predicted_mm": 0.0053},
    {"joint": "joint-1", "joint_deg": -10.8, "at_deg": 1.0, "step_mm": -0.0135, "predicted_mm": -0.0128},
]
CIRCLE = {
    "plane": "YZ", "feed_mm_min": 500.0, **numbers(0.06), "reversals": REVERSALS,
    "predicted": {"before": numbers(0.001), "after": numbers(0.059)},
}  # fmt: skip


def test_a_late_stream_and_a_circle() -> None:
    report = {"traces": [{"trace": "t.toml", "latency_s": 0.04}, {"trace": "bar.toml"}], "iso230_4": [CIRCLE]}
    assert trace_sentences(report) == [
        "t.toml: readings lag behind the program by 40.00 ms",
        "circle YZ, 500 mm/min: bidirectional circular error 0.06000 mm, predicted 0.001000 -> 0.05900 mm; "
        "reversals step the radius: joint-1 by -13.5 um at 1 deg, joint-4 by 4.8 um at 23 deg",
    ]


def test_one_direction_has_its_own_error() -> None:
    one = {**CIRCLE, **numbers(None), "predicted": {"before": numbers(None), "after": numbers(None)}, "reversals": []}
    assert trace_sentences({"iso230_4": [one]}) == [
        "circle YZ, 500 mm/min: circular error clockwise 0.05000 mm, predicted 0.05000 -> 0.05000 mm"
    ]


def test_tables_of_circles() -> None:
    assert circles({"iso230_4": [CIRCLE]}).rows[0][2:5] == ["0.05000", "\u2013", "0.06000"]
    assert [row[0] for row in reversals({"iso230_4": [CIRCLE]}).rows] == ["joint-1", "joint-4"]
