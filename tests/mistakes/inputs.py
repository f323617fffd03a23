"""The inputs that the mistakes are made in: a small job of every verb, and nothing wrong with it."""

from __future__ import annotations

import shutil
from pathlib import Path

from tests.compensator.small_job import ABB
from tests.stiffness.bench_lab import Lab

ROOT = Path(__file__).parents[2]
CELL = """schema = "cell/1"
robot = "arm.toml"
tip = "tool0"
model = "model.toml"
gravity = "calibrated-out"

[tool]
xyz = [0.0, 0.0, 250.0]
mass = 30.0
com = [0.0, 0.0, 110.0]

[workobject]
xyz = [1500.0, -150.0, 800.0]

[process]
kind = "constant"
frame = "path"
wrench = [-120.0, 80.0, -60.0, 0.0, 0.0, 0.0]
"""
TABLE = CELL.partition("kind = ")[0] + 'kind = "table"\nframe = "path"\nfile = "wrenches.csv"\n'
MODEL = """schema = "model/1"
robot = "arm.toml"
gravity = "uncompensated"

[effects.joint-stiffness]
k_nm_per_rad = [2.0e6, 1.774e6, 1.378e6, 2.82e5, 9.6e4, 3.74e4]
sd_nm_per_rad = [2.0e4, 2.0e4, 1.5e4, 4.0e3, 2.0e3, 1.0e3]
"""
PART = """%
O1001 (PART)
G21 G90 G94 G17
T1 M6
G54
G0 X0 Y0 Z50
Z5
G1 Z-2 F300
X100 F1200
Y60
G0 Z50
M30
%
"""
PATH = """x_mm,y_mm,z_mm,i,j,k,feed_mm_min,kind
0,0,50,0,0,1,0,rapid
0,0,5,0,0,1,0,rapid
0,0,-2,0,0,1,300,cut
100,0,-2,0,0,1,1200,cut
100,60,-2,0,0,1,1200,cut
100,60,50,0,0,1,0,rapid
"""
WRENCHES = "index,fx,fy,fz,mx,my,mz\n" + "".join(f"{k},-120,80,-60,0,0,0\n" for k in range(2, 5))


def write_inputs(folder: Path) -> None:
    """All of them; the session takes a second."""
    texts = {"cell.toml": CELL, "table.toml": TABLE, "model.toml": MODEL, "part.nc": PART, "path.csv": PATH}
    for name, text in {**texts, "wrenches.csv": WRENCHES}.items():
        (folder / name).write_text(text)
    arm = (ROOT / "stiffness" / "robot" / "data" / f"{ABB}.toml").read_text(encoding="utf-8")
    (folder / "arm.toml").write_text(arm.replace(f'name = "{ABB}"', 'name = "arm"'), encoding="utf-8")
    Lab().session(folder, 7, setups=8)
    session = folder / "session.toml"
    session.write_text(session.read_text().replace(f'"{ABB}"', '"arm.toml"'))
    for lab, seed in (("other", 8), ("ur10", 9)):
        (folder / lab).mkdir()
        Lab("ur10" if lab == "ur10" else ABB).session(folder / lab, seed, setups=4)
    shutil.copytree(folder / "other", folder / "copy")
