"""The man page of the command, of the same text as --help."""

from __future__ import annotations

from collections.abc import Iterator

import click

from compensator.verb_examples import EXAMPLES

FILES = (
    ("cell.toml", "what stands around the robot: docs/compensate.md"),
    ("stiffness.toml", "model of the arm: docs/effects.md"),
    ("session.toml, samples.csv", "what was measured: docs/sessions.md"),
)
STATUS = (
    ("0", "everything that was asked for is written"),
    ("1", "refused or failed: one message on standard error, nothing is left behind or changed"),
    ("2", "wrong usage"),
    ("130, 141, 143", "interrupted, nobody reads the pipe, terminated"),
)


def man_page(main: click.Group, version: str) -> str:
    """Macros of man(7)."""
    what = (main.help or "").rstrip(".")
    lines = [
        f'.TH COMPENSATOR 1 "" "toolpath-compensator {version}" "User commands"',
        ".SH NAME",
        f"compensator \\- {_line(what[:1].lower() + what[1:])}",
        ".SH SYNOPSIS",
        ".B compensator",
        "VERB [OPTIONS] [ARGUMENTS]",
        ".SH VERBS",
    ]
    for name in sorted(main.commands):
        lines += _verb(name, main.commands[name])
    lines += [".SH FILES", *_pairs(FILES), ".SH EXIT STATUS", *_pairs(STATUS)]
    lines += [".SH ENVIRONMENT", ".TP", ".B NO_COLOR", "no colours where it is set"]
    return "\n".join([*lines, ""])


def _verb(name: str, command: click.Command) -> Iterator[str]:
    context = click.Context(command, info_name=name)
    usage = " ".join(command.collect_usage_pieces(context))
    yield from (f".SS {_line(name)}", f"\\fBcompensator {_line(name)}\\fR {_line(usage)}", ".PP")
    yield _line(command.help or "")
    for parameter in command.get_params(context):
        record = parameter.get_help_record(context)
        if record is not None and isinstance(parameter, click.Option):
            yield from (".TP", f"\\fB{_line(record[0])}\\fR", _line(record[1]) or "\\&")
    yield from (".PP", "Examples:", ".PP", ".nf")
    yield from (f"    compensator {_line(example)}" for example in EXAMPLES.get(name, ()))
    yield ".fi"


def _pairs(rows: tuple[tuple[str, str], ...]) -> Iterator[str]:
    for head, text in rows:
        yield from (".TP", f"\\fB{_line(head)}\\fR", _line(text))


def _line(text: str) -> str:
    """One line without what roff would take for its own."""
    shown = " ".join(text.split()).replace("\\", "\\e").replace("-", "\\-")
    return f"\\&{shown}" if shown.startswith((".", "'")) else shown
