"""Turn numbers in CONFIG through the whole product: a joint that the correction turns past 180 deg."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from compensator.tasks.compensate import compensate_file, preview_file
from tests.compensator.program.test_real_filtered import SOFT, job
from toolpaths.languages.fanuc.config import turn_numbers

TURNING = [0, 3, 5]
HEAD = "/PROG  TURNS\n/ATTR\nDEFAULT_GROUP\t= 1,*,*,*,*;\n/MN\n"
RECORD = (
    "P[{n}]{{\n   GP1:\n\tUF : 0, UT : 9,\t\tCONFIG : 'F U T, {a}, {b}, {c}',\n"
    "\tX = {x:9.3f}  mm,\tY = {y:9.3f}  mm,\tZ = {z:9.3f}  mm,\n"
    "\tW = {w:9.3f} deg,\tP = {p:9.3f} deg,\tR = {r:9.3f} deg\n}};\n"
)
FRAMES = [
    "  UFRAME_NUM=0 ;", *(f"  PR[9,{k}]={v} ;" for k, v in enumerate((0, 0, 250, 0, 0, 0), 1)),
    "  UTOOL[9]=PR[9] ;", "  UTOOL_NUM=9 ;",
]  # fmt: skip


def program(poses: list[tuple[float, ...]], turns: np.ndarray) -> str:
    moves = [
        f"{'J' if n == 1 else 'L'} P[{n}] {'20%' if n == 1 else '20mm/sec'} FINE ;" for n in range(1, len(poses) + 1)
    ]
    lines = "".join(f"{i:4d}:{line}\n" for i, line in enumerate([*FRAMES, *moves], 1))
    rows = zip(range(1, len(poses) + 1), turns.tolist(), poses, strict=True)
    records = "".join(
        RECORD.format(n=n, a=t[0], b=t[1], c=t[2], **dict(zip("xyzwpr", p, strict=True))) for n, t, p in rows
    )
    return f"{HEAD}{lines}/POS\n{records}/END\n"


def joints(toolpath: Path, cell: Path, n: int) -> np.ndarray:
    """deg of J1, J4, J6 at the poses of the program, as the model turns them."""
    result = preview_file(toolpath, cell).result
    row = result.path.toolpath.row
    return np.degrees(result.path.q[[int(np.argmin(np.abs(row - k))) for k in range(n)]][:, TURNING])


def test_config_follows_the_correction(tmp_path: Path, shared: Path) -> None:
    """A tool that points down and crosses the middle of the arm: J6 passes 180 deg there."""
    poses = [(1100.0, float(y), 300.0, 180.0, 0.0, 0.0) for y in (-40, -20, -0.1, -0.02, 0.02, 0.1, 0.3, 20, 40)]
    source = tmp_path / "turns.ls"
    cell = job(tmp_path, shared, source, SOFT[".ls"], 300.0)
    source.write_text(program(poses, np.zeros((len(poses), 3), dtype=int)))
    nominal = joints(source, cell, len(poses))
    said = turn_numbers(nominal)
    assert len(np.unique(said[:, 2])) == 2  # the program itself passes 180 deg
    source.write_text(program(poses, said))
    done = compensate_file(source, cell, tmp_path / "out.ls")
    result = done.result
    row = result.path.toolpath.row
    commanded = np.degrees(result.command.q[:, TURNING])
    text = (tmp_path / "out.ls").read_text()
    found = re.findall(r"^P\[(\d+)\]\{.*?CONFIG : 'F U T, (-?\d), (-?\d), (-?\d)'", text, re.M | re.S)
    written = {int(n): [int(v) for v in turns] for n, *turns in found}
    changed = 0
    for n in range(2, len(poses) + 1):
        k = int(np.argmin(np.abs(row - (n - 1))))
        if np.abs(np.abs(commanded[k]) - 180.0).min() > 1e-3:
            assert written[n] == turn_numbers(commanded[k]).tolist(), n
            changed += written[n] != said[n - 1].tolist()
    assert changed >= 1 and f"CONFIG : 'F U T, {said[0][0]}, {said[0][1]}, {said[0][2]}'" in text
