"""URScript that drives to postures and waits at them."""

from __future__ import annotations

from toolpaths.languages.urscript.writer import NAME_LIMIT, RESERVED
from toolpaths.writing.names import legal_name, plain
from toolpaths.writing.stops import Stops

FASTEST = 3.14  # rad/s, of which a percentage is taken


def stops_text(stops: Stops, name: str) -> str:
    """The program."""
    program = legal_name(name, NAME_LIMIT, RESERVED)
    lines = [f"def {program}():", *(f"  # {text}" for text in stops.head)]
    for q, words in zip(stops.joints.tolist(), stops.words, strict=True):
        angles = ", ".join(f"{a + 0.0:.9f}" for a in q)
        lines.append(f"  movej([{angles}], a=1.0, v={FASTEST * stops.speed / 100:.3f})")
        if words:
            shown = plain(words).replace('"', "'")
            lines.append(f'  popup("{shown}", title="measure", warning=False, error=False, blocking=True)')
    return "\n".join([*lines, "end", "", f"{program}()", ""])
