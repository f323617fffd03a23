"""Results of Fusion 360, PowerInspect and Haas probing: G800 (nominal, normal, limits) and G801 (ball centre, radius).

As the posts of Autodesk write them: the centre of the ball stands at nominal + normal * radius on a perfect part.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from compensator.devices.numbers import number
from compensator.devices.readings import SURFACE, DeviceFile, DeviceReadings, readings
from compensator.errors import DeviceError
from toolpaths.finding import NOTE, WARNING, Finding

NAME = "probe-results"
_WORD = re.compile(r"([A-Z])\s*([^\sA-Z]*)")
_MARK = re.compile(r"^\s*G80[01]\s+N", re.MULTILINE)
_HEADERS = ("RESULTSFILE", "DOCUMENTID", "MODELVERSION", "TOOLPATHID", "TOOLPATH", "DPRNT", "%")
UNTURNED = 1e-4  # deg and units of length: as a work plane that is that of the setup is written


class _Touch(NamedTuple):
    line: int
    name: str
    group: str
    plane: tuple[float, ...]
    nominal: Mapping[str, float]
    measured: Mapping[str, float]


@dataclass(frozen=True)
class _Set:
    """What stands between a START and its END, as far as it was read."""

    line: int
    touches: list[_Touch] = field(default_factory=list)
    missed: list[int] = field(default_factory=list)


def recognised(file: DeviceFile) -> bool:
    """By its blocks."""
    return bool(_MARK.search(file.text))


def read(file: DeviceFile) -> DeviceReadings:
    """The touches of the last set of a file.

    Raises:
        DeviceError: no touch; a G801 without its G800; a word that is missing or no number; work planes that differ.
    """
    sets, others = _sets(file)
    if not sets or not sets[-1].touches:
        where = f"line {sets[-1].line}: the last START has no touch after it" if sets else "there is no touch in it"
        raise DeviceError(f"{file.label}: {where}: expected pairs of G800 and G801; let the inspection run to its END")
    last = sets[-1]
    touches = last.touches
    place = np.array([[t.nominal[k] for k in "XYZ"] for t in touches])
    normal = np.array([[t.nominal[k] for k in "IJK"] for t in touches])
    centre = np.array([[t.measured[k] for k in "XYZ"] for t in touches])
    radius, offset = (np.array([t.measured["R"] for t in touches]), np.array([t.nominal["O"] for t in touches]))
    length = np.maximum(np.linalg.norm(normal, axis=1), 1e-12)
    unit = normal / length[:, None]
    return readings(
        file,
        NAME,
        kind=SURFACE,
        line=[t.line for t in touches],
        to_mm=None,  # inch or mm by the machine, and the file does not tell
        name=[t.name for t in touches],
        group=["" for _ in touches],
        numbers={
            "nominal": place,
            "measured": centre - radius[:, None] * unit,
            "normal": normal,
            "deviation": np.einsum("nk,nk->n", centre - place, unit) - radius - offset,
            "low": [-abs(t.nominal["L"]) for t in touches],
            "high": [abs(t.nominal["U"]) for t in touches],
        },
        needs_free_frame=_turned(file, touches),
        findings=(*_findings(file, sets, others), *_offsets(file, touches)),
    )


def _sets(file: DeviceFile) -> tuple[list[_Set], list[int]]:
    """The sets of a file, and lines of blocks that are not used."""
    sets: list[_Set] = []
    others: list[int] = []
    group = ""
    plane: tuple[float, ...] = (0.0,) * 6
    open_: tuple[int, dict[str, float]] | None = None
    for at, text in enumerate(file.lines, 1):
        words = text.strip().upper()
        if words == "START" or (not sets and words.startswith("G800")):
            sets.append(_Set(at))
            open_ = None
        if words.startswith("TOOLPATH "):
            group = text.strip()[len("TOOLPATH ") :]
        if words in ("", "START") or words.startswith(_HEADERS) or words.startswith((";", "(")):
            continue
        if words.startswith("G330"):
            plane = tuple(_block(file, at, words, needed="ABCXYZ").values())
        elif words.startswith(("G800", "END")):
            if open_ is not None:
                sets[-1].missed.append(open_[0])
            open_ = None if words.startswith("END") else (at, _nominal(file, at, words))
        elif words.startswith("G801"):
            measured = _block(file, at, words, needed="NXYZR")
            if open_ is None or open_[1]["N"] != measured["N"]:
                why = f"G801 N{measured['N']:g} without its G800 before it"
                raise DeviceError(f"{file.label}: line {at}: {why}: lines are missing; transfer the file again")
            name = f"N{measured['N']:g}" + (f" {group}" if group else "")
            touch = _Touch(
                line=open_[0], name=name, group=group, plane=plane, nominal=open_[1], measured=measured
            )
            sets[-1].touches.append(touch)
            open_ = None
        elif not words.startswith("G331"):  # where the model stands: nothing of the points
            others.append(at)
    if open_ is not None:
        sets[-1].missed.append(open_[0])
    return sets, others


def _nominal(file: DeviceFile, at: int, words: str) -> dict[str, float]:
    return _block(file, at, words, needed="NXYZIJK", more={"O": 0.0, "U": np.nan, "L": np.nan})


def _block(
    file: DeviceFile, at: int, words: str, *, needed: str, more: Mapping[str, float] | None = None
) -> dict[str, float]:
    """Letters of a block with their numbers."""
    given = dict(_WORD.findall(words)[1:])
    if missing := [letter for letter in needed if letter not in given]:
        why = f"{words[:60]!r} lacks {', '.join(missing)}"
        raise DeviceError(f"{file.label}: line {at}: {why}: expected {', '.join(needed)}; the line may be cut off")
    letters = (*needed, *(letter for letter in more or {} if letter in given))
    read_ = {letter: number(given[letter], file.label, at, f"{letter} of {words[:4]}") for letter in letters}
    return {**(more or {}), **read_}


def _turned(file: DeviceFile, touches: Sequence[_Touch]) -> str:
    """Why the points do not stand in the frame of the setup, if they do not."""
    first = touches[0]
    for t in touches:
        if np.max(np.abs(np.subtract(t.plane, first.plane))) > UNTURNED:
            raise DeviceError(
                f"{file.label}: line {t.line}: G330 {t.plane}, but {first.plane} at line {first.line}: points of "
                "several work planes stand in several frames; make a file of each"
            )
    if np.max(np.abs(first.plane)) > UNTURNED:
        return f"G330 {', '.join(f'{v:g}' for v in first.plane)}: the points stand in a work plane that is turned"
    return ""


def _findings(file: DeviceFile, sets: Sequence[_Set], others: Sequence[int]) -> Iterator[Finding]:
    if len(sets) > 1:
        lost = sum(len(s.touches) for s in sets[:-1])
        where = ", ".join(str(s.line) for s in sets[:-1])
        kept = f"{len(sets)} sets: the last counts (START at line {sets[-1].line})"
        what = f"{kept}; {lost} points of those at line {where} do not"
        yield Finding(WARNING, file.label, what)
    if sets[-1].missed:
        what = "G800 without a G801: the point was not touched, it is left out"
        yield Finding(WARNING, f"{file.label}:{sets[-1].missed[0]}", what, count=len(sets[-1].missed))
    if others:
        what = "blocks that are neither G330, G331, G800 nor G801 are not used"
        yield Finding(NOTE, f"{file.label}:{others[0]}", what, count=len(others))


def _offsets(file: DeviceFile, touches: Sequence[_Touch]) -> Iterator[Finding]:
    stock = [t for t in touches if t.nominal["O"]]
    if stock:
        what = "O: the surface was offset along the normal, deviations are from the offset surface"
        yield Finding(NOTE, f"{file.label}:{stock[0].line}", what, count=len(stock))
