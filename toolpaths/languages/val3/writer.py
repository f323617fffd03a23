"""Staubli VAL3 7 (CS8C, CS9): an application of .pgx programs, a .dtx of data and a .pjx that lists them.

NAME.pgx holds the moves (or calls NAME_001 ...), NAME.dtx tools, frame, speeds and points, NAME.pjx makes an
application of them, with the start() and stop() that every application has. Sources: VAL3 Reference Manual
(D28062804A; chapters applications, arm positions, movement control), VAL3 XML Format (pjx, pgx, dtx), and what
the posts of RoboDK (Apache-2.0) and visose/Robots (MIT) write for VAL3 s7. Reasons: docs/val3.md.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from toolpaths.finding import ERROR, WARNING, Finding
from toolpaths.languages.val3.data import Val3Data, data, data_text, start_index
from toolpaths.writing.checks import six_joints
from toolpaths.writing.lines import Between, lines_at_start, lines_before, with_crlf
from toolpaths.writing.names import is_legal, plain, words_of
from toolpaths.writing.program import Program
from toolpaths.writing.tool_load import load_words

#: Moves a program, and elements an array. Staubli publishes no limit of either below 9,999.
MOVES_PER_PROGRAM = 5000

#: Bytes of an application above which a warning is due: a controller loads it as a whole.
MEMORY = 10_000_000

_NAME_LIMIT = 15
_RESERVED = words_of(
    "AND BEGIN BOOL BREAK CALL CASE CONFIG DEFAULT DIO DO ELSE ELSEIF END ENDFOR ENDIF ENDSWITCH ENDWHILE FALSE "
    "FLANGE FOR FRAME IF JOINT JOINTRX MDESC MOD NOT NUM OR POINT POINTRX RETURN SIO START STEP STOP STRING "
    "SWITCH TO TOOL TRSF TRUE UNTIL WHILE WORLD XOR"
)
#: What the data are called.
_TAKEN = re.compile(r"fWork|tTool\d+|[jm]Start|[mp]Move\d+")
_PROGRAM = (
    '<?xml version="1.0" encoding="utf-8"?>\n'
    '<Programs xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" '
    'xmlns="http://www.staubli.com/robotics/VAL3/Program/2">\n'
    '  <Program name="%s" access="public">\n'
    "    <Code><![CDATA[\nbegin\n"
)
_PROGRAM_END = "end\n    ]]></Code>\n  </Program>\n</Programs>\n"


def findings(program: Program, path: Path) -> Iterator[Finding]:
    """What VAL3 cannot express, and what the user should know."""
    yield from six_joints(program, "a jointRx of VAL3 has")
    yield from name_findings(program.name, path, len(program))
    size = len(program) * 190
    if size > MEMORY:
        yield Finding(
            WARNING, path.name, f"about {size / 1e6:.0f} MB of VAL3, which a controller loads as a whole",
            "see that it has the memory, or sample the path more coarsely",
        )  # fmt: skip
    for n in sorted({int(t) for t in np.unique(program.tool)}):
        if words := load_words(program.tools[n]):
            what = f"a tool of VAL3 holds no payload: {', '.join(words)} (flange)"
            yield Finding(WARNING, f"tool {n}", what, "set it on the controller before running")


def name_findings(name: str, path: Path, moves: int) -> Iterator[Finding]:
    """What VAL3 does not take as the name of a file, or in the folder of an application."""
    if path.name == "-":
        yield Finding(ERROR, "-", "a VAL3 program is several files, standard output takes one", "name a file")
        return
    parts = -(-moves // MOVES_PER_PROGRAM)
    limit = _NAME_LIMIT - (len(f"_{parts:03d}") if parts > 1 else 0)
    if not is_legal(path.stem, limit, _RESERVED) or _TAKEN.fullmatch(path.stem):
        yield Finding(
            ERROR, path.name, f"{path.stem!r} is no VAL3 name: a letter, then letters, digits and _, at most "
            f"{limit} characters, no word of the language",
            "name the file so: VAL3 calls programs by their file's name",
        )  # fmt: skip
    yield from _folder_findings(path)


def _folder_findings(path: Path) -> Iterator[Finding]:
    """An application has its folder to itself: it is the one with start.pgx in it."""
    start = path.with_name("start.pgx")
    try:
        text = start.read_text(encoding="utf-8", errors="replace") if start.is_file() else ""
    except OSError:
        text = ""
    if text and f"call {path.stem}()" not in text:
        yield Finding(
            ERROR, start.name, "another application's start program is in the way",
            "give every VAL3 program a folder of its own",
        )  # fmt: skip


def files(program: Program, path: Path) -> Iterator[tuple[str, Iterator[str]]]:
    """The program, its parts where it is long, its data, the project, start() and stop()."""
    words = data(program, MOVES_PER_PROGRAM)
    stem, suffix = path.stem, path.suffix
    names = [f"{stem}_{i:03d}" for i in range(1, len(words.parts) + 1)] if len(words.parts) > 1 else []
    if names:
        calls = "".join(f"  call {name}()\n" for name in names)
        yield path.name, with_crlf(_main(program, words, stem, iter((calls,))))
    else:
        yield path.name, with_crlf(_main(program, words, stem, _moves(program, words, 0)))
    for i, name in enumerate(names):
        yield name + suffix, with_crlf(_program(name, _moves(program, words, i)))
    yield f"{stem}.dtx", with_crlf(data_text(program, words))
    yield f"{stem}.pjx", with_crlf(iter((_project(stem, [stem, *names], suffix),)))
    yield "start.pgx", with_crlf(_program("start", iter((f"  call {stem}()\n",))))
    yield "stop.pgx", with_crlf(_program("stop", iter(("  resetMotion()\n",))))


def _main(program: Program, words: Val3Data, stem: str, body: Iterator[str]) -> Iterator[str]:
    """The program of the file asked for: to the start, then ``body``, the moves or the calls of the parts."""
    tool = int(program.tool[0])
    head = f"  // {_comment(program.heading + ' ' + program.name + ' for ' + (program.robot or 'robot'))}\n"
    head += f"  // {_comment('Source: ' + program.source_name)}\n"
    head += "".join(f"  // {_comment(text)}\n" for text in program.stamp)
    for number in words.tools:
        said = "".join(f", {words}" for words in load_words(program.tools[number]))
        head += f"  // tool {number}: {_comment(program.tools[number].name + said)}\n"
    starts = 1 if program.start_joints is None else 2
    head += lines_at_start(program, _between(program))
    head += "".join(_joint_move(i, tool) for i in range(starts))
    end = "  waitEndMove()\n" + lines_before(program, _between(program)).get(len(program), "")
    return _program(stem, iter((head,)), body, iter((end,)))


def _program(name: str, *bodies: Iterator[str]) -> Iterator[str]:
    yield _PROGRAM % name
    for body in bodies:
        yield from body
    yield _PROGRAM_END


def _moves(program: Program, words: Val3Data, part: int) -> Iterator[str]:
    """The lines of one part; its points and speeds are numbered from 0."""
    block, index = words.parts[part].block, words.parts[part].index
    before = lines_before(program, _between(program), block)
    line = f"%s  movel(pMove{part + 1:03d}[%d],tTool%d[0],mMove{part + 1:03d}[%d])\n"
    for b in program.blocks(4096, block.start, block.stop):
        keys = range(b.start - block.start, b.stop - block.start)
        tools, speeds = program.tool[b].tolist(), index[keys.start : keys.stop].tolist()
        said = [before.get(block.start + i, "") for i in keys]
        yield "".join(line % row for row in zip(said, keys, tools, speeds, strict=True))


def _between(program: Program) -> Between:
    starts = start_index(program)
    return Between(
        comment=lambda text: f"  // {_comment(text)}\n",
        line=lambda line: f"  waitEndMove()\n  {line}\n",
        halt=_halt,
        mount=lambda tool: "",
        go=lambda pose: _joint_move(starts[pose], int(program.tool[pose])),
    )


def _joint_move(start: int, tool: int) -> str:
    return f"  movej(jStart[{start}],tTool{tool}[0],mStart[0])\n"


def _halt(text: str) -> str:
    """Stands still, shows the text, waits for a key."""
    said = text.replace("then go on", "then press a key") if "then go on" in text else f"{text}, press a key"
    shown = _comment(said).replace('"', "'").replace("\\", "/")
    return f'  waitEndMove()\n  userPage()\n  cls()\n  putln("{shown}")\n  get()\n'


def _comment(text: str) -> str:
    """One line that cannot end the CDATA section it stands in."""
    return plain(text).replace("]]>", "]] ")


def _project(stem: str, programs: list[str], suffix: str) -> str:
    listed = "".join(f'    <Program file="{name}{suffix}" />\n' for name in programs)
    return (
        '<?xml version="1.0" encoding="utf-8"?>\n'
        '<Project xmlns="http://www.staubli.com/robotics/VAL3/Project/3">\n'
        '  <Parameters version="s7.5.3" stackSize="5000" millimeterUnit="true" />\n'
        f'  <Programs>\n{listed}    <Program file="start.pgx" />\n    <Program file="stop.pgx" />\n  </Programs>\n'
        f'  <Database>\n    <Data file="{stem}.dtx" />\n  </Database>\n  <Libraries />\n</Project>\n'
    )
