"""One suite over every writer: golden programs, read-back, refusals, all or nothing on the disk."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.contracts.samples import READ, WRITTEN, to_write
from tests.oracles.patience import OWN_PEAK
from tests.oracles.sample_programs import SPINDLE, changed, random_program, small
from toolpaths.errors import ReadError, WriteError
from toolpaths.files import language_of, read_back, read_toolpath, refuse_own, write_program
from toolpaths.frame import Frame
from toolpaths.languages import table
from toolpaths.program_files import program_files
from toolpaths.toolpath import CUT

GOLDEN = Path(__file__).parent.parent / "golden"


def test_every_language_that_is_written_has_a_sample():
    assert set(WRITTEN) == {language.name for language in table.WRITTEN}
    assert len({language.writes for language in table.WRITTEN}) == len(WRITTEN)


@pytest.mark.parametrize("language", WRITTEN)
def test_golden(language, tmp_path):
    """The whole small program, byte by byte. To renew: write small() there and read the difference."""
    for path in write_program(small(), to_write(tmp_path, language)).files:
        assert path.read_bytes() == (GOLDEN / path.name).read_bytes()


@pytest.mark.parametrize("language", WRITTEN)
def test_same_program_same_bytes(language, tmp_path):
    texts = []
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        written = write_program(random_program(100, 3), to_write(tmp_path / folder, language))
        texts.append(b"".join(f.read_bytes() for f in written.files))
    assert texts[0] == texts[1] and len(texts[0]) > 5000


@pytest.mark.parametrize("language", WRITTEN)
@pytest.mark.parametrize("n", [1, 2, 700, 5001, 12345])
def test_read_back(language, n, tmp_path):
    program, sample = random_program(n, n), WRITTEN[language]
    written = write_program(program, to_write(tmp_path, language))
    assert written.files[0] == to_write(tmp_path, language)
    assert {f.name for f in tmp_path.iterdir()} == {f.name for f in written.files}
    assert (len(written.files) > sample.files) == (n > 5000 and sample.split)
    back = read_back(written.files[0])
    assert len(back.position) == n
    np.testing.assert_allclose(back.position, program.position, atol=sample.position)
    known = np.s_[:] if sample.turns else np.s_[:, :, 2]  # else the tool vector
    np.testing.assert_allclose(back.rotation[known], program.rotation[known], atol=sample.rotation)
    feed = np.where(np.isnan(program.feed), 0.5 if sample.rapid_speed else np.nan, program.feed)
    np.testing.assert_allclose(back.feed, feed, rtol=sample.feed)
    if back.configuration is not None:
        np.testing.assert_array_equal(back.configuration, program.configuration)
    start = program.joints[0] if back.joints is None else back.joints[0]
    np.testing.assert_allclose(start, program.joints[0], atol=1e-8)
    if back.start_joints is not None:
        np.testing.assert_allclose(back.start_joints, program.joints[0], atol=1e-8)


@pytest.mark.parametrize("language", [name for name in WRITTEN if name in READ and not table.LANGUAGES[name].table])
def test_what_is_written_is_read(language, tmp_path):
    """By the reader of the language: what the read-back finds, to the printed digits; as a source it is refused."""
    program, sample = random_program(2000, 6), WRITTEN[language]
    write_program(program, file := to_write(tmp_path, language))
    with pytest.raises(ReadError, match="compensated already") as caught:
        refuse_own(file)
    assert b"ompensated " in file.read_bytes().split(b"\n")[caught.value.line - 1]
    path, back = read_toolpath(file), read_back(file)
    assert len(path) == len(program) + sample.start
    path = path.take(np.arange(sample.start, len(path)))
    work = program.workobject if sample.in_base else Frame.identity()
    rotation = work.rotation @ program.rotation
    np.testing.assert_allclose(path.position, work.at(back.position), atol=1e-12)
    np.testing.assert_allclose(path.position, work.at(program.position), atol=sample.position)
    np.testing.assert_array_equal(path.kind, CUT if sample.rapid_speed else program.kind)  # lines with a speed are cuts
    feed = np.where(program.kind == CUT, program.feed, program.rapid_speed)
    cut = path.kind == CUT
    np.testing.assert_allclose(path.feed[cut], feed[cut], rtol=sample.feed)
    np.testing.assert_allclose(-path.axis, rotation[:, :, 2], atol=sample.rotation)
    if sample.turns:
        turned = Rotation.from_quat(path.quaternion, scalar_first=True).as_matrix()
        np.testing.assert_allclose(turned, rotation, atol=sample.rotation)
    if sample.frame is not None:
        setting, wanted = path.setting, program.tools[1]
        np.testing.assert_allclose(setting.workobject.matrix, program.workobject.matrix, atol=sample.frame)
        (tool,) = setting.tools.values()
        np.testing.assert_allclose(tool.frame.matrix, wanted.frame.matrix, atol=sample.frame)
        assert tool.mass is None or tool.mass == wanted.mass
        told = setting.configuration[-len(program) :]
        assert (told == program.configuration).all() or (told == -1).all()


@pytest.mark.parametrize("language", WRITTEN)
@pytest.mark.parametrize("name", ["position", "rotation", "joints"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_not_a_number_is_refused_with_its_pose(language, name, value, tmp_path):
    program = random_program(50, 1)
    array = getattr(program, name).copy()
    array[37, 1] = value
    with pytest.raises(WriteError, match=rf"pose 37 \(random.nc:38\): {name} is not a finite number"):
        write_program(changed(program, **{name: array}), to_write(tmp_path, language))
    assert list(tmp_path.iterdir()) == []


REFUSED = [
    ("no pose", lambda p: cut_out(p, slice(0, 0)), "no pose"),
    ("mirrored", lambda p: changed(p, rotation=-p.rotation), r"pose 0 .*\(and 7 more places\): .*no rot"),
    ("no feed", lambda p: changed(p, feed=put(p.feed, 4, np.nan)), r"pose 4 \(part.nc:14\).*without a feed"),
    ("feed 0", lambda p: changed(p, feed=put(p.feed, 3, 0.0)), r"pose 3 .*not above 0"),
    ("feed backwards", lambda p: changed(p, feed=put(p.feed, 3, -0.02)), r"pose 3 .*not above 0"),
    ("feed infinite", lambda p: changed(p, feed=put(p.feed, 3, np.inf)), r"pose 3 .*not above 0"),
    ("rapid speed", lambda p: changed(p, rapid_speed=0.0), "rapid speed.*not above 0"),
    ("kind", lambda p: changed(p, kind=put(p.kind, 5, 2)), "pose 5 .*neither a rapid nor a cut"),
    ("tool", lambda p: changed(p, tool=put(p.tool, 6, 9)), r"pose 6 .*tool 9 has no frame.*\[tools.9\]"),
    ("base", lambda p: changed(p, workobject=based(np.eye(3), np.nan)), "workobject: not a finite number"),
    ("base", lambda p: changed(p, workobject=based(np.eye(3) * np.nan, 0.0)), "workobject: not a finite number"),
    ("base", lambda p: changed(p, workobject=based(2 * np.eye(3), 0.0)), "workobject: the orientation is no rotation"),
]  # fmt: skip


def based(rotation: np.ndarray, origin: float) -> Frame:
    return Frame(rotation, np.full(3, origin))


def put(values: np.ndarray, at: int, value: float) -> np.ndarray:
    out = values.copy()
    out[at] = value
    return out


def cut_out(program, s: slice):
    arrays = ("position", "rotation", "joints", "feed", "kind", "tool", "line", "configuration", "exact")
    return changed(program, **{a: getattr(program, a)[s].copy() for a in arrays})


@pytest.mark.parametrize("language", WRITTEN)
@pytest.mark.parametrize(("case", "spoil", "message"), REFUSED, ids=[r[0] for r in REFUSED])
def test_refused_as_a_whole(language, case, spoil, message, tmp_path):
    old = to_write(tmp_path, language)
    old.write_bytes(b"what was there")
    with pytest.raises(WriteError, match=message):
        write_program(spoil(small()), old)
    assert old.read_bytes() == b"what was there"
    assert len(list(tmp_path.iterdir())) == 1


def test_all_findings_are_listed_at_once(tmp_path):
    p = small()
    spoilt = changed(p, feed=put(p.feed, 4, np.nan), tool=put(p.tool, 6, 9))
    with pytest.raises(WriteError) as caught:
        write_program(spoilt, tmp_path / "a.mod")
    assert "without a feed" in str(caught.value) and "tool 9" in str(caught.value)


def test_language_of():
    assert language_of("X/PART.MOD").name == "rapid"
    assert language_of("part.txt", "krl").name == "krl"
    assert language_of("part_c.ngc", like=program_files(["part.NGC"])).name == "gcode"
    assert language_of("part_c.ngc", "csv", like=program_files(["part.NGC"])).name == "csv"
    assert language_of("part_c.txt", like=program_files(["part.txt"], "krl")).name == "krl"
    with pytest.raises(WriteError, match="no format 'apt'; known: rapid"):
        language_of("part_c.cls", like=program_files(["part.cls"]))
    with pytest.raises(WriteError, match=r"'.txt' is no language's \(.mod rapid"):
        language_of("part.txt")
    with pytest.raises(WriteError, match="no format 'basic'; known: rapid"):
        language_of("part.mod", "basic")


# --- the disk ---------------------------------------------------------------------------------------------


def sizes(folder: Path) -> dict[str, bytes]:
    return {f.name: f.read_bytes() for f in folder.iterdir()}


@pytest.mark.parametrize("language", WRITTEN)
def test_full_disk_leaves_nothing_behind(language, tmp_path):
    """A file-size limit stands for the full disk: the write fails in the middle, after files are complete."""
    write_program(small(), to_write(tmp_path, language))
    before = sizes(tmp_path)
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    old = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    try:
        # small main modules fit, the parts do not
        resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, hard))
        with pytest.raises(WriteError, match=r"cannot be written: File too large. Nothing was changed"):
            write_program(random_program(6000, 2), to_write(tmp_path, language))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        signal.signal(signal.SIGXFSZ, old)
    assert sizes(tmp_path) == before


@pytest.mark.parametrize("language", WRITTEN)
def test_failing_rename_puts_everything_back(language, tmp_path, monkeypatch):
    """The last of several renames fails: what was renamed before is as it was."""
    write_program(random_program(6000, 2), to_write(tmp_path, language))
    before, real, left = sizes(tmp_path), os.replace, [len(sizes(tmp_path)) - 1]

    def replace(source, to):
        if Path(source).suffix != ".old":  # what is put back is
            if left[0] == 0:
                raise OSError(5, "Input/output error")
            left[0] -= 1
        real(source, to)

    monkeypatch.setattr(os, "replace", replace)
    with pytest.raises(WriteError, match=r"Input/output error\. Nothing was changed"):
        write_program(random_program(6000, 3), to_write(tmp_path, language))
    assert sizes(tmp_path) == before


@pytest.mark.parametrize("language", WRITTEN)
def test_folder_that_does_not_take_files(language, tmp_path):
    if os.geteuid() == 0:
        folder = Path("/proc/self")  # not even root can make a file here
    else:
        folder = tmp_path / "closed"
        folder.mkdir(mode=0o500)
    with pytest.raises(WriteError, match=r"part1\.\w+: cannot be written"):
        write_program(small(), to_write(folder, language))
    with pytest.raises(WriteError, match="cannot be written: No such file or directory"):
        write_program(small(), to_write(tmp_path / "missing", language))
    (tmp_path / "taken").mkdir()
    to_write(tmp_path / "taken", language).mkdir()
    with pytest.raises(WriteError, match="a folder of this name is in the way"):
        write_program(small(), to_write(tmp_path / "taken", language))
    assert len(list((tmp_path / "taken").iterdir())) == 1


@pytest.mark.parametrize("language", WRITTEN)
def test_memory_is_bounded_by_blocks(language, tmp_path):
    """What writing takes on top of the program does not grow with the text."""
    script = (
        "import resource, sys\n"
        "from tests.oracles.sample_programs import random_program\n"
        "from toolpaths.files import write_program\n"
        "p = random_program(200_000, 1, lock=False)\n"
        "before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss\n"
        "write_program(p, sys.argv[1])\n"
        "print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024)\n"
    )
    done = subprocess.run(
        [*OWN_PEAK, sys.executable, "-c", script, str(to_write(tmp_path, language))],
        capture_output=True, text=True, check=True, cwd=GOLDEN.parent.parent,
    )  # fmt: skip
    written = sum(f.stat().st_size for f in tmp_path.iterdir()) / 2**20
    assert written > 13
    assert float(done.stdout) < 40  # MB; the text alone would be more than that in most languages


def test_load_that_is_not_known_is_said(tmp_path):
    tool = type(SPINDLE)(SPINDLE.name, SPINDLE.frame)
    for language in ("rapid", "krl"):
        written = write_program(changed(small(), tools={1: tool}), to_write(tmp_path, language))
        assert any("tool 1" in str(f) and "mass is not known" in str(f) for f in written.findings)
        assert write_program(small(), to_write(tmp_path, language)).findings == ()
