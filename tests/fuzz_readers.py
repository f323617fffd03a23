"""Coverage-guided fuzzing of the readers (atheris, libFuzzer): whatever a file holds, it is read or refused.

    python -m tests.fuzz_readers --language krl --runs 20000 --seed 1

A finding ends the run with status 77; its input is written beside the corpus, and its path is printed. Findings are:
anything but a ReadError, a toolpath whose numbers do not fit together, more than SLOW seconds or MEMORY megabytes.
"""

from __future__ import annotations

import argparse
import random
import re
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path

import atheris
import numpy as np

with atheris.instrument_imports(include=["toolpaths"]):
    from tests.contracts.samples import READ
    from tests.oracles.random_apt import RandomApt
    from tests.oracles.random_gcode import RandomProgram
    from tests.oracles.random_heidenhain import RandomKlartext
    from tests.oracles.random_siemens import RandomSiemens
    from toolpaths.errors import ReadError
    from toolpaths.languages.table import LANGUAGES
    from toolpaths.toolpath import CUT, Toolpath

    for name in READ:
        import_module(f"toolpaths.languages.{name}.reader")

ROOT = Path(__file__).parents[1]
BESIDE = b"\n;;;; beside it: .dat\n"  # some inputs are two files
SLOW, A_POSE = 20.0, 5e-5  # s for one input: 100,000 steps of its loops, watched; and for every pose that they make
LONGEST, MEMORY, HANG = 4096, 1500, 300  # bytes, MB, s (of the clock: other processes take their share)
CHORD = 1e-3  # m: arcs of a few points, so that the time goes into reading
RANDOM: dict[str, Callable[[int], str]] = {
    "gcode": lambda seed: RandomProgram(seed, 20).text,
    "siemens": lambda seed: RandomSiemens(seed, 20).text,
    "heidenhain": lambda seed: RandomKlartext(seed, 20).text,
    "apt": lambda seed: RandomApt(seed).text(),
}
Read = Callable[[Path], Toolpath]


def seeds(language: str) -> list[bytes]:
    """Small programs to begin with: those of the contracts, the pages, the golden files and the random writers."""
    suffixes, sample = LANGUAGES[language].reads, READ[language]
    texts = [sample.text]
    for page in sorted((ROOT / "docs").glob("*.md")):
        for word, text in re.findall(r"^```(\w+)[^\n]*\n(.*?)^```$", page.read_text(), re.M | re.S):
            texts += [text] if f".{word}" in suffixes else []
    texts += [RANDOM[language](seed) for seed in range(20)] if language in RANDOM else []
    if sample.whole and not sample.beside:
        texts.append(sample.whole)
    golden = [p.read_bytes() for p in sorted((ROOT / "tests/golden").iterdir()) if p.suffix in suffixes]
    out = [data[:LONGEST] for data in [*(text.encode() for text in texts), *golden]]
    if sample.beside:
        out.append(sample.whole.encode() + BESIDE + sample.beside[1].encode())
    return out


def words(language: str) -> list[bytes]:
    """What libFuzzer may put in: pieces of the language, and every word of the seeds."""
    found = {w.encode() for w in READ[language].fragments}
    for seed in seeds(language):
        found.update(re.findall(rb"[$#A-Za-z_][\w.$]+", seed))
    return sorted(w for w in found if 0 < len(w) < 40)


def reader(language: str, folder: Path) -> Callable[[bytes], Toolpath]:
    """The reader, for the content of a file; one of odd length stands on the machine of the sample, if any."""
    file, sample = folder / f"part{LANGUAGES[language].reads[0]}", READ[language]

    def run(data: bytes) -> Toolpath:
        main, _, beside = data.partition(BESIDE) if sample.beside else (data, b"", b"")
        file.write_bytes(main)
        if sample.beside:
            other = file.with_suffix(sample.beside[0])
            other.write_bytes(beside) if beside else other.unlink(missing_ok=True)
        return LANGUAGES[language].read(file, "part", CHORD, sample.machine if len(data) % 2 else None)

    return run


def check(path: Toolpath, lines: int) -> None:
    """Refuse a toolpath that does not fit together; Toolpath itself compares the lengths of its arrays."""
    n = len(path)
    known = np.ones(n, dtype=bool)
    if path.setting is not None and path.setting.joints:
        known = ~np.isin(path.row, list(path.setting.joints))  # their place is the robot's to say
    quaternion = path.quaternion if path.quaternion is not None else np.tile([1.0, 0.0, 0.0, 0.0], (n, 1))
    sound = {
        "no pose": n > 0,
        "position": np.isfinite(path.position[known]).all() and (np.abs(path.position[known]) <= 2e3).all(),
        "axis": np.allclose(np.linalg.norm(path.axis[known], axis=1), 1.0, rtol=0, atol=1e-6),
        "quaternion": np.allclose(np.linalg.norm(quaternion[known], axis=1), 1.0, rtol=0, atol=1e-6),
        "feed": not (path.feed[path.kind == CUT] <= 0).any() and not np.isinf(path.feed).any(),
        "kind": (path.kind <= 1).all(),
        "line": ((path.line >= 1) & (path.line <= lines)).all(),
        "row": np.isfinite(path.row).all() and (np.diff(path.row) > 0).all(),
        "events": all(0 <= e.pose <= n and 1 <= e.line <= lines for e in path.events),
    }
    if wrong := [name for name, good in sound.items() if not good]:
        raise ValueError(f"the toolpath does not fit together: {', '.join(wrong)}")


def one_input(read: Callable[[bytes], Toolpath], data: bytes) -> None:
    """Read one input and judge what comes out."""
    begin, poses = time.process_time(), 0
    try:
        path = read(data)
    except ReadError as refusal:
        if len(str(refusal)) > 2000:
            raise ValueError(f"a message of {len(str(refusal))} characters") from refusal
    else:
        check(path, len(re.findall(rb"\r\n|[\r\n\f]", data)) + 1)
        poses = len(path)
    if (spent := time.process_time() - begin) > SLOW + A_POSE * poses:
        raise TimeoutError(f"{spent:.1f} s for {len(data)} bytes")


def mutate(data: bytes, most: int, seed: int) -> bytes:
    """Half of the time lines are moved, else libFuzzer changes bytes."""
    dice = random.Random(seed)
    lines = data.split(b"\n")
    if dice.random() < 0.5 or len(lines) < 3:
        return atheris.Mutate(data, most)
    a, b = sorted(dice.sample(range(len(lines)), 2))
    how = dice.randrange(4)
    if how == 0:
        lines[a], lines[b] = lines[b], lines[a]
    elif how == 1:
        del lines[a : min(b, a + 3)]
    elif how == 2:
        lines[b:b] = lines[a : min(b, a + 5)]
    else:
        lines[a] = lines[a][: dice.randint(0, len(lines[a]))] + lines[b][dice.randint(0, len(lines[b])) :]
    return b"\n".join(lines)[:most]


def fuzz(
    language: str,
    runs: int,
    seed: int,
    corpus: Path,
    *,
    make: Callable[[str, Path], Callable[[bytes], Toolpath]] = reader,
    longest: int = LONGEST,
) -> None:
    """Run the fuzzer on inputs of at most ``longest`` bytes; it ends the process."""
    folder = Path(tempfile.mkdtemp(prefix="fuzz-"))
    grown = corpus / language
    grown.mkdir(parents=True, exist_ok=True)
    for k, data in enumerate(seeds(language)):
        (grown / f"seed{k}").write_bytes(data[:longest])
    table = folder / "words"
    table.write_text("".join('"' + "".join(f"\\x{b:02x}" for b in w) + '"\n' for w in words(language)))
    read = make(language, folder)
    one_input(read, seeds(language)[0])  # what is imported late is not the input's time
    flags = [
        f"-runs={runs}", f"-seed={seed}", f"-dict={table}", f"-max_len={longest}", f"-rss_limit_mb={MEMORY}",
        f"-timeout={HANG}", f"-report_slow_units={HANG}", f"-artifact_prefix={corpus / language}-",
        "-print_final_stats=1",
    ]  # fmt: skip
    atheris.Setup([sys.argv[0], *flags, str(grown)], lambda data: one_input(read, data), custom_mutator=mutate)
    atheris.Fuzz()


def main(arguments: Sequence[str] | None = None) -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description="Fuzz a reader.")
    parser.add_argument("--language", choices=sorted(READ), required=True)
    parser.add_argument("--runs", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--longest", type=int, default=LONGEST, help="bytes of an input; shorter ones are read faster")
    parser.add_argument("--corpus", type=Path, help="folder that keeps the inputs found; else a temporary one")
    parser.add_argument("--input", type=Path, help="run this one file instead")
    given = parser.parse_args(arguments)
    if given.input:
        one_input(reader(given.language, Path(tempfile.mkdtemp(prefix="fuzz-"))), given.input.read_bytes())
        return
    corpus = given.corpus or Path(tempfile.mkdtemp(prefix="fuzz-corpus-"))
    fuzz(given.language, given.runs, given.seed, corpus, longest=given.longest)


if __name__ == "__main__":
    main()
