"""The text of a trace/1 file."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence

from compensator.devices.order import FREE, TraceOrder
from compensator.devices.readings import BALLBAR


def trace_toml(
    *,
    kind: str,
    order: TraceOrder,
    cell: str,
    program: str,
    samples: str,
    lead: Sequence[str],
    noise_line: str = "",
    touched: bool = False,
) -> str:
    """A trace/1 file.

    Args:
        cell, program, samples: paths relative to it. lead: remarks at its head.
        noise_line: in place of the noise where it is not known yet. touched: by a touch probe.
    """
    lines = [*(f"# {_one_line(text)}" for text in lead), 'schema = "trace/1"']
    named = {"cell": cell, "program": program, "samples": samples}
    lines += [f"{key} = {_quoted(value)}" for key, value in named.items()]
    lines.append(f'kind = "{kind}"')
    if kind != BALLBAR:
        lines.append(f"registered = {_yes(order.frame != FREE)}")
    if order.dry:
        lines.append("dry = true")
    if order.noise is not None or noise_line:
        lines += ["", "[instrument]", noise_line or f"noise = {_number(order.noise or 0.0)}  # mm"]
    if kind == BALLBAR and order.center is not None and order.radius is not None:
        centre = ", ".join(_number(v) for v in order.center)
        lines += ["", "[ballbar]", f"center = [{centre}]  # mm, base", f"radius = {_number(order.radius)}  # mm"]
        lines.append(f"calibrated = {_yes(order.calibrated)}")
    if touched:
        lines += ["", "[probe]", "calibrated = false  # its offset is estimated; true: a cutter of another size shows"]
    return "\n".join(lines) + "\n"


def _yes(value: bool) -> str:
    return "true" if value else "false"


def _number(value: float) -> str:
    return repr(float(value))


def _quoted(text: str) -> str:
    """A TOML string: as JSON has it, DEL escaped too."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _one_line(text: str) -> str:
    return re.sub(r"[\x00-\x08\x0a-\x1f\x7f]", " ", text)
