"""What all verbs share: the kinds of files that they take, and how they end: exit status, one message."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from types import FrameType
from typing import Any, NoReturn

import click

from compensator.verb_examples import EXAMPLES

REFUSED, INTERRUPTED, BROKEN_PIPE, TERMINATED = 1, 130, 141, 143  # exit status; above 128: of the signal

#: A file that is read, and one that is written. Every option that takes a file is one of the two.
INPUT, OUTPUT = click.Path(path_type=Path), click.Path(path_type=Path)


def strict_verb(task: Callable[..., None]) -> Callable[..., None]:
    """A verb that makes a result: --verbose, and --strict, which turns the warnings about it into a refusal."""
    strict = click.option("--strict", is_flag=True, help="Warnings refuse: exit status 1, nothing is written.")
    verbose = click.option("--verbose", is_flag=True, help="Say what is being done; show where a refusal comes from.")
    return strict(verbose(task))


class Verb(click.Command):
    """A command whose refusals are one message on stderr and exit status 1, and whose help ends with two examples."""

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        super().format_epilog(ctx, formatter)
        with formatter.section("Examples"):
            for example in EXAMPLES.get(self.name or "", ()):
                formatter.write(f"{' ' * formatter.current_indent}compensator {example}\n")

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except Exception as error:
            if not _is_refusal(error):
                raise
            if ctx.params.get("verbose"):
                import traceback

                traceback.print_exc()
            short = "there is not enough memory for this run; sample more coarsely, or split the file"
            _tell(short if isinstance(error, MemoryError) else str(error))
            ctx.exit(REFUSED)


class Verbs(click.Group):
    """The commands. An interrupt, a full disk and a closed pipe end each of them in order."""

    command_class = Verb

    def main(
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = None,
        complete_var: str | None = None,
        standalone_mode: bool = True,
        **extra: Any,
    ) -> Any:
        run: Callable[[], Any] = partial(super().main, args, prog_name, complete_var, standalone_mode=False, **extra)
        if not standalone_mode:
            return run()
        try:
            with _terminable():
                status = run()
            if sys.stdout is not None:
                sys.stdout.flush()
        except click.ClickException as error:
            error.show()
            status = error.exit_code
        except click.Abort:
            _tell("interrupted")
            status = INTERRUPTED
        except SystemExit as end:  # with 1: click's way to end where the reader of a pipe is gone
            _close_stdout()
            status = BROKEN_PIPE if end.code == 1 else end.code
        except BrokenPipeError:
            _close_stdout()
            status = BROKEN_PIPE
        except OSError as error:
            _close_stdout()
            _tell(f"{error.filename or 'standard output'}: {error.strerror or error}")
            status = REFUSED
        sys.exit(status)


def _is_refusal(error: Exception) -> bool:
    from compensator.errors import CompensatorError
    from stiffness.errors import StiffnessError
    from toolpaths.errors import ToolpathError

    return isinstance(error, CompensatorError | StiffnessError | ToolpathError | MemoryError)


def _tell(message: str) -> None:
    with suppress(OSError):  # stderr may be full or closed, too
        click.echo(f"compensator: {message}", err=True)


@contextmanager
def _terminable() -> Iterator[None]:
    """SIGTERM ends a run as an exception does, so that what was staged is removed."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGTERM, _terminated)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _terminated(_: int, __: FrameType | None) -> NoReturn:
    sys.exit(TERMINATED)


def _close_stdout() -> None:
    """What is left in its buffer goes nowhere: Python would try again when it ends."""
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
