"""How large the shares of a deflection are along a path; the shares themselves would be a hundred bytes a pose."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from compensator.solve.compensation import Compensation, ShareSizes

Floats = npt.NDArray[np.float64]


def share_sizes(c: Compensation) -> ShareSizes:
    """Of a path as it was given; those that are known already are not worked out again."""
    plain = c.uncompensated
    if plain.shares is not None:
        return plain.shares
    rows, tool = np.flatnonzero(plain.cutting), plain.path.toolpath.tool
    size, total, largest = dict[str, Floats](), dict[str, Floats](), 0.0
    for b, shares in c.job.arm.shares_by_block(tool, plain.path.q, plain.wrench, seen=plain.before, at=rows):
        whole: Floats = np.asarray(sum(shares.values()))
        largest = max(largest, float(np.linalg.norm(whole, axis=1).max()))
        for name, share in shares.items():
            so_far = [total[name][None]] if name in total else []
            total[name] = np.concatenate([*so_far, share]).sum(axis=0)  # one after the other, as over all at once
            there = size.setdefault(name, np.broadcast_to(0.0, len(rows)))  # not kept while nothing else stands in it
            if share.any():
                if not there.flags.writeable:
                    size[name] = there = np.zeros(len(rows))
                there[b] = np.linalg.norm(share, axis=1)
    return ShareSizes(size, {name: value / len(rows) for name, value in total.items()}, largest)
