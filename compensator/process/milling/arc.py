"""Arc: the force of a cutter that is engaged from one angle to another up to a height: what force tests give."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from compensator.process.milling.cutter import Cutter
from compensator.process.milling.kernels.chip import EDGE_RISE
from compensator.process.milling.outline import outline_rows

Floats = npt.NDArray[np.float64]

ANGLES = 400  # midpoints over the arc
STRIPS = 60  # along the height


def arc_shares(cutter: Cutter, ap: float, arc: tuple[float, float], feed: float) -> Floats:
    """(6, 6) mean force and moment over a turn with M3, in path axes about the TCP, per coefficient of NAMES.

    The feed is across the axis; the height of the engaged part is the same all over the arc.

    Args:
        ap: m, height above the tip.
        arc: rad, smallest and largest engaged angle.
        feed: m per tooth.
    """
    rows = outline_rows(cutter, min(ap / STRIPS, cutter.radius / 20))
    below = np.minimum(rows[:, 1], ap)
    lower, upper, goes_on = rows[:-1], rows[1:], rows[:-1, 4] > 0
    rise = np.where(upper[:, 1] > lower[:, 1], upper[:, 1] - lower[:, 1], 1.0)
    share = np.where(upper[:, 1] > lower[:, 1], (below[1:] - below[:-1]) / rise, lower[:, 1] < ap) * goes_on
    middle = 0.5 * (lower + upper)
    length = share * (upper[:, 3] - lower[:, 3])
    used = length > 0
    rho, s, kappa = (np.asarray(v, dtype=float) for v in middle[used, :3].T[:, :, None])
    step = (arc[1] - arc[0]) / ANGLES
    theta = arc[0] + (np.arange(ANGLES) + 0.5)[None, :] * step
    h = np.asarray(np.maximum(feed * np.sin(kappa) * np.cos(theta), 0.0), dtype=float)
    weight = length[used][:, None] * step * cutter.flutes / (2.0 * np.pi)
    return _sums(np.asarray(theta, dtype=float), kappa, np.stack([rho + 0 * h, s + 0 * h]), h, weight=weight)


def _sums(theta: Floats, kappa: Floats, place: Floats, h: Floats, *, weight: Floats) -> Floats:
    """Force and moment of all elements; ``place`` (2, ...) rho and s."""
    c, d, sk, ck = np.cos(theta), np.sin(theta), np.sin(kappa), np.cos(kappa)
    zero = np.zeros_like(h)
    r = np.stack([place[0] * c, place[0] * d, -place[1]], axis=-1)
    ways = [
        np.stack([d + zero, -c + zero, zero], axis=-1),
        -np.stack([sk * c, sk * d, ck + zero], axis=-1),
        np.stack([-ck * c, -ck * d, sk + zero], axis=-1),
    ]
    out = np.zeros((6, 6))
    for k, way in enumerate(ways):
        both = np.concatenate([way, np.cross(r, way)], axis=-1)
        for j, size in ((k, h), (k + 3, np.minimum(h / EDGE_RISE, 1.0))):
            out[:, j] = np.sum(both * (weight * size)[..., None], axis=(0, 1))
    return out
