"""RAPID that drives to postures and stops at them."""

from __future__ import annotations

from toolpaths.languages.rapid.writer import NAME_LIMIT, RESERVED
from toolpaths.writing.names import legal_name, plain
from toolpaths.writing.stops import Stops


def stops_text(stops: Stops, name: str) -> str:
    """The module."""
    module = legal_name(name, NAME_LIMIT, RESERVED)
    lines = ["%%%", "  VERSION:1", "  LANGUAGE:ENGLISH", "%%%", "", f"MODULE {module}"]
    lines += [f"  ! {text}" for text in stops.head]
    lines += ["", "  PROC main()", f"    VelSet {stops.speed},5000;"]
    for q, words in zip(stops.degrees, stops.words, strict=True):
        angles = ",".join(f"{a:.6f}" for a in q)
        lines.append(f"    MoveAbsJ [[{angles}],[9E9,9E9,9E9,9E9,9E9,9E9]],v1000,fine,tool0;")
        if words:
            lines += [f'    TPWrite "{plain(words)[:70]}";', "    Stop;"]
    lines += ["    VelSet 100,5000;", "  ENDPROC", "ENDMODULE", ""]
    return "\r\n".join(lines)
