"""Verbs about the command line itself: completion of a shell, the man page."""

from __future__ import annotations

import click

from compensator.command_line import Verb

SHELLS = ("bash", "zsh", "fish")


@click.command(cls=Verb)
@click.argument("shell", type=click.Choice(SHELLS))
@click.pass_context
def completion(context: click.Context, shell: str) -> None:
    """Print what completes verbs, options and files in a SHELL."""
    from click.shell_completion import get_completion_class

    kind = get_completion_class(shell)
    if kind is None:
        raise click.UsageError(f"no completion for {shell}")
    made = kind(context.find_root().command, {}, "compensator", "_COMPENSATOR_COMPLETE")
    click.echo(made.source_template % made.source_vars())


@click.command(cls=Verb)
@click.pass_context
def man(context: click.Context) -> None:
    """Print the man page, which is made of the text of --help."""
    from compensator.terminal.man_page import man_page
    from compensator.version import version

    command = context.find_root().command
    if isinstance(command, click.Group):
        click.echo(man_page(command, version()), nl=False)


VERBS = (completion, man)
