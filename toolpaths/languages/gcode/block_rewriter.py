"""BlockRewriter: the blocks of a G-code file written again, with other coordinates where the program has others."""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from toolpaths.errors import WriteError
from toolpaths.finding import NOTE, WARNING, Finding
from toolpaths.languages.gcode.codes import ARCS, CYCLES, G
from toolpaths.languages.gcode.filter_checks import refuse_moved
from toolpaths.languages.gcode.motion import MovedBlock
from toolpaths.languages.gcode.reader import INCH, MM, BlockReader
from toolpaths.languages.gcode.spelling import GcodeSpelling, GcodeWord, spelling_of, with_words, words_of
from toolpaths.languages.gcode.tool_place import TILT, UP, ToolPlace
from toolpaths.rewriting.filter import SAME_PLACE
from toolpaths.toolpath import CUT
from toolpaths.writing.program import Floats, Program

SHIFT = re.compile(r"G0*92(?!\.?[123])", re.I)
ARC_TOLERANCE = 1e-6  # m: poses nearer than this to an arc are on it
COARSEST = 1.0  # rad between two poses of an arc that becomes lines
UNITS: dict[int, float] = {G.INCH: INCH, G.MM: MM}
STOPS = (0, 1, 2, 30)  # M words that end or halt the block they stand in


class LineTarget(NamedTuple):
    """Where a line leads: m in the work object, with a tool vector where the file has some."""

    cut: bool
    place: Sequence[float]
    axis: Floats | None


def _shifts(text: str) -> bool:
    """Whether there is a G92 in the line."""
    return any(w.letter == "G" and w.key == G.SHIFT for w in words_of(text))


class BlockRewriter:
    """Goes through the blocks that move, and knows where the rewritten file has the tool."""

    def __init__(self, texts: Sequence[str], program: Program, row: Floats, path: Path, blocks: BlockReader) -> None:
        self.texts, self.program, self.path = texts, program, path
        self._rotation = np.asarray(program.rotation)
        self.steps: list[MovedBlock] = blocks.state.trace or []
        self.spelling: GcodeSpelling = spelling_of(texts)
        self.row = row
        self.moves = np.frombuffer(blocks.track.moves, dtype=np.float64).reshape(-1, 7)
        track = blocks.track
        arcs = np.frombuffer(track.arcs, dtype=np.float64).reshape(-1, 7)
        self.arcs = dict(zip(track.arc_moves, arcs, strict=True))
        move = np.ceil(row - 1e-9)
        if len(row) == 0 or (np.diff(row) < 0).any() or move[0] < 0 or move[-1] >= len(self.moves):
            raise WriteError(f"{path}: the poses do not belong to this file ({len(self.moves)} moves)")
        refuse_moved(program, row, self.moves[:, :3], path)
        self.first = np.searchsorted(move, np.arange(len(self.moves) + 1))
        self.place = ToolPlace(self.spelling)  # where the rewritten file is
        self.place.go(blocks.start)
        self.nominal: Sequence[float] = self.place.at  # where the file is
        self.position: list[list[float]] = program.position.tolist()
        self.cut: list[bool] = (program.kind == CUT).tolist()
        absolute = (k for k, t in enumerate(texts) if "90.1" in t)
        self.absolute_from = next(absolute, len(texts)) + 1
        self.shifts = [k for k, t in enumerate(texts) if SHIFT.search(t) and _shifts(t)]
        self.mode: G | None = None
        self.expanding = False
        self.dwell = ""  # P of the cycle in force
        self.lines: list[str] = []
        self.changes: list[Finding] = []

    def run(self) -> dict[int, list[str]]:
        """Line number -> the lines that stand there now, for lines that differ."""
        changed: dict[int, list[str]] = {}
        before = 0
        for k, step in enumerate(self.steps):
            self._name_places(before, step, changed)
            before = step.line
            if step.motion not in CYCLES or not (k and self.steps[k - 1].motion in CYCLES):
                self.expanding = step.motion in CYCLES and self._series_differs(k)
            self.lines = []
            text = self.texts[step.line - 1]
            words = words_of(text)
            self._step(step, text, words)
            if self.lines != [text]:
                changed[step.line] = self.lines
            self.nominal = step.end
        self._check_tilt()
        return changed

    def _name_places(self, before: int, step: MovedBlock, changed: dict[int, list[str]]) -> None:
        """A G92 names the place where the tool is: the corrected one, so that the origin stays where it was."""
        for k in self.shifts[bisect_left(self.shifts, before) : bisect_left(self.shifts, step.line)]:
            words = words_of(self.texts[k])
            new = self.place.named(words, self.nominal, step.shift, self._unit_at(k))
            if new:
                changed[k + 1] = [with_words(self.texts[k], self.spelling, new, words=words)]
                what = "G92 names the corrected place, so that the origin stays"
                self.changes.append(Finding(NOTE, f"{self.path}:{k + 1}", what))

    def _unit_at(self, line: int) -> float:
        """G20 or G21 in force in a line."""
        keys = ([w.key for w in words_of(t) if w.letter == "G"] for t in reversed(self.texts[: line + 1]) if "2" in t)
        return next((UNITS[key] for found in keys for key in found if key in UNITS), MM)

    # --- one block --------------------------------------------------------------------------------------------

    def _step(self, step: MovedBlock, text: str, words: list[GcodeWord]) -> None:
        if step.motion in CYCLES:
            self.dwell = next((w.number for w in words if w.letter == "P"), self.dwell)
        drilling = step.motion in CYCLES
        if step.motion is G.RAPID or step.last == step.first or (drilling and not self.expanding):
            self._keep(step, text, words)
        elif drilling:
            self._changed(step, "a drilling cycle became single moves")
            self._moves(step, text, words, self._drilled(step), drop="RQPLKIJG")
        else:
            self._cut(step, text, words, self._poses(step.first))

    def _cut(self, step: MovedBlock, text: str, words: list[GcodeWord], poses: list[int]) -> None:
        """A line or an arc."""
        if not poses or round(self.row[poses[-1]], 9) != step.first:
            raise WriteError(f"{self.path}:{step.line}: the program has no pose for the end of this cutting move")
        targets = [LineTarget(True, self.position[p], self._axis(step, p)) for p in poses]
        if step.motion in ARCS and self._still_arc(step, poses):
            self._one(step, text, words, targets[-1]._replace(axis=None))
        elif step.motion in ARCS:
            self._check_arc(step, poses)
            self._changed(step, "an arc became lines")
            self._moves(step, text, words, targets, drop="IJKRP")
        elif len(poses) == 1:
            self._one(step, text, words, targets[0])
        else:
            self._changed(step, "poses were put in as lines", len(poses) - 1)
            self._moves(step, text, words, targets, drop="")

    def _poses(self, move: int) -> list[int]:
        """The poses of a cutting move."""
        return [p for p in range(int(self.first[move]), int(self.first[move + 1])) if self.cut[p]]

    def _drilled(self, step: MovedBlock) -> list[LineTarget]:
        """The moves of a drilling cycle: cuts as commanded, rapids as they were."""
        out = []
        for move in range(step.first, step.last):
            cuts = [LineTarget(True, self.position[p], None) for p in self._poses(move)]
            out += cuts or [LineTarget(False, self.moves[move, :3].tolist(), None)]
        return out

    def _axis(self, step: MovedBlock, pose: int) -> Floats | None:
        return -self._rotation[pose, :, 2] if step.vectors else None

    def _keep(self, step: MovedBlock, text: str, words: list[GcodeWord]) -> None:
        """The line as it is, with its motion word where the lines before took that away."""
        if step.motion not in CYCLES and not self._has_motion(words) and self.mode not in (None, step.motion):
            text = with_words(text, self.spelling, {}, motion=str(step.motion // 10))
        self.lines.append(text)
        self.mode = step.motion
        if step.motion not in CYCLES:
            self.place.go(self.place.after(step, words))
        else:
            pairs = zip(step.end, self.nominal, self.place.at, strict=True)
            self.place.go([at if end == before else end for end, before, at in pairs])
        if step.vectors and step.motion in (G.RAPID, G.LINE):
            self.place.turn(words)

    def _one(self, step: MovedBlock, text: str, words: list[GcodeWord], to: LineTarget) -> None:
        """The line with other coordinates; those that lead to the same place stay."""
        new = self.place.coordinates(step, self.place.after(step, words), to.place)
        if to.axis is not None:
            new.update(self.place.tool_vector(to.axis, words))
        motion = "" if self._has_motion(words) or self.mode in (None, step.motion) else str(step.motion // 10)
        if new or motion:
            text = with_words(text, self.spelling, new, motion=motion, words=words)
        self.lines.append(text)
        self.mode = step.motion
        self.place.go(self.place.after(step, words, new))

    def _moves(self, step: MovedBlock, text: str, words: list[GcodeWord], targets: list[LineTarget], drop: str) -> None:
        """A line for each pose; what else stands in the block goes with the first of them."""
        feeds = self._feeds(step, words, targets)
        own = len(targets) - 1 if any(w.letter == "M" and w.value in STOPS for w in words) else 0
        written = next((w.key for w in words if w.is_motion), None)
        for k, (to, feed) in enumerate(zip(targets, feeds, strict=True)):
            motion = G.LINE if to.cut else G.RAPID
            new = self.place.coordinates(step, self.place.at, to.place, at_least_one=True)
            if to.axis is not None:
                new.update(self.place.tool_vector(to.axis, []))
            if feed:
                new["F"] = feed
            if k == own:
                word = str(motion // 10) if motion != (self.mode if written is None else written) else ""
                line = with_words(text, self.spelling, new, drop=set(drop + "XYZ") - set(new), motion=word)
            else:
                line = self._line(new, str(motion // 10) if motion != self.mode else "")
            self.lines.append(line)
            self.mode = motion
            self.place.go(self.place.after(step, words_of(line)))
            if step.motion is G.DRILLING_WITH_DWELL and to.cut and self.dwell:
                dwell = [self.spelling.word("G", "4"), self.spelling.word("P", self.dwell)]
                self.lines.append(self.spelling.gap.join(dwell))

    def _line(self, new: dict[str, str], motion: str) -> str:
        words = [self.spelling.word("G", motion)] if motion else []
        words += [self.spelling.word(c, new[c]) for c in "XYZIJKF" if c in new]
        return self.spelling.gap.join(words)

    def _feeds(self, step: MovedBlock, words: list[GcodeWord], targets: list[LineTarget]) -> list[str]:
        """F of each line under G93, where it is the inverse of the line's time; else none."""
        if not step.inverse:
            return [""] * len(targets)
        whole = next(w.value for w in words if w.letter == "F")
        places = np.array([self.place.at, *(to.place for to in targets)])
        part = np.maximum(np.linalg.norm(np.diff(places, axis=0), axis=1), 1e-9)
        return [f"{whole * part.sum() / p:.6g}" if p < part.sum() else f"{whole:.6g}" for p in part.tolist()]

    # --- arcs and cycles --------------------------------------------------------------------------------------

    def _still_arc(self, step: MovedBlock, poses: list[int]) -> bool:
        """Whether all poses lie on the arc of the file, moved as its start was moved."""
        arc = self.arcs[step.first]
        moved = np.subtract(self.place.at, self.nominal)
        if np.isnan(moved).any() or (np.abs(moved).max() > ARC_TOLERANCE and self._centre_is_a_place(step)):
            return False
        out = self.program.position[poses] - arc[:3] - moved
        share = self.row[poses] - (step.first - 1)
        rise, radius = np.subtract(step.end, self.nominal), np.linalg.norm(np.subtract(self.nominal, arc[:3]))
        normal = arc[3:6]
        height = out @ normal
        flat = np.linalg.norm(out - height[:, None] * normal, axis=1)
        stretch = np.linalg.norm((np.array(step.end) - arc[:3]) - (rise @ normal) * normal) - radius
        off = np.maximum(np.abs(height - share * (rise @ normal)), np.abs(flat - radius - share * stretch))
        at_end = np.abs(self.program.position[poses[-1]] - np.array(step.end) - moved).max()
        return bool(max(off.max(), at_end) <= ARC_TOLERANCE)

    def _centre_is_a_place(self, step: MovedBlock) -> bool:
        """Conservative: with G90.1 the centre words would have to change as well."""
        return step.line >= self.absolute_from

    def _check_arc(self, step: MovedBlock, poses: list[int]) -> None:
        widest = abs(self.arcs[step.first][6]) * np.diff(self.row[poses], prepend=step.first - 1.0).max()
        if widest > COARSEST:
            raise WriteError(
                f"{self.path}:{step.line}: the arc has to become lines, but the program has only {len(poses)} poses "
                "of it. Sample it more finely"
            )

    def _series_differs(self, k: int) -> bool:
        """Whether any hole of the series of cycles that begins here is to be elsewhere."""
        for step in self.steps[k:]:
            if step.motion not in CYCLES:
                return False
            for move in range(step.first, step.last):
                for p in self._poses(move):
                    if np.abs(self.program.position[p] - self.moves[move, :3]).max() > SAME_PLACE:
                        return True
        return False

    @staticmethod
    def _has_motion(words: list[GcodeWord]) -> bool:
        return any(w.is_motion for w in words)

    # --- findings ---------------------------------------------------------------------------------------------

    def _changed(self, step: MovedBlock, what: str, count: int = 1) -> None:
        self.changes.append(Finding(level=NOTE, place=f"{self.path}:{step.line}", what=what, remedy="", count=count))

    def _check_tilt(self) -> None:
        """Without G43.4 a file has no words for the tilt of a corrected tool."""
        flat = [s for s in self.steps if not s.vectors and s.last > s.first]
        rows = [p for s in flat for p in range(self.first[s.first], self.first[s.last]) if self.cut[p]]
        if not rows:
            return
        tilt = np.linalg.norm(np.cross(-self._rotation[rows][:, :, 2], UP), axis=1)
        worst = int(np.argmax(tilt))
        if tilt[worst] > TILT:
            place = f"{self.path}:{int(self.program.line[rows[worst]])}"
            what = f"the correction tilts the tool by up to {np.degrees(tilt[worst]):.2g} deg, which a file without "
            remedy = "write a program in the robot's language to have the tilt corrected, too"
            self.changes.append(Finding(WARNING, place, what + "tool vectors cannot say: it is left out", remedy))
