"""KRL that drives to postures and halts at them."""

from __future__ import annotations

from toolpaths.languages.krl.writer import NAME_LIMIT, RESERVED
from toolpaths.writing.names import legal_name, plain
from toolpaths.writing.stops import Stops


def stops_text(stops: Stops, name: str) -> str:
    """The program."""
    lines = ["&ACCESS RVP", "&REL 1", f"DEF {legal_name(name, NAME_LIMIT, RESERVED)}()"]
    lines += [f"  ; {text}" for text in stops.head]
    lines += ["  BAS(#INITMOV,0)", f"  BAS(#VEL_PTP,{stops.speed})"]
    for q, words in zip(stops.degrees, stops.words, strict=True):
        lines.append("  PTP {AXIS: " + ",".join(f"A{i} {a:.6f}" for i, a in enumerate(q, 1)) + "}")
        lines += [f"  ; {plain(words)}", "  HALT"] if words else []
    return "\r\n".join([*lines, "END", ""])
