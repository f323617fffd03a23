"""A run whose columns are worked on in small blocks against the same run at once: the same bytes."""

from __future__ import annotations

import hashlib
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import compensator.solve.flank_poses as flank_poses
import compensator.solve.joint_state as joint_state
import stiffness.kinematics.spherical as spherical
import toolpaths.columns as columns
import toolpaths.languages.rapid.writer as writer
from compensator.program.export import program_of
from compensator.solve.compensate import uncompensated
from compensator.solve.planned import planned
from compensator.tasks.compensate import compensate_file, files_of, preview_file, read_input
from tests.compensator.small_job import MODEL, WORN, Files, files
from toolpaths.files import write_program

BLOCK = 16


def wavy(poses: int, *, rapid: bool) -> list[list[object]]:
    """A closed curve with a swaying tool; in the middle of it a rapid."""
    t = np.linspace(0, 2 * np.pi, poses)
    tilt = 0.1 * np.sin(3 * t)
    rows = np.column_stack([60 * np.sin(t), 40 * np.sin(2 * t), 3 * np.cos(t), tilt, 0 * t, np.sqrt(1 - tilt**2)])
    kinds = ["rapid" if rapid and k == poses // 2 else "cut" for k in range(poses)]
    return [[*row, 1200, kind] for row, kind in zip(rows.tolist(), kinds, strict=True)]


def written(job: Files, name: str) -> dict[str, str]:
    """Hashes of what a run writes; of the summary without its seconds."""
    folder = job.out / name
    folder.mkdir(parents=True)
    compensate_file(job.toolpath, job.cell, folder / "p.mod", json=folder / "s.json")
    preview_file(job.toolpath, job.cell, csv=folder / "p.csv", json=folder / "v.json")
    return hashes(folder)


def hashes(folder: Path) -> dict[str, str]:
    """Of all files in a folder."""
    out = {}
    for file in sorted(folder.iterdir()):
        data = file.read_bytes()
        if file.suffix == ".json":
            told = json.loads(data)
            assert told.pop("seconds") > 0 and told["n_poses"] > 0
            data = json.dumps(told).encode()
        out[file.name] = hashlib.sha256(data).hexdigest()
    return out


def in_small_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Everything that is done block by block, in blocks that are full after few poses."""
    monkeypatch.setattr(columns, "BLOCK", BLOCK)
    monkeypatch.setattr(spherical, "BLOCK", 7)
    monkeypatch.setattr(joint_state, "STATELESS", BLOCK + 1)
    monkeypatch.setattr(flank_poses, "TOGETHER", 3)


@pytest.mark.parametrize(
    ("poses", "worn"),
    [(2, False), (71, False), (BLOCK - 1, True), (BLOCK, True), (BLOCK + 1, True), (71, True)],
)
def test_blocks_give_the_same_bytes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, poses: int, worn: bool
) -> None:
    process = {"kind": "constant", "frame": "path", "wrench": [-160.0, 90.0, 120.0, 5.0, -4.0, 3.0]}
    cell = {"gravity": "uncompensated", "process": process}
    job = files(tmp_path, cell, WORN if worn else MODEL, rows=wavy(poses, rapid=poses > 40))
    whole = written(job, "whole")
    in_small_blocks(monkeypatch)
    assert written(job, "blocks") == whole and len(whole) == 4



def nominal_program(job: Files) -> Path:
    """A RAPID program of the path in modules of 20 moves, nobody's; some of its targets are computed."""
    given = read_input(files_of(job.toolpath, None), job.cell)
    plain = uncompensated(given.job, planned(given.job, given.path))
    program = replace(program_of(plain, corrected=False, name="NOM"), heading="Program")
    (job.folder / "source").mkdir()
    main, *modules = write_program(program, job.folder / "source" / "nom.mod", "rapid").files
    for file in modules:
        moves = iter(re.split(r"(?<=MoveL )(\[.*?\]\]),", file.read_text()))
        pieces = [next(moves)]
        for k, (target, rest) in enumerate(zip(moves, moves, strict=True)):
            pieces += [f"Offs({target},0.5,0,0)" if k % 7 == 3 else target, ",", rest]
        file.write_text("".join(pieces))
    return main


@pytest.mark.parametrize(("poses", "worn"), [(3, False), (71, False), (33, True), (71, True)])
def test_a_program_is_filtered_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, poses: int, worn: bool
) -> None:
    process = {"kind": "constant", "frame": "path", "wrench": [-160.0, 90.0, 120.0, 5.0, -4.0, 3.0]}
    job = files(
        tmp_path, {"gravity": "uncompensated", "process": process}, WORN if worn else MODEL,
        rows=wavy(poses, rapid=poses > 40),
    )  # fmt: skip
    monkeypatch.setattr(writer, "MOVES_PER_MODULE", 20)
    main, seen = nominal_program(job), []
    for name in ("whole", "blocks"):
        folder = job.out / name
        folder.mkdir(parents=True)
        done = compensate_file(main, job.cell, folder / "nom.mod", json=folder / "s.json")
        assert any("became numbers" in f.what for f in done.findings) == (poses > 3)
        seen.append(hashes(folder))
        in_small_blocks(monkeypatch)
    assert seen[0] == seen[1] and len(seen[0]) >= 2
