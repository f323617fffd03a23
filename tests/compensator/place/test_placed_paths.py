"""Studies of placements: what is judged, ranked, refused, resumed; whole runs in one process."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from compensator.cell.cell_file import load_cell
from compensator.errors import CompensatorError
from compensator.place.candidates import box, listed
from compensator.place.judge import with_most_room
from compensator.place.parts import Parts
from compensator.place.study import windows
from compensator.tasks.compensate import compensate_file, preview_file
from compensator.tasks.place import place_file
from tests.compensator import small_job
from tests.compensator.place import placement_job


def study(files: small_job.Files, name: str = "s.parquet", within: str = placement_job.BOX, **options):
    return place_file(
        files.toolpath, files.cell, files.out / name, within=within, turns=4, poses=20, workers=1, **options
    )


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory):
    files = placement_job.files(tmp_path_factory.mktemp("place"))
    best, png = files.folder / "elsewhere" / "best.toml", files.out / "s.png"
    best.parent.mkdir()
    return files, study(files, best=best, png=png, json=files.out / "s.json")


def test_every_placement_is_one_of_four(done) -> None:
    _, made = done
    where = {(x, y): s for x, y, s in zip(*(made.columns[c] for c in ("x_mm", "y_mm", "status")), strict=True)}
    assert len(where) == 15
    assert where[(1700.0, -300.0)] == "good"
    assert where[(3500.0, 50.0)] == "out-of-reach"
    assert where[(1700.0, 400.0)] == "collides"
    assert {c for c, s in zip(made.columns["collision"], made.columns["status"], strict=True) if s == "collides"} <= {
        "tool and wall", *(f"link-{k} and wall" for k in range(1, 7))
    }


def test_the_deflection_is_that_of_a_preview_there(done) -> None:
    files, made = done
    (row,) = [k for k, p in enumerate(made.report["whole_path"]) if p["holds"]]
    best = made.report["ranked"][row]
    report = preview_file(files.toolpath, files.folder / "elsewhere" / "best.toml").report
    there = report["predicted_error_mm"]["before"]
    assert best["deflection_mean_mm"] == pytest.approx(there["mean"], rel=0.03)  # 20 poses against all of them
    assert best["deflection_p95_mm"] == pytest.approx(there["p95"], rel=0.05)
    assert 0.01 < best["sd_mm"] / best["deflection_mean_mm"] < 0.05  # every joint by 5 %, not all in one way
    assert best["stiffness_n_per_um"] > 0.1


def test_the_rank_follows_the_score(done) -> None:
    _, made = done
    scores = [row["score_mm"] for row in made.report["ranked"]]
    assert scores == sorted(scores) and len(scores) == made.report["status"]["good"] > 3
    assert scores[0] == pytest.approx(
        made.report["ranked"][0]["sd_mm"]
        + 1e-3 * made.report["ranked"][0]["reversals_per_m"]
        + max(made.report["ranked"][0]["speed_share"] - 1.0, 0.0)
    )


def test_the_best_cell_has_the_placement_and_keeps_the_rest(done) -> None:
    files, made = done
    old, new = load_cell(files.cell), load_cell(files.folder / "elsewhere" / "best.toml")
    first = made.report["ranked"][0]
    assert new.workobject.xyz == (first["x_mm"], first["y_mm"], first["z_mm"])
    assert new.workobject.rpy == old.workobject.rpy  # yaw of the cell, which the box does not name
    assert new.scene == old.scene and new.process == old.process
    assert not new.solve.free_tool_axis


def test_the_same_study_again_is_the_same_bytes_and_another_one_is_refused(done) -> None:
    files, _ = done
    before = (files.out / "s.parquet").read_bytes()
    study(files)
    assert (files.out / "s.parquet").read_bytes() == before
    with pytest.raises(CompensatorError, match=r"belongs to another study .* Take it away"):
        study(files, within="x=1100:3500:4")
    assert (files.out / "s.parquet").read_bytes() == before
    assert sorted(p.name for p in files.out.iterdir()) == ["s.json", "s.parquet", "s.png"]


def test_a_stopped_study_goes_on_where_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from compensator.place import study as study_module

    monkeypatch.setattr(study_module, "POSTURES", 2500)  # tasks of a few placements
    files = placement_job.files(tmp_path)
    written = Parts.write

    def stops(self: Parts, batch: range, rows) -> None:
        if batch.start > 0:
            raise KeyboardInterrupt
        written(self, batch, rows)

    monkeypatch.setattr(Parts, "write", stops)
    with pytest.raises(KeyboardInterrupt):
        study(files)
    assert [p.name for p in files.out.iterdir()] == ["s.parquet.parts"]
    monkeypatch.setattr(Parts, "write", written)
    made = study(files, json=files.out / "s.json")
    assert made.report["n_tasks_resumed"] == 1 and made.report["n_tasks"] > 2
    study(placement_job.files(tmp_path), "whole.parquet")
    assert (files.out / "s.parquet").read_bytes() == (files.out / "whole.parquet").read_bytes()
    assert json.loads((files.out / "s.json").read_text())["status"] == made.report["status"]
    table = pq.read_table(files.out / "s.parquet")
    assert table.column("index").to_pylist() == list(range(15))


def test_what_is_no_study_is_refused(tmp_path: Path) -> None:
    files = placement_job.files(tmp_path)
    (files.out / "s.parquet").write_text("something else")
    with pytest.raises(CompensatorError, match="is no study"):
        study(files)
    assert (files.out / "s.parquet").read_text() == "something else"


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"scheduler": "tcp://127.0.0.1:9"}, "no scheduler answers there within 5s"),
        ({"within": None}, "give either --box"),
        ({"within": "x=1:2"}, "expected a number, or least:largest:count"),
        ({"within": "u=1:2:3"}, "expected one of x, y, z, roll, pitch, yaw"),
    ],
)
def test_refusals(tmp_path: Path, options: dict, words: str) -> None:
    files = placement_job.files(tmp_path)
    with pytest.raises(CompensatorError, match=words):
        study(files, **options)
    assert files.left() == []


def test_a_list_of_placements(tmp_path: Path) -> None:
    path = tmp_path / "places.csv"
    path.write_text("x_mm,y_mm,z_mm,yaw_deg\n1500,-100,800,30\n1600,0,700,0\n")
    assert listed(path).poses.tolist() == [[1500, -100, 800, 0, 0, 30], [1600, 0, 700, 0, 0, 0]]
    path.write_text("x_mm,y_mm,z_mm\n1500,-100,high\n")
    with pytest.raises(CompensatorError, match=r"places\.csv:2: z_mm = 'high'"):
        listed(path)
    path.write_text("x_mm,y_mm,depth\n")
    with pytest.raises(CompensatorError, match="unknown column 'depth'"):
        listed(path)


def test_a_box_keeps_what_it_does_not_name(tmp_path: Path) -> None:
    cell = load_cell(placement_job.files(tmp_path).cell)
    poses = box("x=1000:1200:2, yaw=-90:90:3", cell.workobject).poses
    assert poses[:, 0].tolist() == [1000.0] * 3 + [1200.0] * 3
    assert poses[:3, 5].tolist() == [-90.0, 0.0, 90.0]
    assert np.all(poses[:, 1:3] == [-150.0, 800.0])


def test_poses_are_taken_in_rows() -> None:
    rows = windows(10_000, 200)
    assert len(rows) == 200 and rows[0] == 0 and rows[-1] == 9999
    assert np.sum(np.diff(rows) == 1) == 180
    assert windows(7, 200).tolist() == list(range(7))


@pytest.mark.parametrize("solve", [{"turn": "path"}, {"lean": 4.0}])
def test_what_is_chosen_along_the_path_is_chosen_at_the_best_and_stays_in_its_cell(tmp_path: Path, solve: dict) -> None:
    """The ranking is that of constant turns; the command tells so."""
    plain = study(placement_job.files(tmp_path), "plain.parquet")
    files = placement_job.files(tmp_path, solve=solve)
    made = study(files, best=files.out / "best.toml")
    assert [r["index"] for r in made.report["ranked"]] == [r["index"] for r in plain.report["ranked"]]
    (note,) = [f for f in made.report["findings"] if "ranked by turns that stay the same" in f["what"]]
    key = ", ".join(f'{k} = "{v}"' if isinstance(v, str) else f"{k} = {v:g}" for k, v in solve.items())
    assert note["where"] == str(files.cell) and note["what"].startswith(f"solve.{key}: ")
    assert made.report["whole_path"][-1]["holds"]
    best = load_cell(files.out / "best.toml")
    assert best.solve.along_path == f"solve.{key}" and best.solve.free_tool_axis
    turn = compensate_file(files.toolpath, files.out / "best.toml", files.out / "c.mod").report["turn"]
    assert turn["chosen"]["cost_um2"]["sum"] < turn["constant"]["cost_um2"]["sum"]
    assert not [f for f in plain.report["findings"] if "ranked by turns" in f["what"]]


def test_a_turn_along_a_path_that_is_held_is_refused_before_anything_is_judged(tmp_path: Path) -> None:
    files = placement_job.files(tmp_path, solve={"turn": "path", "free_tool_axis": False})
    with pytest.raises(CompensatorError, match=r"free_tool_axis = false holds it; take one of the two away"):
        study(files)
    assert files.left() == []


def test_choices_with_as_much_room_are_looked_at_together() -> None:
    margin = np.array([0.9, 1.0, 0.2, 1.0, *[0.5] * 12, 0.4])
    blocks = [b.tolist() for b in with_most_room(np.arange(17) + 3, margin)]
    assert blocks == [[4, 6, 3, *range(7, 19)], [19, 5]]
