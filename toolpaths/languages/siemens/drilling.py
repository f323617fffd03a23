"""Drilling cycles of SINUMERIK programs as the moves that the control makes: CYCLE81, 82, 83, 85, 89; HOLES1, HOLES2.

Source: Programming Guide Cycles (PGZ 11.02) and Job planning, drilling cycles; parameters in their order there.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from toolpaths.interpreting.values import Runtime
from toolpaths.languages.siemens.block import Arguments
from toolpaths.reading.track import CUT_MARK, RAPID_MARK

#: Cycle -> its parameters, as far as they are read.
DRILLING = {
    "CYCLE81": "RTP RFP SDIS DP DPR DTB GMODE DMODE AMODE",
    "CYCLE82": "RTP RFP SDIS DP DPR DTB GMODE DMODE AMODE",
    "CYCLE83": "RTP RFP SDIS DP DPR FDEP FDPR DAM DTB DTS FRF VARI AXN MDEP VRT DTD DIS1 GMODE DMODE AMODE",
    "CYCLE85": "RTP RFP SDIS DP DPR DTB FFR RFF GMODE DMODE AMODE",
    "CYCLE89": "RTP RFP SDIS DP DPR DTB GMODE DMODE AMODE",
}
PATTERNS = {"HOLES1": "SPCA SPCO STA1 FDIS DBH NUM", "HOLES2": "CPA CPO RAD STA1 INDA NUM"}
CHIP = 1e-3  # m that CYCLE83 draws back to break the chip, where _VRT says nothing
NEAR, DEEP, NEAR_SHARE, NEAR_MOST = 0.6e-3, 30e-3, 1 / 50, 7e-3  # m above the last depth: to 30 mm, beyond, at most
MOST_STROKES = 500
MOST_HOLES = 1000


class DrillStep(NamedTuple):
    """A move along the tool, or with ``dwell`` a stay: kind, height m, feed m/s (NaN: of the block), s (or -turns)."""

    mark: int
    height: float
    feed: float = math.nan
    dwell: float = 0.0


@dataclass(frozen=True)
class SiemensDrilling:
    """A cycle with its values: lengths in m, feeds in m/s."""

    name: str
    values: dict[str, float]

    def steps(self, feed: float) -> Iterator[DrillStep]:
        """The moves of one hole; ``feed``: in force, m/s."""
        v = self.values
        top = v["RFP"] + v["SDIS"]
        yield DrillStep(RAPID_MARK, top)
        if self.name == "CYCLE83":
            yield from self._strokes(feed, top)
        else:
            yield DrillStep(CUT_MARK, v["DP"], v.get("FFR", feed))
            yield from self._stay(v.get("DTB", 0.0), v["DP"])
        if self.name in ("CYCLE85", "CYCLE89"):
            yield DrillStep(CUT_MARK, top, v.get("RFF", feed))
        yield DrillStep(RAPID_MARK, v["RTP"])

    def _strokes(self, feed: float, top: float) -> Iterator[DrillStep]:
        """CYCLE83: chip breaking (VARI 0) or swarf removal (1)."""
        v, depth = self.values, self.values["RFP"] - self.values["DP"]
        near = v.get("DIS1") or (NEAR if depth <= DEEP else min(depth * NEAR_SHARE, NEAR_MOST))
        reached = 0.0
        for count, stroke in enumerate(strokes(depth, v["FIRST"], v.get("DAM", 0.0), v.get("MDEP", 0.0))):
            if count and v.get("VARI", 0.0) == 1.0:
                yield DrillStep(RAPID_MARK, top)
                yield from self._stay(v.get("DTS", 0.0), top)
                yield DrillStep(RAPID_MARK, min(v["RFP"] - reached + near, top))
            elif count:
                yield DrillStep(CUT_MARK, v["RFP"] - reached + (v.get("VRT") or CHIP), feed)
            reached += stroke
            height = v["RFP"] - reached if depth - reached > 1e-9 else v["DP"]
            yield DrillStep(CUT_MARK, height, feed if count else feed * (v.get("FRF") or 1.0))
            last = height == v["DP"]
            yield from self._stay((v.get("DTD") if last else 0.0) or v.get("DTB", 0.0), height)

    @staticmethod
    def _stay(dwell: float, height: float) -> Iterator[DrillStep]:
        if dwell:
            yield DrillStep(CUT_MARK, height, dwell=dwell)


def strokes(depth: float, first: float, degression: float, least: float) -> list[float]:
    """How deep each stroke of CYCLE83 goes, m.

    Args:
        depth: of the hole.
        first: stroke.
        degression: m that each stroke is shorter (above 0), or the factor of each (below 0); 0: all alike.
        least: m that a stroke has at least, 0: no bound.

    Raises:
        ValueError: more strokes than are read.
    """
    out, left, stroke = [min(first, depth)], depth - first, first
    while left > 1e-9:
        if degression > 0:
            stroke = max(stroke - degression, degression, least)
            shortest = stroke <= max(degression, least) + 1e-12
            out.append(left / 2 if shortest and stroke < left < 2 * stroke else min(stroke, left))
        else:
            stroke = max(stroke * -degression if degression < 0 else stroke, least, depth / MOST_STROKES / 2)
            out.append(min(stroke, left))
        left -= out[-1]
        if len(out) > MOST_STROKES:
            raise ValueError(
                f"CYCLE83 makes more than {MOST_STROKES} strokes", "Check the first depth and the degression."
            )
    return out


def drilling(name: str, given: Arguments, unit: float, feed_unit: float, normal: int) -> SiemensDrilling:
    """A drilling cycle as it is called.

    Args:
        name: one of DRILLING.
        given: its arguments.
        unit: m of a length.
        feed_unit: m of the length in a feed.
        normal: 0, 1, 2: the axis that the plane in force has the tool along.

    Raises:
        ValueError: a value is missing, makes no sense, or is not read.
    """
    v = named(name, DRILLING[name], given)
    missing = [p for p in ("RTP", "RFP") if p not in v]
    if missing or not ("DP" in v or v.get("DPR")):
        raise ValueError(f"{name} without {', '.join([*missing, *([] if missing else ['DP'])])}")
    _check_modes(name, v, normal)
    amode = int(v.get("AMODE", 0.0))
    relative = amode % 10 == 1 or (amode % 10 == 0 and v.get("DPR", 0.0) != 0.0)
    out: dict[str, float] = {p: v[p] * unit for p in ("RTP", "RFP", "VRT", "DIS1", "MDEP") if p in v}
    out["SDIS"] = abs(v.get("SDIS", 0.0)) * unit
    out["DP"] = (v["RFP"] - abs(v.get("DPR", 0.0)) if relative else v.get("DP", 0.0)) * unit
    out |= {p: v[p] for p in ("DTB", "DTS", "DTD", "FRF", "VARI") if p in v}
    if not out["DP"] < out["RFP"] <= out["RTP"] + 1e-9:
        heights = ", ".join(f"{p} {out[p] * 1e3:g}" for p in ("RTP", "RFP", "DP"))
        raise ValueError(f"{name}: retraction plane, reference plane and depth in this order from above are expected, "
                         f"found {heights} mm")  # fmt: skip
    if name == "CYCLE83":
        _deep_hole(v, out, unit)
    if name == "CYCLE85":
        for p in ("FFR", "RFF"):
            if not v.get(p, 0.0) > 0:
                raise ValueError(f"CYCLE85: a feed {p} above 0 is expected")
            out[p] = v[p] * feed_unit / 60.0
    return SiemensDrilling(name, out)


def _deep_hole(v: dict[str, float], out: dict[str, float], unit: float) -> None:
    first = v.get("FDPR", 0.0) or (v["RFP"] - v["FDEP"] if "FDEP" in v else 0.0)
    if not first > 0:
        raise ValueError("CYCLE83: a first depth FDEP below RFP, or FDPR above 0, is expected")
    if v.get("VARI", 0.0) not in (0.0, 1.0) or not 0 <= v.get("FRF", 0.0) <= 1:
        raise ValueError("CYCLE83: VARI 0 or 1, and FRF up to 1 are expected")
    if int(v.get("AMODE", 0.0)) // 100_000 % 10:
        raise ValueError("CYCLE83 with a degression in percent", "Write it as amount or factor.")
    degression = v.get("DAM", 0.0)
    out["FIRST"], out["DAM"] = first * unit, degression * unit if degression > 0 else degression


def _check_modes(name: str, v: dict[str, float], normal: int) -> None:
    if v.get("GMODE", 0.0):
        raise ValueError(
            f"{name} with _GMODE {v['GMODE']:g}: the depth depends on the tool", "Post the depth of the tip."
        )
    plane, axis = int(v.get("DMODE", 0.0)) % 10, int(v.get("AXN", 0.0))
    if plane and plane != 3 - normal:
        raise ValueError(f"{name} with _DMODE {v['DMODE']:g}: another plane than the one in force")
    if axis and axis != normal + 1:
        raise ValueError(f"{name} with _AXN {axis}: another axis than that of the plane in force")


def holes(name: str, given: Arguments, unit: float) -> list[tuple[float, float]]:
    """Places in the plane of a row (HOLES1) or a circle (HOLES2), m.

    Raises:
        ValueError: a value is missing or makes no sense.
    """
    v = named(name, PATTERNS[name], given)
    count = v.get("NUM", 0.0)
    if count != int(count) or not 1 <= count <= MOST_HOLES:
        raise ValueError(f"{name} of {count:g} holes: a whole number up to {MOST_HOLES} is expected")
    angle = math.radians(v.get("STA1", 0.0))
    if name == "HOLES1":
        u, w = v.get("SPCA", 0.0), v.get("SPCO", 0.0)
        along = [v.get("FDIS", 0.0) + k * v.get("DBH", 0.0) for k in range(int(count))]
        return [((u + a * math.cos(angle)) * unit, (w + a * math.sin(angle)) * unit) for a in along]
    step = math.radians(v.get("INDA", 0.0)) or math.tau / count
    u, w, radius = v.get("CPA", 0.0), v.get("CPO", 0.0), v.get("RAD", 0.0)
    turns = [angle + k * step for k in range(int(count))]
    return [((u + radius * math.cos(t)) * unit, (w + radius * math.sin(t)) * unit) for t in turns]


def named(name: str, parameters: str, given: Arguments) -> dict[str, float]:
    """Parameter -> value of those that are given.

    Raises:
        ValueError: one is a text or known only at run time, or one more than is read is not 0.
    """
    names, out = parameters.split(), {}
    for k, value in enumerate(given):
        if value is None or value == "":
            continue
        if isinstance(value, Runtime):
            raise ValueError(f"{name}: it depends on {value.reason}: known only at run time")
        if isinstance(value, str):
            raise ValueError(f"{name}: a number is expected, not {value[:20]!r}")
        if k < len(names):
            out[names[k]] = float(value)
        elif value:
            raise ValueError(f"{name}: its {k + 1}. value {float(value):g} is not read", "Post its moves instead.")
    return out
