"""What the contract suites need to know about a language: a new one has a sample in tests/contracts/languages/NAME.py.

Every suite over the readers, writers, filters and pages runs over these samples, by the table of languages.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from toolpaths.machine import Machine


@dataclass(frozen=True, kw_only=True)
class ReadSample:
    """Files to read.

    Attributes:
        text: the same four poses in every language: a rapid at Z 5, two cuts at Z 0 and 600 mm/min, a rapid. The lines
            of the rapids have one 5 each, those of the cuts none.
        pieces: words of the language, for damage.
        rapid_feed: m/s of the rapids of ``text``, where the language gives them a speed.
        end_word: whether the language has a word for the end of a file.
        twice: what a file of two programs is told; empty: the language has no such file.
        printed: line and words that a 3D print of tests/contracts/test_refused_files.py is refused with.
        whole: a program of many kinds of statements, to be damaged; empty: ``text``.
        beside: suffix and text of the file that belongs to ``whole``.
        machine: what some of the damaged files were posted for.
        refused: file, the line that the refusal names (None: none), its words.
        mistakes: file that is no program, words of the refusal.
        spelled: file of two poses in another spelling, the second one in mm.
        huge: a small file of arcs of 900 m, and a chord (m) that makes too many poses of them.
    """

    text: str
    pieces: str
    rapid_feed: float = math.nan
    end_word: bool = True
    twice: str = "wo programs in one file"
    printed: dict[str, tuple[int, str]] = field(default_factory=dict)
    whole: str = ""
    beside: tuple[str, str] | None = None
    machine: Machine | None = None
    refused: tuple[tuple[str, int | None, str], ...] = ()
    mistakes: tuple[tuple[str | bytes, str], ...] = ()
    spelled: tuple[tuple[str, tuple[float, float, float]], ...] = ()
    huge: tuple[str, float] | None = None

    @property
    def fragments(self) -> list[str]:
        """The pieces, a line end, a long number."""
        return [*self.pieces.split(), "\n", "9" * 400]


@dataclass(frozen=True, kw_only=True)
class WrittenSample:
    """What writing keeps.

    Attributes:
        position: largest error that printing makes, m.
        rotation: of the entries of the rotation matrix.
        feed: share of the feed.
        frame: error of the entries of the work object's (4, 4), m; None: it is not in the file.
        turns: whether the turn about the tool is in the file.
        in_base: poses are written, and read, in the base of the robot.
        rapid_speed: whether rapids have a speed of their own.
        split: whether long programs become several files.
        files: of a program that is not split.
        start: poses that a reader finds in front of the program's: where it starts.
        stands_or_passes: whether a move stands at its end or the controller chooses its rounding.
        most_lines: of a file, where long programs are split.
        no_names: names that the controller has for no program; ``no_name`` is what they are told.
        longest: letters of the longest name, and of that of a program that is split; 0: any.
        fastest: speed above which a move is refused, as the refusal has it.
    """

    position: float = 0.51e-7
    rotation: float = 3e-7
    feed: float = 1e-5
    frame: float | None = None
    turns: bool = True
    in_base: bool = False
    rapid_speed: bool = False
    split: bool = True
    files: int = 1
    start: int = 1
    stands_or_passes: bool = False
    most_lines: int = 0
    no_names: tuple[str, ...] = ()
    no_name: str = ""
    longest: tuple[int, int] = (0, 0)
    fastest: str = ""


@dataclass(frozen=True, kw_only=True)
class FilterSample:
    """Finished programs to change in place.

    Attributes:
        source: a program with rapids and cuts, where several moves use one pose.
        beside: suffix and text of the file that belongs to it.
        marker: number of the line where the marker stands, and the lines that it takes.
        lines: how many lines of ``source`` go and come where every cut is moved and turned.
        shown: what then stands in the file.
        told: parts of what is told of that.
        turns: whether the orientation of a cut can be put in.
        position: what printing loses, m.
        rotation: of the entries of the rotation matrix.
        arc: a program with one arc among straight cuts, and its word for arcs.
        arc_told: what is told where the arc becomes lines.
        arcs_grow: whether an arc can take another radius; else it becomes lines.
        by_time: programs with a cut that takes a given time: text, number of its pose, words of the refusal where it
            would be divided, and its words for the time.
        twice: a program whose one line runs twice, and the words of the refusal of two poses.
        real: files of ../shared/data/cam that are refused, and why; the others with the suffixes of the language are
            changed. None: they have a test of their own.
        lines_of_a_pose: how many lines change for one.
        elsewhere: real file with a call of what is not in it, and parts of what is told of that.
    """

    source: str
    beside: tuple[str, str] | None = None
    marker: tuple[int, tuple[str, ...]]
    lines: tuple[int, int]
    shown: tuple[str, ...] = ()
    told: tuple[str, ...] = ()
    turns: bool = True
    position: float = 6e-8
    rotation: float = 3e-8
    arc: tuple[str, str]
    arc_told: tuple[str, ...]
    arcs_grow: bool = True
    by_time: tuple[tuple[str, int, str, str], ...] = ()
    twice: tuple[str, str] | None = None
    real: dict[str, str] | None = None
    lines_of_a_pose: int = 1
    elsewhere: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Sample:
    """A language: what of it is read, written, and changed in place.

    Attributes:
        examples: how many files its page shows at the least that are read or refused.
        own_blocks: blocks of its page that a test of the language runs.
    """

    read: ReadSample | None = None
    written: WrittenSample | None = None
    filtered: FilterSample | None = None
    examples: int = 0
    own_blocks: int = 0
