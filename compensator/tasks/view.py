"""`view`: a page on this machine that shows a cell at work; it can be edited there, and saved under another name."""

from __future__ import annotations

import webbrowser
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from threading import Thread
from typing import Any

from compensator.cell.cell_file import load_cell
from compensator.errors import CompensatorError
from compensator.report.html.view import view_page
from compensator.tasks.outputs import Outputs
from compensator.tasks.run_files import writes
from compensator.tasks.say import Say, quiet
from compensator.tasks.source_lines import source_lines
from compensator.viewer.cell_edit import checked_edit
from compensator.viewer.live_cell import LiveCell, live_cell
from compensator.viewer.server import PageServer, PageService
from stiffness.errors import StiffnessError
from toolpaths.errors import ToolpathError
from toolpaths.files import read_program
from toolpaths.program_files import program_files

REFUSALS = (CompensatorError, StiffnessError, ToolpathError)


def view_server(
    cell: Path, toolpath: Sequence[Path] = (), *, read_as: str | None = None, port: int = 0, say: Say = quiet
) -> PageServer:
    """The server that shows a cell, ready to serve.

    Args:
        toolpath: a file, the files of a program, or their folder; none: only the arm is shown.
        read_as: language of the toolpath, where its suffix does not tell it. port: 0 takes a free one.

    Raises:
        ToolpathError, StiffnessError, CompensatorError: cell or toolpath is refused, or the port is taken.
    """
    say("reading the cell")
    table, source = load_cell(cell), None
    if toolpath:
        files = program_files(toolpath, read_as)
        say(f"reading {files.main.name}")
        source = read_program(files, chord=table.sampling.chord / 1e3, machine=table.posted_for())
    live = live_cell(cell, source, {} if source is None else source_lines(source))
    say("computing")
    first = live.shown({})
    try:
        return PageServer(_service(live, first), port)
    except (OSError, OverflowError) as e:
        raise CompensatorError(f"--port {port}: cannot listen there: {e}; leave it out for a free one") from e


def _service(live: LiveCell, first: Mapping[str, Any]) -> PageService:
    names = {"cell": live.path.name, "toolpath": "" if live.source is None else live.source.source}

    def edited(given: Any) -> dict[str, Any]:
        return live.shown(checked_edit(given, live.editable))

    def saved(given: Any) -> dict[str, Any]:
        name, edit = (given.get(key) if isinstance(given, dict) else None for key in ("name", "edit"))
        text = live.edited(checked_edit(edit, live.editable))
        target = new_file(live.path.parent, name)
        save_text(text, target)
        return {"saved": str(target)}

    def page(token: str) -> str:
        return view_page(first, names, token, spare_name(live.path))

    answers: dict[str, Callable[[Any], Mapping[str, Any]]] = {"/edit": edited, "/save": saved}
    return PageService(page=page, answers=answers, is_refusal=lambda e: isinstance(e, REFUSALS))


def new_file(folder: Path, name: object) -> Path:
    """Where a cell may be saved: a new .toml beside the cell, because the paths in it start there.

    Raises:
        CompensatorError: it is another place, or something stands there.
    """
    if not isinstance(name, str) or not name.isprintable() or Path(name).name != name or not name.endswith(".toml"):
        raise CompensatorError(f"{name!r}: expected the name of a .toml file; it goes into the folder of the cell")
    if name.startswith(".") or len(name) > 200:
        raise CompensatorError(f"{name!r}: expected a name that is seen, of at most 200 letters")
    target = folder / name
    if target.exists() or target.is_symlink():
        raise CompensatorError(f"{target}: stands there already; nothing is overwritten: give another name")
    return target


def spare_name(cell: Path) -> str:
    """A name beside a cell that is not taken."""
    names = (f"{cell.stem}-{k}.toml" for k in range(2, 10_000))
    return next((name for name in names if not (cell.parent / name).exists()), "")


@writes("target")
def save_text(text: str, target: Path) -> None:
    """Write a new file, whole or not at all.

    Raises:
        CompensatorError: it cannot be written.
    """
    with Outputs() as outputs:
        outputs.text(target, text)
        outputs.commit()


def serve(server: PageServer, *, browser: bool) -> None:
    """Serve until the user interrupts; ``browser``: open the page."""
    if browser:
        Thread(target=webbrowser.open, args=(server.url,), daemon=True).start()
    with server, suppress(KeyboardInterrupt):
        server.serve_forever()
