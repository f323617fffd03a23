"""SiemensActions: what a block of a SINUMERIK program does: modal words, tools, frames, retracts, cycles, moves."""

from __future__ import annotations

from collections.abc import Mapping

from toolpaths.languages.siemens.block import ADDRESSES, Arguments, Given, SiemensBlock, shown
from toolpaths.languages.siemens.cycles import SiemensCycles
from toolpaths.languages.siemens.drilling import DRILLING, PATTERNS
from toolpaths.languages.siemens.frames import FRAME_WORDS
from toolpaths.languages.siemens.motion import AXES, INCH, MM, MOVING, ORIENTATIONS, ROTARY, plain
from toolpaths.languages.siemens.words import (
    EVENT_CALLS,
    G_REFUSED,
    G_SETTINGS,
    G_SYSTEMS,
    LETTERS,
    SETTING_VALUES,
    SETTINGS,
)
from toolpaths.machine import Machine
from toolpaths.reading.cnc_feed import INVERSE_TIME, PER_MINUTE, PER_TURN
from toolpaths.reading.machine_words import machine_commands, stay
from toolpaths.reading.source_text import comment_word
from toolpaths.reading.tool_numbers import ToolNumbers

_UNITS = {71: MM, 710: MM, 700: INCH}
_FEEDS = {93: INVERSE_TIME, 94: PER_MINUTE, 95: PER_TURN}
_PLANES = {17: 2, 18: 1, 19: 0}
_FIXED_POINTS = frozenset((74, 75))
_POLES = frozenset((110, 111, 112))
#: G words whose block has coordinates of their own.
_TAKING = dict.fromkeys((53, 153, *_FIXED_POINTS), "machine") | dict.fromkeys(_POLES, "pole") | {4: "stay"}
_PASSED = frozenset((4, 53, 153, *_FIXED_POINTS))
#: G words that this reader acts on, and those that name no place in the work object: remarks, as the dwell is.
G_ACTED = frozenset((0, 1, 2, 3, *_PLANES, 90, 91, *_UNITS, *_FEEDS, *G_SYSTEMS, *_POLES))
G_RETRACTS = _PASSED
_SAID = frozenset("FSTDH")
_KNOWN = frozenset((*LETTERS, *ADDRESSES))
_PLACES = frozenset((*"XYZ", "AP", "RP"))
_CIRCLES = ("CIP", "CT")
#: Words that only some blocks have: those that move, and those whose coordinates are no move.
_WORDS_OF = {
    "move": frozenset(("TURN", "RND", "CHF", "CHR", "FRC", "FB")),
    "machine": frozenset(("X1", "Y1", "Z1", "FP")),
    "frame": frozenset(("RPL",)),
}
_REST = frozenset((*_WORDS_OF["move"], *_WORDS_OF["machine"], "RPL", "P"))
#: Groups of G words of which a block has one.
_GROUPS = {g: k for k, group in enumerate(((0, 1, 2, 3), _PLANES, (90, 91), _UNITS, _FEEDS, G_SYSTEMS)) for g in group}
ENDS = (2, 17, 30)
_TRANSFORMED = frozenset(("TRAORI", "TRAFOOF"))
#: Bare words that this reader acts on.
ACTED = frozenset((*FRAME_WORDS, *_CIRCLES, *ORIENTATIONS, *_TRANSFORMED, "SUPA", "SETMS", "CYCLE800"))
#: Calls that it acts on.
CALLED = frozenset((*DRILLING, *PATTERNS, "CYCLE800", "TRAORI", "SETMS"))


class SiemensActions(SiemensCycles):
    """Acts on the blocks of one file.

    Attributes:
        changes: the file has an M6: a T only selects.
    """

    def __init__(self, source: str, machine: Machine | None) -> None:
        super().__init__(source, machine)
        self.changes = False
        self._tools, self._selected = ToolNumbers(), 0
        self._edges: dict[int, int] = {}
        self._master = 1

    def act(self, block: SiemensBlock, line: int) -> int | None:
        """Act on one block; the M word that ends the program, if it has one.

        Raises:
            ValueError: a word is refused.
        """
        values, keys = block.values, block.values.keys()
        takes = ""  # what the coordinates of the block belong to, where they are no move
        if len(block.gs) > 1:
            _check_groups(block.gs)
        for g in block.gs:
            if g <= 3:
                self.motion = g
            elif g in _TAKING:
                takes = _TAKING[g]
            if g > 3:
                self._g(g, values)
        if block.words:
            takes = self._words(block, line) or takes
        if block.unknown and (takes != "machine" or not block.unknown.keys() <= AXES | ROTARY):
            name, why = next(iter(block.unknown.items()))
            raise ValueError(f"{name} depends on {why}: known only at run time", "Post it with numbers.")
        extended = [name for name in keys if name not in _KNOWN] if not keys <= _KNOWN else []
        if block.ms or extended or not keys.isdisjoint(_SAID):
            self._letters(block, extended, line, stays=takes == "stay")
        for name, given in block.calls:
            self._call(name, given, line)
        if not takes and not keys.isdisjoint(MOVING):
            takes = "move"
        if not keys.isdisjoint(_REST):
            _check_rest(values, takes)
        if takes == "move":
            self.move(values, line)
            if self.modal is not None and not keys.isdisjoint(_PLACES):
                self._drill(self.modal, line)
        elif takes == "stay":
            self._stay(values, line)
        elif takes == "machine":
            self._retract(block, line)
        return next((m for extension, m in block.ms if m in ENDS and not extension), None) if block.ms else None

    def _g(self, g: int, values: Mapping[str, Given]) -> None:
        if g in G_SETTINGS or g in _PASSED:
            return
        if g in G_REFUSED:
            raise ValueError(f"G{g}: {G_REFUSED[g]}")
        if g in _PLANES:
            self.no_corner()
            self.normal = _PLANES[g]
        elif g in (90, 91):
            self.relative = g == 91
        elif g in _UNITS:
            if self.unit not in (None, _UNITS[g]):
                raise ValueError(f"G{g}: the unit changes within the program", "Post with one unit.")
            self.unit = _UNITS[g]
        elif g in _FEEDS:
            self.feed.choose(_FEEDS[g])
        elif g in G_SYSTEMS:
            self.frames.choose(f"G{g}", used=len(self.track) > 0 or any(v == v for v in self.at))
            self.put_frame()
        elif g in _POLES:
            self.choose_pole(g, values)
        elif g in (25, 26):
            if not AXES.isdisjoint(values) or not ROTARY.isdisjoint(values):
                raise ValueError(f"G{g} with axes: limits of the working area")
        else:
            raise ValueError(f"G{g}: this reader does not know it")

    def _words(self, block: SiemensBlock, line: int) -> str:
        """Bare words; what the coordinates of the block belong to."""
        for word in block.words:
            if word in FRAME_WORDS:
                self._frame(word, block, line)
            elif word in _CIRCLES:
                self.motion = word
            elif word == "TRAORI":
                self._transform(line)
            elif word == "TRAFOOF":
                self.end_tip()
                self.track.event(word, line)
            elif word in ("ORIWKS", "ORIMKS"):
                self.in_machine = word == "ORIMKS"
            elif word in ORIENTATIONS:
                self.angles = word
            elif word == "CYCLE800":
                self._swivel([], line)
            elif word == "SETMS":
                self._master = 1
            elif word not in SETTINGS and word not in SETTING_VALUES and word != "SUPA":
                problem = (
                    f"{word}: this reader does not know the word, and no program of that name is in the file or beside"
                )
                raise ValueError(problem, "Take it out if it does not move the tool.")
        return "machine" if "SUPA" in block.words else "frame" if FRAME_WORDS.intersection(block.words) else ""

    def _letters(self, block: SiemensBlock, extended: list[str], line: int, *, stays: bool) -> None:
        """F, S, T, D and M; a stay (G4) has F and S of its own."""
        values, words = block.values, []
        if "F" in values and not stays:
            self.feed.give(plain(values, "F"))
        for name in ("T", "S", *extended):
            if name not in values:
                continue
            if name[0] in "ST" and (len(name) == 1 or name[1:].isdigit()):
                if name[0] == "T":
                    words.append(self._tool(values[name]))
                elif not stays:
                    words.append(self._speed(name, plain(values, name)))
            elif len(name) == 1 or name[0] not in "DH":
                raise ValueError(f"{shown(name, values[name])}: this reader does not know the address")
        own = [m for extension, m in block.ms if extension in (0, self._master) and m not in ENDS]
        for extension, m in block.ms:
            if m == 6:
                self.tool = self._selected
            if m not in ENDS or extension:
                words.append(f"M{m}" if extension in (0, self._master) else f"M{extension}={m}")
        if "D" in values:
            self._edge(plain(values, "D"))
        words += [f"{name}{plain(values, name):g}" for name in ("D", "H") if name in values]
        changed = "T" in values or 6 in own
        commands = machine_commands(
            self.track,
            own,
            speed=self._said_speed(values, stays=stays),
            tool=self._selected if changed else None,
            mounted=6 in own or not self.changes,
        )
        if words:
            self.track.event(" ".join(words), line, *commands)

    def _said_speed(self, values: Mapping[str, Given], *, stays: bool) -> float | None:
        """S of the master spindle in a block that does not stay."""
        names = [name for name in ("S", f"S{self._master}") if name in values]
        return plain(values, names[0]) if names and not stays else None

    def _tool(self, given: Given) -> str:
        if isinstance(given, tuple):
            raise ValueError("T: a number or a name is expected")
        self._selected = self._tools.of(given)
        if not self.changes:
            self.tool = self._selected
        return f'T="{given}" (tool {self._selected})' if isinstance(given, str) else f"T{self._selected}"

    def _speed(self, name: str, value: float) -> str:
        spindle = int(name[1:]) if len(name) > 1 else 0
        if spindle in (0, self._master):
            self.feed.spin(value)
            return f"S{value:g}"
        return f"{name}={value:g}"

    def _edge(self, value: float) -> None:
        """D: the edge of the tool; each has a tip of its own, the cell has one."""
        edge, tool = int(value), self._selected
        if edge and self._edges.setdefault(tool, edge) != edge:
            problem = (
                f"D{edge} after D{self._edges[tool]} of one tool: where the tip of another edge is, is not in the file"
            )
            raise ValueError(problem, "Post with one D for each tool.")

    def _call(self, name: str, given: Arguments, line: int) -> None:
        if name == "TRAORI":
            if any(v is not None and v != 1.0 for v in given):
                raise ValueError("TRAORI with more than a 1: a tool or axes that the file does not explain")
            self._transform(line)
        elif name == "CYCLE800":
            self._swivel(given, line)
        elif name in DRILLING:
            self._drill(self.cycle(name, given), line)
        elif name in PATTERNS:
            self._pattern(name, given, line)
        elif name == "SETMS":
            self._master = int(given[0]) if given and isinstance(given[0], float) else 1
        elif name in EVENT_CALLS:
            if name != "MSG" or given != [None]:
                self.track.event(comment_word(self.text), line)
        else:
            raise ValueError(f"{name}(...): a cycle or subprogram that is not in the file, and not beside it",
                             "Post its moves, or put it beside the file.")  # fmt: skip

    def _stay(self, values: Mapping[str, Given], line: int) -> None:
        """G4 F (s) or S (turns)."""
        if not MOVING.isdisjoint(values):
            raise ValueError("G4 with coordinates; it stands in a block of its own")
        stays = [f"{name}{plain(values, name):g}" for name in values if name[0] in "FS"]
        seconds = plain(values, "F") if "F" in values else self._seconds(-plain(values, "S"))
        self.track.event(" ".join(["G4", *stays]), line, stay(seconds))

    def _retract(self, block: SiemensBlock, line: int) -> None:
        """SUPA, G53, G153, G74, G75: a place of the machine."""
        values, words = block.values, comment_word(self.text)
        axes = [c for c in "XYZ" if c in values or f"{c}1" in values]
        turned = [c for c in "ABC" if c in values]
        fixed = not _FIXED_POINTS.isdisjoint(block.gs)
        if not fixed and self.motion != 0 and (axes or turned):
            raise ValueError(
                f"{words}: a feed move to a place of the machine", "Read is only a rapid retract: G0 SUPA Z.."
            )
        if not MOVING.isdisjoint(values.keys() - {*AXES, *ROTARY}):
            raise ValueError(f"{words}: words of arcs or vectors in coordinates of the machine")
        if turned and not fixed:
            self.turn_to(values, alone=True)
        if axes:
            self.lose(axes, words, line)
        elif turned:
            self.lose((), words, line)
        else:
            self.track.event(words, line)


def _check_groups(gs: list[int]) -> None:
    groups = [_GROUPS[g] for g in gs if g in _GROUPS]
    if len(groups) != len(set(groups)):
        raise ValueError(
            f"{' '.join(f'G{g}' for g in gs)}: two words of one group in a block", "Keep the one that counts."
        )


def _check_rest(values: Mapping[str, Given], takes: str) -> None:
    for name in values:
        if name in _REST and name not in _WORDS_OF.get(takes, ()):
            raise ValueError(f"{shown(name, values[name])}: this block has no use for it", "Check it, or take it out.")
