"""One suite over all readers of toolpath files: the same poses, what is no toolpath file, and what is imported."""

from __future__ import annotations

import subprocess
import sys
import tracemalloc
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from tests.contracts.samples import READ, SAMPLES, to_read
from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath
from toolpaths.languages import table
from toolpaths.program_files import LIST

EVERY = [(language.name, suffix) for language in table.READ for suffix in language.reads]


def test_every_reader_has_a_sample_and_a_module() -> None:
    assert set(READ) == {language.name for language in table.READ} and list(SAMPLES) == list(table.LANGUAGES)
    for name in READ:
        assert callable(import_module(f"toolpaths.languages.{name}.reader").read)


@pytest.mark.parametrize(("name", "suffix"), [(name, suffix) for name, suffix in EVERY if suffix != LIST])
@pytest.mark.parametrize("dress", ["plain", "crlf", "bom", "upper"])
def test_same_poses_from_every_language(tmp_path: Path, name: str, suffix: str, dress: str) -> None:
    text = READ[name].text.replace("\n", "\r\n") if dress == "crlf" else READ[name].text
    file = tmp_path / f"part{suffix.upper() if dress == 'upper' else suffix}"
    file.write_bytes(text.encode("utf-8-sig" if dress == "bom" else "utf-8"))
    path = read_toolpath(str(file))
    expected = np.array([[0, 0, 5], [10, 0, 0], [10, -4, 0], [10, -4, 5]]) * 1e-3
    np.testing.assert_allclose(path.position, expected, rtol=0, atol=1e-15)
    np.testing.assert_allclose(path.axis, [[0, 0, 1]] * 4, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(path.kind, [0, 1, 1, 0])
    air = READ[name].rapid_feed
    np.testing.assert_allclose(path.feed, [air, 0.01, 0.01, air], rtol=1e-14)
    np.testing.assert_array_equal(path.row, [0, 1, 2, 3])
    assert [text.split("\n")[n - 1].count("5") for n in path.line] == [1, 0, 0, 1]
    assert (path.source, path.language) == (str(file), name)
    kinds = {
        "position": "f8",
        "axis": "f8",
        "feed": "f8",
        "kind": "u1",
        "tool": "i4",
        "spindle": "f8",
        "sense": "i1",
        "line": "i4",
        "row": "f8",
    }
    for field, dtype in kinds.items():
        value = getattr(path, field)
        assert value.dtype == np.dtype(dtype) and len(value) == 4 and not value.flags.writeable, field


@pytest.mark.parametrize("name", READ)
@pytest.mark.parametrize(
    ("data", "word"),
    [
        (b"", "empty"),
        (b" \r\n\t\n", "empty"),
        (b"\x7fELF\x02\x01\x00\x00", "binary"),
        ("G0 X1\n".encode("utf-16"), "UTF-16"),
        (b"GOTO/1,2\x01,3\n", "not a text file"),
        (b"<<<<<<< ours\nG1\n=======\nG2\n>>>>>>> theirs\n", "merge-conflict"),
        (b"%PDF-1.7\nxref\n", ""),
        (b"<html><body>Not found</body></html>\n", ""),
    ],
)
def test_mistakes_of_a_person(tmp_path: Path, name: str, data: bytes, word: str) -> None:
    file = to_read(tmp_path, name, data)
    with pytest.raises(ReadError) as caught:
        read_toolpath(file)
    assert word in str(caught.value) and str(caught.value).startswith(str(file))


@pytest.mark.parametrize("name", READ)
def test_missing_file_and_folder(tmp_path: Path, name: str) -> None:
    suffix = table.LANGUAGES[name].reads[0]
    with pytest.raises(ReadError, match="no such file"):
        read_toolpath(tmp_path / f"none{suffix}")
    (tmp_path / f"folder{suffix}").mkdir()
    with pytest.raises(ReadError, match="folder"):
        read_toolpath(tmp_path / f"folder{suffix}")


def test_unknown_suffix_lists_the_known(tmp_path: Path) -> None:
    for suffix in (".stl", ""):
        file = tmp_path / f"part{suffix}"
        file.write_text("G0")
        with pytest.raises(ReadError) as caught:
            read_toolpath(file)
        assert all(known in str(caught.value) for _, known in EVERY)


def test_senseless_chord(tmp_path: Path) -> None:
    for chord in (0.0, -1e-5, float("nan"), 2.0):
        with pytest.raises(ValueError, match="chord"):
            read_toolpath(to_read(tmp_path, "gcode", READ["gcode"].text), chord=chord)


@pytest.mark.parametrize("name", [n for n in READ if not table.LANGUAGES[n].table])
def test_every_cut_off_file_is_refused_or_whole(tmp_path: Path, name: str) -> None:
    """Cut at any byte: refused; or only the end word is missing and the poses are those of the lines left."""
    text = READ[name].text
    whole = read_toolpath(to_read(tmp_path, name, text))
    for end in range(len(text) - 1):
        file = to_read(tmp_path, name, text[:end])
        try:
            path = read_toolpath(file)
        except ReadError:
            continue
        assert text[end - 1] == "\n" or text[end:].strip("\n") == "" or "M30" in text[:end]
        np.testing.assert_array_equal(path.position, whole.position[: len(path)])


@pytest.mark.parametrize("name", [n for n, sample in READ.items() if sample.huge])
def test_arcs_do_not_fill_the_memory(tmp_path: Path, name: str) -> None:
    """Circles of a radius of 900 m: what they make of a small file, and from which chord on it is too much."""
    text, chord = READ[name].huge or ("", 1.0)
    file = to_read(tmp_path, name, text)
    assert len(text) < 1024
    tracemalloc.start()
    try:
        with pytest.raises(ReadError, match=r"arcs make \d{7,} poses"):
            read_toolpath(file, chord=chord)
        assert tracemalloc.get_traced_memory()[1] < 5e6
    finally:
        tracemalloc.stop()
    assert 30 < len(read_toolpath(file, chord=0.9)) < 1e6


def imported(code: str) -> set[str]:
    """Modules that are there after ``code``, in a Python of its own."""
    root = Path(__file__).parents[2]
    command = [sys.executable, "-c", f"import sys; {code}; print(*sys.modules)"]
    return set(subprocess.run(command, cwd=root, timeout=60, check=True, capture_output=True, text=True).stdout.split())


def test_the_table_is_light() -> None:
    """The command line reads it to show its help."""
    assert "numpy" not in imported("import toolpaths.languages.table")


def test_languages_are_imported_only_when_used(tmp_path: Path) -> None:
    def folders(modules: set[str]) -> set[str]:
        return {m.split(".")[2] for m in modules if m.startswith("toolpaths.languages.")} - {"table"}

    assert folders(imported("import toolpaths.files")) == set()
    for name, sample in READ.items():
        file = to_read(tmp_path, name, sample.text)
        found = imported(f"from toolpaths.files import read_toolpath; read_toolpath({str(file)!r})")
        assert folders(found) == {name} and "scipy" not in found
        assert not [m for m in found if m.endswith((".writer", ".filter")) and m.startswith("toolpaths.languages")]
