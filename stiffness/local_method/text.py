"""Text: a local fit in words, for terminals and protocols."""

from __future__ import annotations

from stiffness.local_method.fit import JointRecord, LoadedState, LocalFit


def local_text(fit: LocalFit) -> str:
    """Joint by joint: the stiffness, what it was made of, and beside it what the paper's print would have given."""
    return "\n".join(line for record in fit.joints for line in _joint(fit, record)) + "\n"


def _joint(fit: LocalFit, record: JointRecord) -> list[str]:
    k = record.joint - 1
    if record.problem:
        lines = [f"joint {record.joint}  not identified: {record.problem}"]
    else:
        ratio = fit.stiffness[k] / fit.stiffness[0]
        share = f", {ratio:.4g} of joint 1" if k and fit.identified[0] else ""
        lines = [
            f"joint {record.joint}  {fit.stiffness[k]:.5g} +- {fit.sd[k]:.2g} N*m/rad{share} "
            f"({record.side}; {record.equation})"
        ]
    lines += [line for state in record.states for line in _state(state)]
    if record.non_loaded is not None and record.ratio is not None:
        lines.append(
            f"  non-loaded {record.non_loaded.value:.5g} +- {record.non_loaded.sd:.2g} N*m/rad, "
            f"{record.ratio.value:.4g} +- {record.ratio.sd:.2g} of pre-loaded"
        )
    return [*lines, *(f"  note: {note}" for note in record.notes)]


def _state(state: LoadedState) -> list[str]:
    points = ", ".join(f"{p} {name} ({n} loaded, {m} not)" for p, (name, n, m) in state.readings.items())
    off = ", ".join(f"{angle * 1e6:.1f} urad of joint {j}" for j, angle in state.taken_off.items())
    lines = [
        f"  set-up {state.setup} state {state.state}, {state.side}: {points}",
        f"    {state.force:.2f} N at {state.load_lever:.4f} m, read at {state.reading_lever:.4f}: "
        f"{state.turn * 1e6:.2f} urad" + (f", taken off {off}" if off else ""),
    ]
    for way in state.printed:
        lines.append(f"    {way.name}: {_beside(way.stiffness, state.stiffness)} ({way.words})")
    return lines


def _beside(wrong: float, right: float) -> str:
    if not 0 < wrong < float("inf"):
        return "no stiffness at all, the angle comes out negative or zero"
    return f"{wrong:.5g} N*m/rad, {100 * (wrong / right - 1):+.1f} %"
