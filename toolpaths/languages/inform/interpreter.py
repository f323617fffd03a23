"""Executes an INFORM job as far as everything is constant, and collects the moves.

What only the controller knows (variables, pulses, jumps) is refused by line where a cut depends on it. Sources: Yaskawa
DX200 and YRC1000 INFORM Language; DX100 operator's manual, circular interpolation.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from toolpaths.interpreting.program_text import LinkedText
from toolpaths.interpreting.robot_moves import ARC, LINE, NOWHERE, PTP
from toolpaths.interpreting.robot_track import RobotTrack
from toolpaths.interpreting.vocabulary import HONOURED, REFUSED
from toolpaths.languages.inform.scan import InformJob, JobLine, JobPosition
from toolpaths.languages.inform.words import QUIET, SWALLOWING, TEXTS, WORDS
from toolpaths.reading.source_text import comment_word, load_lines
from toolpaths.rotation import matrix_from_motoman, quaternion_from_matrix
from toolpaths.toolpath import CUT, RAPID, Floats

_WORD = re.compile(r"[-+]?[A-Z_]+\d?|'|\*|//")
_MOVE = re.compile(r"(MOV[JLC])((?:\s+[A-Z]{1,3}\d+)+)((?:\s+\S+)*)")
_V = re.compile(r"(V|VJ|VR|VE)=(\d+(?:\.\d*)?)")
_LEVEL = re.compile(r"PL=([0-8])")
_RADIUS = re.compile(r"CR=(\d+(?:\.\d*)?)")
_IDLE = re.compile(r"(?:ACC|DEC)=\d+|NWAIT|FPT")
_CALL = re.compile(r"CALL\s+JOB:(\S+?)(\s+(?:IF|ARGF).*)?")
_NAN = float("nan")
_BASE: Floats = np.eye(4)
FASTEST = 1500.0  # mm/s: what V takes
MOST_DEEP = 10  # calls within each other, as the controller has it


def _quaternions(numbers: Floats) -> Floats:
    """Of Rx, Ry, Rz in deg (N, 4), the last unused."""
    return quaternion_from_matrix(matrix_from_motoman(np.radians(numbers[:, :3])))


class JobInterpreter:
    """Execution of a job and of those that it calls and that lie beside it.

    Args:
        job: that is run.
        path: of its file; others are looked for beside it.
    """

    def __init__(self, job: InformJob, path: Path) -> None:
        self.path, self.text = path, LinkedText(job)
        self.track = RobotTrack(job.source, "inform", _quaternions, text=self.text)
        self.jobs: dict[str, int] = {job.name: 0}
        self.absent: set[str] = set()
        self.feed = _NAN  # of SPEED V, mm/s
        self.lost = ""  # what moved the arm to where only the controller knows
        self.arc: list[tuple[JobLine, JobPosition]] = []  # MOVC that no arc has been made of
        self.turned = False  # the last of them ended an arc
        self.left = 0

    def run(self) -> None:
        """Every instruction."""
        self.left = 10_000 + 20 * len(self._job(0).lines)
        self._run(0, 0)

    def _job(self, number: int) -> InformJob:
        job = self.text.parts[number]
        if not isinstance(job, InformJob):
            raise TypeError(f"{job!r} is no job")
        return job

    def _run(self, number: int, depth: int) -> None:
        job = self._job(number)
        for line in job.lines:
            self.left -= 1
            if self.left < 0:
                job.refuse(line.start, "jobs call each other more often than they are long", "Unroll the calls.")
            found = _WORD.match(line.text)
            word = found[0] if found else ""
            if word not in ("MOVC", "'") and self.arc:
                self._close(job)
            if line.text[:2] == "//":
                word = "//"
            done = WORDS.get(word, "")
            if word == "RET" and line.text == "RET":
                break
            if word.startswith("MOV") and done == HONOURED:
                self._move(number, line)
            elif word == "CALL":
                self._call(number, line, depth)
            elif word == "SPEED":
                self._speed(job, line)
            elif done in ("", REFUSED, HONOURED):
                why = "what it does is known only while the job runs" if done else "this reader does not know it"
                remedy = "Jumps, conditions, shifts and splines cannot be compensated: write the moves out."
                job.refuse(line.start, f"{line.text[:40]!r}: {why}", remedy)
            else:
                if word not in TEXTS and (problem := SWALLOWING.problem(line.text, len(line.text.split()[0]))):
                    job.refuse(line.start, problem, SWALLOWING.remedy)
                self._event(number, line, "" if word in QUIET else line.text)
        self._close(job)

    def _event(self, number: int, line: JobLine, instruction: str = "") -> None:
        job = self._job(number)
        self.track.event(comment_word(line.text.lstrip("'")), job.line(line.start), instruction, number)

    def _speed(self, job: InformJob, line: JobLine) -> None:
        """SPEED VJ=... V=...: for the moves behind it that give none."""
        for word in line.text.split()[1:]:
            m = _V.fullmatch(word)
            if m is None:
                job.refuse(line.start, f"{line.text[:40]!r}: a speed that is no number", "Give it as V=12.5.")
            value = self._speed_of(job, line, m)
            self.feed = value if m[1] == "V" else self.feed

    def _speed_of(self, job: InformJob, line: JobLine, given: re.Match[str]) -> float:
        value = float(given[2])
        if not 0.0 < value <= (FASTEST if given[1] == "V" else 1e6):
            remedy = f"V takes 0.1 to {FASTEST:g} mm/s; where the controller counts cm/min, set it to mm/s."
            job.refuse(line.start, f"{line.text[:40]!r}: a speed of {given[2][:20]}", remedy)
        return value

    def _call(self, number: int, line: JobLine, depth: int) -> None:
        job = self._job(number)
        m = _CALL.fullmatch(line.text)
        if m is None or m[2]:
            why = "a call that a condition or an argument decides about" if m else "only CALL JOB:NAME is read"
            job.refuse(line.start, f"{line.text[:40]!r}: {why}", "Write the call without it.")
        self._event(number, line, line.text)
        called = self._called(m[1].upper())
        if called is None:
            return  # as the jobs of a gripper or a spindle: only the controller has them
        if depth >= MOST_DEEP:
            job.refuse(line.start, f"{line.text[:40]!r}: more than {MOST_DEEP} jobs within each other")
        self._run(called, depth + 1)

    def _called(self, name: str) -> int | None:
        if name in self.jobs or name in self.absent:
            return self.jobs.get(name)
        beside = [p for p in sorted(self.path.parent.glob("*")) if p.suffix.lower() == self.path.suffix.lower()]
        file = next((p for p in beside if p.stem.upper() == name), None)
        if file is None:
            self.absent.add(name)
            return None
        source = str(file)
        load_lines(file, source)
        self.jobs[name] = len(self.text.parts)
        self.text.add(InformJob(file.read_bytes().decode("latin-1"), source))
        self.left += 20 * len(self._job(self.jobs[name]).lines)
        return self.jobs[name]

    def _move(self, number: int, line: JobLine) -> None:
        job, m = self._job(number), _MOVE.fullmatch(line.text)
        if m is None:
            remedy = "Expected: MOVJ, MOVL or MOVC, a position of the job such as C00001, a speed, PL."
            job.refuse(line.start, f"{line.text[:60]!r} is not read", remedy)
        word, names = m[1], m[2].split()
        position = self._position(job, line, names)
        if position is None:
            if word != "MOVJ":
                what = f"{names[0]} is in pulses" if names[0] in job.positions else f"{names[0]} is a position variable"
                remedy = "Save it as a relative job (RECTAN): pulses and variables are known to the controller alone."
                job.refuse(line.start, f"{line.text[:40]!r}: {what}", remedy)
            self._event(number, line, line.text)
            self.lost = f"{line.text[:40]!r} (line {job.line(line.start)})"
            return
        feed, zone = self._options(job, line, m[3].split())
        if word == "MOVC":
            self._circular(number, line, position, feed=feed, zone=zone)
            return
        self._append(number, line, word=PTP if word == "MOVJ" else LINE, to=position, feed=feed, zone=zone)

    def _position(self, job: InformJob, line: JobLine, names: list[str]) -> JobPosition | None:
        """Where a move leads; None: only the controller knows."""
        for name in names[1:]:
            other = job.positions.get(name)
            if other is None or name[0] not in "BE" or any(other.numbers):
                remedy = "Post the job without external axes."
                job.refuse(line.start, f"{name}: an external axis, in pulses of its controller", remedy)
        position = job.positions.get(names[0])
        if position is None and names[0].startswith("C"):
            job.refuse(line.start, f"{names[0]} is not in the job", "The file may be cut off: save the job again.")
        return None if position is None or position.kind == "PULSE" else position

    def _options(self, job: InformJob, line: JobLine, words: list[str]) -> tuple[float, float]:
        """Speed, mm/s, and corner, mm; NaN where they are not given."""
        feed = zone = _NAN
        for word in words:
            if m := _V.fullmatch(word):
                value = self._speed_of(job, line, m)
                feed = value if m[1] == "V" else feed
            elif m := _LEVEL.fullmatch(word):
                zone = 0.0 if m[1] == "0" else zone
            elif m := _RADIUS.fullmatch(word):
                zone = float(m[1])
            elif not _IDLE.fullmatch(word):
                remedy = "Read are V, VJ, VR, PL, CR, ACC, DEC, NWAIT, FPT with numbers."
                job.refuse(line.start, f"{line.text[:40]!r}: {word[:20]!r} is not read", remedy)
        return (feed if feed == feed else self.feed), zone

    def _circular(self, number: int, line: JobLine, to: JobPosition, *, feed: float, zone: float) -> None:
        """Three MOVC are an arc: a line to the first, then through the second to the third.

        FPT ends an arc where the next one begins.
        """
        if not self.arc:
            self._append(number, line, word=LINE, to=to, feed=feed, zone=zone)
        self.arc.append((line, to))
        if len(self.arc) == 3:
            via = self.arc[1][1]
            if (via.kind, via.user) != (to.kind, to.user):
                self._job(number).refuse(line.start, "an arc through points of two frames", "Give them in one.")
            self._append(number, line, word=ARC, to=to, feed=feed, zone=zone, via=via)
            self.arc = [(line, to)] if "FPT" in line.text.split() else []
            self.turned = True
            return
        self.turned = False

    def _close(self, job: InformJob) -> None:
        if self.arc and not (self.turned and len(self.arc) == 1):
            problem = f"{len(self.arc)} MOVC that make no arc of three points"
            job.refuse(self.arc[-1][0].start, problem, "Give three for each arc, with a MOVL or FPT between arcs.")
        self.arc, self.turned = [], False

    def _append(
        self, number: int, line: JobLine, *, word: int, to: JobPosition, feed: float, zone: float,
        via: JobPosition | None = None,
    ) -> None:  # fmt: skip
        job = self._job(number)
        if word != PTP and self.lost and self.track.count:
            remedy = "Put a MOVJ to a position in mm in front of it."
            job.refuse(line.start, f"this move starts where {self.lost} leads", remedy)
        self.lost = ""
        frame = self.track.frame(_BASE) if to.kind != "USER" else self.track.frame(None, f"USER {to.user}")
        through = (_NAN,) * 3 if via is None else via.numbers[:3]
        kind, start = RAPID if word == PTP else CUT, self.text.begins[number]
        self.track.move(
            (*to.numbers, 0.0, feed if word != PTP else _NAN, zone, *through),
            (
                word, int(kind), to.tool, job.line(line.start), frame, to.bits, start + line.start, start + line.end,
                *NOWHERE, *NOWHERE,
            ),
        )  # fmt: skip
