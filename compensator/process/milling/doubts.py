"""Doubts about a material set: what its numbers, or where they are used, make unlikely."""

from __future__ import annotations

from compensator.process.milling.material import NAMES, SI, Material
from toolpaths.finding import NOTE, WARNING, Finding

USED_BEYOND = 1.001  # ratio: rounding of a feed is not outside of a range


def material_doubts(
    m: Material, feed_per_tooth: tuple[float, float] | None = None, speed: tuple[float, float] | None = None
) -> list[Finding]:
    """Findings about a set, and about the feeds (m, smallest and largest) and cutting speeds (m/s) it is used at."""
    place, values = f"material {m.name}", dict(zip(NAMES, m.coefficients / SI, strict=True))
    out = []
    if m.label:
        out.append(Finding(NOTE, place, m.label))
    if m.missing:
        what = f"has no {', '.join(m.missing)}: that part of the force is taken as 0"
        out.append(Finding(WARNING, place, what, "Measure it (compensator cutting), or choose another set"))
    if values["krc"] > values["ktc"] > 0:
        what = f"krc = {values['krc']:.4g} is above ktc = {values['ktc']:.4g} N/mm2"
        out.append(Finding(WARNING, place, what, _SWALLOWED))
    negative = [f"{n} = {values[n]:.4g}" for n in ("kte", "kre") if values[n] < 0]
    if negative:
        out.append(Finding(WARNING, place, f"negative edge terms: {', '.join(negative)} N/mm", _SWALLOWED))
    if values["ktc"] <= 0:
        what = f"ktc = {values['ktc']:.4g} N/mm2: cutting takes no force"
        out.append(Finding(WARNING, place, what, "Check the columns and units of what it was made from"))
    for name, unit, scale, used, measured in (
        ("feed per tooth", "mm", 1e3, feed_per_tooth, m.feed_per_tooth),
        ("cutting speed", "m/min", 60.0, speed, m.speed),
    ):
        if used and measured and (used[0] * USED_BEYOND < measured[0] or used[1] > measured[1] * USED_BEYOND):
            at, of = (f"{a * scale:.3g} to {b * scale:.3g} {unit}" for a, b in (used, measured))
            out.append(Finding(WARNING, place, f"is used at a {name} of {at}; it was measured at {of}"))
    if m.covariance is None:
        out.append(Finding(NOTE, place, "gives no standard deviations: how sure the force is cannot be told"))
    return out


_SWALLOWED = "A set measured on a yielding machine holds the machine's own deflection; measure it on a stiff one"
