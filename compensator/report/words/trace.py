"""Traces in words: what belongs to the measurement, and what the circles of a ball-bar show, joint by joint."""

from __future__ import annotations

from typing import Any

from compensator.report.words.numbers import residual_mm

Report = dict[str, Any]
LISTED = 3
CLOCK_S = 1e-3  # a shorter lag is told in microseconds


def trace_sentences(report: Report) -> list[str]:
    """One line per trace with something estimated, then one per circle; () where there is no trace."""
    out = [f"{t['trace']}: {text}" for t in report.get("traces", ()) if (text := placed_words(t))]
    return out + [_circle(c) for c in report.get("iso230_4", ())]


def placed_words(trace: Report) -> str:
    """What was estimated of one measurement, "" for nothing."""
    told = []
    if "latency_s" in trace:
        late = trace["latency_s"]
        shown = f"{1e3 * late:.2f} ms" if abs(late) >= CLOCK_S else f"{1e6 * late:.0f} us"
        told.append(f"readings lag behind the program by {shown}")
    if "center_mm" in trace:
        told.append("centre at " + ", ".join(f"{c:.3f}" for c in trace["center_mm"]) + " mm")
    if "length_error_mm" in trace:
        told.append(f"bar longer than nominal by {residual_mm(trace['length_error_mm'])} mm")
    if "part_shift_mm" in trace:
        told.append("part shifted by " + ", ".join(f"{c:.3f}" for c in trace["part_shift_mm"]) + " mm")
    if "probe_offset_mm" in trace:
        told.append(f"probe offset {residual_mm(trace['probe_offset_mm'])} mm")
    return "; ".join(told)


def circle_words(circle: Report) -> str:
    """Plane and feed of a circle."""
    feed = circle["feed_mm_min"]
    return circle["plane"] if feed is None else f"{circle['plane']}, {feed:g} mm/min"


def error_of(numbers: Report) -> tuple[str, float]:
    """The circular error that a circle tells: of both directions, else of the one that was run; mm."""
    both = numbers["bidirectional_circular_error"]
    if both is not None:
        return "bidirectional circular error", both
    one = numbers["circular_error"]
    way = next((w for w in ("clockwise", "counter_clockwise") if one[w] is not None), "clockwise")
    return f"circular error {way.replace('_', '-')}", one[way] or 0.0


def _circle(circle: Report) -> str:
    name, read = error_of(circle)
    before, after = (residual_mm(error_of(circle["predicted"][k])[1]) for k in ("before", "after"))
    text = f"circle {circle_words(circle)}: {name} {residual_mm(read)} mm, predicted {before} -> {after} mm"
    largest = sorted(circle["reversals"], key=lambda r: -abs(r["step_mm"]))[:LISTED]
    steps = [f"{r['joint']} by {1e3 * r['step_mm']:.1f} um at {r['at_deg']:.0f} deg" for r in largest]
    return f"{text}; reversals step the radius: {', '.join(steps)}" if steps else text
