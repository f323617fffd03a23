"""First run: whether the loops of the cut are machine code already, or are compiled now."""

from __future__ import annotations

from pathlib import Path

from compensator.process.milling.kernels.walk import walk

ONCE = "compiling the loops of the cut, once on this machine: half a minute"
ALWAYS = "compiling the loops of the cut, half a minute: there is no folder that can keep them (XDG_CACHE_HOME)"


def compiling() -> str:
    """Words of progress for a run that has to compile; empty where it loads what an earlier one has kept."""
    folder = walk.stats.cache_path  # type: ignore[attr-defined]
    if not folder:
        return ALWAYS
    kept = Path(folder).glob(f"walk.{walk.__name__}-*.nbc")
    return "" if any(kept) else ONCE
