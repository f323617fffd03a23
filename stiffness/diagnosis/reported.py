"""Reported: what a diagnosis says of what it added, and whether what is written keeps it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from stiffness.diagnosis.added_effects import Addition
from stiffness.diagnosis.alternatives import Alternatives
from stiffness.diagnosis.result import AddedEffect, HeldOutScores
from stiffness.identification.fit import CLEAR, Fit


def added_effect(a: Addition, allowed: Fit, last: Fit, found: Sequence[Alternatives]) -> AddedEffect:
    """One effect with its numbers.

    Args:
        allowed: the fit whose values effects allow. last: the one whose standard deviations hold.
    """
    values, sd = allowed.values()[a.effect.name], last.deviations()[a.effect.name]
    parameters = {}
    for p in a.effect.parameters:
        if p.extra and not a.extras:
            continue
        if p.site not in {s.kind for s in a.sites}:
            continue
        every = range(p.count(last.unknowns.joints))
        at = list(dict.fromkeys(k for s in a.sites if s.kind == p.site for k in every[p.of_site(s.index)]))
        parameters[p.name] = (values[p.name][at], sd[p.name][at], p.unit)
    own = next((r for r in found if r.addition.effect is a.effect), None)
    return AddedEffect(
        effect=a.effect.name,
        where=a.where,
        parameters=parameters,
        explains=own.explains if own else 0.0,
        confused_with=tuple(own.fits) if own else (),
        sites=tuple(s.where for s in a.sites),
    )


def contradicted(judged: Fit, refined: Fit, last: Fit, allowed: Fit) -> str:
    """A note where a model leaves clearly more than the fit that was judged; "" where none does.

    Args:
        judged: what the verdict is about. refined: the same within the limits of its effects. last: of all readings.
        allowed: that within the limits, as it is written.
    """
    before = max(judged.solution.noises, 1.0)
    within = max(refined.solution.noises, allowed.solution.noises)
    if last.solution.noises > CLEAR * before:
        return (
            f"the effects that explain the readings of the fit ({before:.2f} times the noise is left) leave "
            f"{last.solution.noises:.2f} times the noise of all, those put aside included: the law is another one"
        )
    if within > CLEAR * before:
        return (
            f"the numbers that explain the readings ({before:.2f} times the noise is left) are beyond what their "
            f"effects allow (a stiffness that would be negative somewhere): with the nearest that are allowed "
            f"{within:.2f} times the noise is left. The law is another one"
        )
    return ""


def worse(scores: Mapping[str, HeldOutScores | None], base: Fit, written: Fit) -> str:
    """A note where a refined model predicts readings that took no part clearly worse than the model at hand did, as it
    was or fitted anew (``base``), or where what is ``written`` leaves more than that; "" where neither."""
    nothing = "the model at hand stays, nothing is added. The law is another one"
    for kind, s in scores.items():
        if s is not None and s.after.rms > CLEAR * (best := min(s.before.rms, s.refitted.rms)):
            return (
                f"what explains the readings that took part predicts those held out worse ({kind}: "
                f"{1e3 * s.after.rms:.3f} mm, {1e3 * best:.3f} mm without): {nothing}"
            )
    if written.solution.noises > CLEAR * base.solution.noises:
        return (
            f"what was found leaves {written.solution.noises:.2f} times the noise of all readings, the model at hand "
            f"{base.solution.noises:.2f} times: {nothing}"
        )
    return ""
