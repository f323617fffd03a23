"""Doubts about sessions, from how a fit meets their readings: they stand first in every output."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from stiffness.diagnosis.doubt import Doubt
from stiffness.diagnosis.jumps import measurement_changes
from stiffness.diagnosis.wrench_scale import wrench_doubt
from stiffness.identification.fit import CLEAR, Fit
from stiffness.identification.outliers import WRONG, contradicting
from stiffness.identification.registration import missed_frames
from stiffness.identification.session_fit import SessionFit
from stiffness.session.session import Session

Bools = npt.NDArray[np.bool_]

SHORTEST = 2e-3  # m: no tool is so short, and few are longer than as many metres
NAMED = 12  # rows that a sentence has room for


def session_doubts(fits: Sequence[SessionFit], wrong: Sequence[tuple[str, int]] | None = None) -> tuple[Doubt, ...]:
    """What is wrong with the measurements of some sessions, or looks so; () where nothing is.

    Args:
        wrong: (session, line of samples.csv) that were left out in the end; None: those that the fits did not use.
    """
    out = list(set_up_doubts(fits))
    for fit in fits:
        lines = [line for source, line in wrong or () if source == fit.session.source]
        out_of_fit = (fit.allowed & ~fit.used) if wrong is None else np.isin(fit.samples.line, lines)
        out += [d for d in (left_out(fit.session, out_of_fit), _staying(fit)) if d is not None]
        out += [Doubt(c.samples, c.sentence, first=c.after) for c in measurement_changes(fit) if c.size > _left(fit)]
    return tuple(out)


def set_up_doubts(fits: Sequence[SessionFit]) -> tuple[Doubt, ...]:
    """What is wrong with the wrench or the tool of sessions as a whole; () where nothing is."""
    each = (d for fit in fits for d in (wrench_doubt(fit), *tool_doubts(fit.session)))
    return tuple(d for d in each if d is not None)


def registration_doubts(fit: Fit) -> tuple[Doubt, ...]:
    """Declared frames that the readings of a fit contradict."""
    out = []
    for t in missed_frames(fit):
        turn = Rotation.from_matrix(t.rotation).magnitude()
        far, sd = float(np.linalg.norm(t.origin)), np.sqrt([np.mean(t.origin_sd**2), np.mean(t.rotation_sd**2)])
        what = (
            f"registered = true, but by these readings the frame of block {t.block} is {1e3 * far:.2f} mm and "
            f"{1e3 * turn:.2f} mrad off the robot's base (sd {1e3 * sd[0]:.2f} mm, {1e3 * sd[1]:.2f} mrad per axis): "
            "positions of this model count from the robot's own base. Register anew, or give registered = false"
        )
        out.append(Doubt(t.session, what))
    return tuple(out)


def _left(fit: SessionFit) -> float:
    """m, what the model leaves of a reading, where that is more than noise: a smaller change may be the model's."""
    off = (fit.samples.position - fit.predicted.position)[fit.used] / fit.samples.sd[fit.used]
    square = float(np.mean(off**2))
    return float(np.sqrt(3 * square) * np.median(fit.samples.sd)) if square > CLEAR**2 else 0.0


def left_out(session: Session, wrong: Bools) -> Doubt | None:
    """How many rows (N,) were left out as wrong, and which."""
    count = int(wrong.sum())
    if not count:
        return None
    s = session.samples
    rows = [f"{s.line[k]} ({session.reflectors[s.reflector[k]].name})" for k in np.flatnonzero(wrong)[:NAMED]]
    more = f" and {count - NAMED} more" if count > NAMED else ""
    what = f"{count} of {len(s)} readings were left out as wrong, the others contradict them: rows "
    return Doubt(session.samples_file, what + ", ".join(rows) + more, count, int(s.line[np.argmax(wrong)]))


def _staying(fit: SessionFit) -> Doubt | None:
    """Rows that contradict the bulk of their reflector and were kept, as they are more than can be wrong."""
    rows = contradicting(fit)
    s, count = fit.samples, int(rows.sum())
    if count <= WRONG * len(s):
        return None
    who = [fit.session.reflectors[k].name for k in np.unique(s.reflector[rows])]
    what = (
        f"{count} of {len(s)} readings ({', '.join(who)}) contradict the others of their reflector, more than can be "
        "wrong rows: none of them was left out. Look whether a reflector was moved, a set-up mislabelled, or the model "
        "lacks something (diagnose)"
    )
    return Doubt(fit.session.samples_file, what, count, int(s.line[np.argmax(rows)]))


def tool_doubts(session: Session) -> tuple[Doubt, ...]:
    """A tool of unknown weight on an arm whose sag is in the readings; one that ends at the flange within a trifle."""
    out = []
    length = float(np.linalg.norm(session.tool.position))
    if 0 < length < SHORTEST:
        where = ", ".join(f"{v * 1e3:g}" for v in session.tool.position)
        out.append(
            f"[tool] xyz is ({where}) mm, {length * 1e3:.2g} mm from the flange: expected is 0 or a length. "
            "If these are metres, give them in units.length of the file; moments of the wrench are about this point"
        )
    if session.gravity == "uncompensated" and session.tool.mass is None and session.has_absolute:
        out.append(
            "[tool] has no mass, and gravity = 'uncompensated': the weight of what hangs on the flange is taken for "
            "zero, and its sag goes into stiffness and offsets. Weigh it and give tool.mass and tool.com"
        )
    return tuple(Doubt(session.source, what) for what in out)
