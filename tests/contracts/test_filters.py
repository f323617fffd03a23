"""One suite over all filters: a finished program comes back byte by byte, but for the poses of its cuts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.contracts.samples import FILTERED, to_read
from tests.oracles.commanded import SHIFT, TURN, changed_lines, commanded, whole, without_marker
from toolpaths.errors import ReadError, WriteError
from toolpaths.files import read_toolpath, refuse_own
from toolpaths.languages.table import LANGUAGES
from toolpaths.rewriting.filter import Rewritten
from toolpaths.toolpath import CUT, Toolpath
from toolpaths.writing.program import Program

CHORD = 1e-4  # m: arcs of some points


def rewritten(name: str, file: Path, made: Program, row: np.ndarray) -> Rewritten:
    return LANGUAGES[name].rewrite(file.read_bytes(), made, row, file, None)


def read_again(name: str, out: Rewritten, folder: Path) -> Toolpath:
    """What stands in the changed program, which is refused as a source."""
    folder.mkdir()
    file = to_read(folder, name, out.text)
    for suffix, data in out.beside:
        file.with_suffix(suffix).write_bytes(data)
    with pytest.raises(ReadError, match="compensated already") as caught:
        refuse_own(file)
    assert caught.value.line == out.text[: out.text.index(b"compensated by")].count(b"\n") + 1
    return read_toolpath(file, chord=CHORD)


def ended(name: str, end: str) -> tuple[str, tuple[str, str] | None]:
    """The source with these line ends, and what belongs to it."""
    sample = FILTERED[name]
    beside = None if sample.beside is None else (sample.beside[0], sample.beside[1].replace("\n", end))
    return sample.source.replace("\n", end), beside


def turn_of(name: str) -> np.ndarray:
    return TURN.as_rotvec() if FILTERED[name].turns else np.zeros(3)


@pytest.mark.parametrize("name", FILTERED)
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_nothing_changes_but_the_marker(tmp_path: Path, name: str, end: str) -> None:
    text, beside = ended(name, end)
    file = to_read(tmp_path, name, text, beside)
    refuse_own(file)
    out = rewritten(name, file, *commanded(read_toolpath(file, chord=CHORD)))
    lines = out.text.decode().split(end)
    at, marker = FILTERED[name].marker
    assert tuple(lines[at - 1 : at - 1 + len(marker)]) == marker
    del lines[at - 1 : at - 1 + len(marker)]
    assert end.join(lines) == text and out.changes == ()
    assert out.beside == (() if beside is None else ((beside[0], beside[1].encode()),))
    read_again(name, out, tmp_path / "again")


@pytest.mark.parametrize("name", FILTERED)
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_only_poses_of_cuts_change(tmp_path: Path, name: str, end: str) -> None:
    """Rapids are commanded elsewhere as well: the filter leaves them."""
    sample = FILTERED[name]
    file = to_read(tmp_path, name, *ended(name, end))
    path = read_toolpath(file, chord=CHORD)
    made, row = commanded(path, shift=SHIFT, turn=turn_of(name))
    out = rewritten(name, file, made, row)
    gone, come = changed_lines(file.read_bytes(), out.text)
    assert (len(gone), len(come)) == sample.lines
    for text in (out.text, *(data for _, data in out.beside)):
        assert text.count(end.encode()) == text.count(b"\n")
    again = read_again(name, out, tmp_path / "again")
    a, b = whole(path), whole(again)
    cut = path.kind[a] == CUT
    assert len(a) == len(b)
    np.testing.assert_allclose(again.position[b][cut], made.position[a][cut], atol=sample.position)
    np.testing.assert_array_equal(again.position[b][~cut], path.position[a][~cut])
    if again.quaternion is not None:
        back = Rotation.from_quat(again.quaternion[b][cut], scalar_first=True).as_matrix()
        np.testing.assert_allclose(back, made.rotation[a][cut], atol=sample.rotation)
    for field in ("kind", "feed", "tool"):
        np.testing.assert_array_equal(getattr(again, field)[b], getattr(path, field)[a])
    if path.setting is not None:
        np.testing.assert_array_equal(again.setting.zones, path.setting.zones)
        np.testing.assert_array_equal(again.setting.configuration, path.setting.configuration)
    told = " ".join(f"{c.place}: {c.what}" for c in out.changes)
    assert all(words in told for words in sample.told)
    assert all(words in out.text.decode() for words in sample.shown)


@pytest.mark.parametrize(
    ("name", "grown"), [(n, g) for n, sample in FILTERED.items() for g in (0.0, 0.01) if sample.arcs_grow or not g]
)
def test_an_arc_that_is_on_an_arc_again_stays_one(tmp_path: Path, name: str, grown: float) -> None:
    """Moved as a whole, or grown: other numbers for its points, no other change."""
    sample = FILTERED[name]
    file = to_read(tmp_path, name, sample.arc[0])
    path = read_toolpath(file, chord=CHORD)
    made, row = commanded(path, shift=np.array([2e-5, 0.0, 1e-4]) + grown * (path.position - [0.01, 0, 0]))
    out = rewritten(name, file, made, row)
    again = read_again(name, out, tmp_path / "again")
    cut = path.kind == CUT
    assert out.changes == () and out.text.count(sample.arc[1].encode()) == 1 and len(again) == len(path) > 5
    np.testing.assert_allclose(again.position[cut], made.position[cut], atol=10 * sample.position)


@pytest.mark.parametrize("name", FILTERED)
def test_an_arc_that_is_none_any_more_becomes_lines(tmp_path: Path, name: str) -> None:
    sample = FILTERED[name]
    file = to_read(tmp_path, name, sample.arc[0])
    path = read_toolpath(file, chord=CHORD)
    arc = np.isin(np.ceil(path.row - 1e-9), np.ceil(path.row[path.row % 1 != 0]))
    made, row = commanded(path, shift=1e-4 * np.where(arc, np.sin(40 * path.row), 0.0)[:, None] + [0.0, 0.0, 1e-4])
    out = rewritten(name, file, made, row)
    again = read_again(name, out, tmp_path / "again")
    cut = path.kind == CUT
    assert sample.arc[1].encode() not in out.text and len(again) == len(path) > 5
    assert tuple(change.what for change in out.changes) == sample.arc_told
    np.testing.assert_allclose(again.position[cut], made.position[cut], atol=sample.position)


@pytest.mark.parametrize(
    ("name", "text", "pose", "refusal", "time"),
    [(name, *case) for name, sample in FILTERED.items() for case in sample.by_time],
)
def test_a_move_by_time_is_not_divided(
    tmp_path: Path, name: str, text: str, pose: int, refusal: str, time: str
) -> None:
    """Each part would take the whole time. Without poses put in it stays as it is."""
    file = to_read(tmp_path, name, text)
    path = read_toolpath(file)
    made, row = commanded(path, [*range(pose), pose, *range(pose, len(path))])
    row = row.copy()
    row[pose] -= 0.5
    with pytest.raises(WriteError) as caught:
        rewritten(name, file, made, row)
    assert refusal in str(caught.value)
    assert time in rewritten(name, file, *commanded(path, shift=1e-4)).text.decode()


@pytest.mark.parametrize("name", [name for name, sample in FILTERED.items() if sample.twice])
def test_a_line_that_runs_twice_takes_one_pose_only(tmp_path: Path, name: str) -> None:
    text, refusal = FILTERED[name].twice or ("", "")
    file = to_read(tmp_path, name, text)
    path = read_toolpath(file)
    assert len(path) == 2
    with pytest.raises(WriteError) as caught:
        rewritten(name, file, *commanded(path, shift=np.outer([1, 2], SHIFT)))
    assert refusal in str(caught.value)


@pytest.mark.parametrize("name", [name for name, sample in FILTERED.items() if sample.real is not None])
def test_real_programs_come_back_word_by_word(shared: Path, tmp_path: Path, name: str) -> None:
    sample, language = FILTERED[name], LANGUAGES[name]
    refused = sample.real or {}
    files = [f for f in sorted((shared / "data/cam").rglob("*")) if f.suffix.lower() in language.reads]
    assert {f.name for f in files} > set(refused)
    for file in files:
        if file.name in refused:
            with pytest.raises(ReadError, match=refused[file.name]):
                read_toolpath(file)
            continue
        path = read_toolpath(file)
        same = rewritten(name, file, *commanded(path, np.flatnonzero(path.kind == CUT)))  # rapids need no pose
        assert without_marker(same.text) == file.read_bytes()
        if not np.isfinite(path.position[whole(path)][path.kind[whole(path)] == CUT]).all():
            continue  # a cut to joint angles: it ends where the robot leads
        made, row = commanded(path, shift=SHIFT, turn=turn_of(name))
        out = rewritten(name, file, made, row)
        gone, come = changed_lines(file.read_bytes(), out.text)
        cuts = path.kind[whole(path)] == CUT
        assert len(gone) == len(come) - len(sample.marker[1]) == sample.lines_of_a_pose * cuts.sum(), file.name
        again = read_again(name, out, tmp_path / file.stem)
        ends = again.position[whole(again)][cuts]
        np.testing.assert_allclose(ends, made.position[whole(path)][cuts], atol=sample.position)


@pytest.mark.parametrize("name", [name for name, sample in FILTERED.items() if sample.elsewhere])
def test_calls_of_what_is_not_in_the_file_are_told(shared: Path, name: str) -> None:
    where, *words = FILTERED[name].elsewhere
    file = shared / "data/cam" / where
    out = rewritten(name, file, *commanded(read_toolpath(file), shift=SHIFT, turn=TURN.as_rotvec()))
    told = [str(c) for c in out.changes]
    assert len(told) == 1 and all(w in told[0] for w in [*words, "it is taken to leave the arm where it is"])
