"""The pictures of docs/axis-map.md: python -m docs.make_axis_map."""

from __future__ import annotations

import tempfile
from pathlib import Path

from compensator.tasks.axis_map import axis_map_file

ROOT = Path(__file__).parents[1]

#: The spindle of the examples on a bracket that turns it by 45 degrees, and a wrench that nobody has to compute.
CELL = f"""schema = "cell/1"
robot = "abb-irb6600-175-255"
tip = "tool0"
model = "{ROOT / "examples" / "stiffness.toml"}"
gravity = "calibrated-out"

[tool]
name = "spindle"
xyz = [180.0, 0.0, 200.0]
rpy = [0.0, 45.0, 0.0]
mass = 35.0
com = [60.0, 0.0, 100.0]

[workobject]
xyz = [1500.0, -100.0, 800.0]

[process]
kind = "constant"
frame = "path"
wrench = [-150.0, 60.0, -50.0, 0.0, 0.0, 0.0]
"""


def main() -> None:
    """Map the wave of the examples."""
    with tempfile.TemporaryDirectory() as folder:
        cell = Path(folder) / "cell.toml"
        cell.write_text(CELL)
        target = ROOT / "docs" / "images" / "axis-map.png"
        axis_map_file(ROOT / "examples" / "wave.nc", cell, png=target)


if __name__ == "__main__":
    main()
