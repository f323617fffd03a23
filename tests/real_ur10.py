"""The tables of docs/real-ur10.md: `python -m tests.real_ur10 ../shared/data/ur10`, eight fits of minutes, and what
the default commands make of the same files: `python -m tests.real_ur10 ../shared/data/ur10 --commands`.

Folds are whole regions of the workspace: what a table says of angles that no reading of the fit has seen is scored too.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from subprocess import DEVNULL
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.cluster.vq import kmeans2

from stiffness.diagnosis.added_effects import Addition, ModelFits
from stiffness.diagnosis.refined_model import refined_model
from stiffness.effects import BY_NAME
from stiffness.identification.evaluate import evaluate
from stiffness.identification.fit import Fit
from stiffness.identify import identify
from stiffness.model.model import ComplianceModel
from stiffness.session.session import Session, load_session

Bools = npt.NDArray[np.bool_]
EFFECT = BY_NAME["joint-angle-error"]
REGIONS, FOLDS = 30, 5
ORDER = ("A", "B")


def regions(session: Session) -> npt.NDArray[np.intp]:
    """(N,) which of the regions (k-means of the probe's position) the set-up of a reading lies in; -1: no position."""
    samples = session.samples
    setups, of = np.unique(samples.setup, return_inverse=True)
    seen = np.flatnonzero(session.counts)
    first = seen[np.unique(of[seen], return_index=True)[1]]
    _, label = kmeans2(samples.position[first], REGIONS, seed=1, minit="++")
    own = np.full(len(setups), -1)
    own[of[first]] = label
    return np.asarray(own[of])


class Study:
    """Sessions by name, the model without the effect, and the readings that its fit called wrong."""

    def __init__(self, folder: Path) -> None:
        self.sessions = {name: load_session(folder / name / "session.toml") for name in ORDER}
        fit = identify([self.sessions["B"]], ["joint-stiffness", "kinematic-offset"])
        self.model: ComplianceModel = fit.model(self.sessions["B"].robot_name, {})
        self.right = {name: np.ones(len(s.samples), dtype=bool) for name, s in self.sessions.items()}
        self.right["B"] = fit.sessions[0].used

    def fits(self, used: Mapping[str, Bools]) -> dict[str, Fit]:
        """Fits to some readings, without and with the effect."""
        n = self.sessions["B"].robot.n
        sessions = [self.sessions[k] for k in used]
        fits = ModelFits.of(sessions, self.model.effects, self.model.values, list(used.values()))
        without = fits.fit([])
        addition = Addition(EFFECT, EFFECT.sites(n), frozenset(EFFECT.sites(n)), EFFECT.neutral(n))
        return {"without": without, "with": fits.fit([addition], without)}

    def learned(self, names: Sequence[str]) -> Iterator[str]:
        """Learned on whole sessions, scored on each with `evaluate`: 3-D RMS, mm."""
        fit = self.fits({k: self.right[k] for k in names})["with"]
        model = refined_model(self.model, fit, fit, [])
        for name, session in self.sessions.items():
            scores = [evaluate(session, m).absolute for m in (self.model, model)]
            errors = [float("nan") if s is None else s.rms * np.sqrt(3) * 1e3 for s in scores]
            yield f"| {' and '.join(names)} | {name}, placed by 25 states | {errors[0]:.3f} | {errors[1]:.3f} |"

    def folds(self) -> Iterator[str]:
        """Learned on A and B but a fifth of the regions, scored on those: 3-D RMS over all folds, mm."""
        region = {name: regions(s) for name, s in self.sessions.items()}
        squares: dict[tuple[str, str], list[npt.NDArray[np.float64]]] = {}
        for fold in range(FOLDS):
            out = {name: (r >= 0) & (r % FOLDS == fold) for name, r in region.items()}
            for kind, fit in self.fits({k: self.right[k] & ~out[k] for k in ORDER}).items():
                for i, name in enumerate(ORDER):
                    seen = fit.sessions[i].predicted
                    held = out[name] & self.right[name] & self.sessions[name].counts
                    off = self.sessions[name].samples.position[held] - seen.position[held]
                    squares.setdefault((name, kind), []).append((off**2).sum(axis=1))
        for name in ORDER:
            rms = [1e3 * np.sqrt(np.concatenate(squares[name, k]).mean()) for k in ("without", "with")]
            learned = f"A and B but a fifth of {REGIONS} regions, in turn"
            yield f"| {learned} | those of {name} | {rms[0]:.3f} | {rms[1]:.3f} |"


def commands(folder: Path) -> Iterator[str]:
    """What `identify A B`, then `diagnose A B` with the model that it wrote, say in their JSON, and what they took."""
    files = [str(folder / name / "session.toml") for name in ORDER]
    with tempfile.TemporaryDirectory() as out:
        model, summary = str(Path(out) / "ur10.toml"), Path(out) / "summary.json"
        for verb in (["identify", *files, "-o", model], ["diagnose", *files, "--model", model]):
            program = "import sys; from compensator.cli import main; main(sys.argv[1:])"
            before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
            subprocess.run([sys.executable, "-c", program, *verb, "--json", str(summary)], check=True, stderr=DEVNULL)
            used = resource.getrusage(resource.RUSAGE_CHILDREN)
            yield f"$ compensator {verb[0]} A B"
            yield from _told(json.loads(summary.read_text(encoding="utf-8")))
            yield f"{used.ru_utime - before:.0f} s of processor time; largest so far {used.ru_maxrss / 1e6:.1f} GB\n"


def _told(summary: Mapping[str, Any]) -> Iterator[str]:
    """The lines of a summary that the page shows."""
    if "verdict" in summary:
        yield f"verdict: {summary['verdict']}"
    if "misfit" in summary:
        yield f"misfit: {summary['misfit']:.2f}"
    for a in summary.get("added", ()):
        yield f"added: {a['effect']} in {' '.join(a['where'])}"
    for name, rms in dict(summary.get("rms_mm") or {}).items():
        if isinstance(rms, dict) and "before" in rms:
            yield f"{name}, per axis, held out: {rms['before']:.4f} mm before, {rms['after']:.4f} after"
    yield from (f"note: {note}" for note in summary.get("notes", ()))
    yield f"wrong rows: {len(summary['outlier_rows'])}"


def main() -> None:
    """Print the rows as they come."""
    parser = argparse.ArgumentParser(prog="python -m tests.real_ur10")
    parser.add_argument("folder", type=Path, help="with A/session.toml and B/session.toml")
    parser.add_argument("--commands", action="store_true", help="what the default commands say")
    asked = parser.parse_args()
    if asked.commands:
        for text in commands(asked.folder):
            print(text, flush=True)
        return
    study = Study(asked.folder)
    print("| learned on | scored on | without, mm | with, mm |\n| --- | --- | ---: | ---: |", flush=True)
    for names in (("A",), ("B",), ("A", "B")):
        for line in study.learned(names):
            print(line, flush=True)
    for line in study.folds():
        print(line, flush=True)


if __name__ == "__main__":
    main()
