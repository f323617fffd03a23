"""Which files a program is made of: those that were named, those of a folder, or one with what lies beside it."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from toolpaths.errors import ReadError
from toolpaths.languages.table import READ, Language, reading

LIST = ".pgf"  # of the modules of a RAPID program


@dataclass(frozen=True)
class ProgramFiles:
    """The files of one program.

    Attributes:
        main: the file that runs first.
        others: those that were named with it; None: what it needs is looked for beside it.
        language: what they are written in; None: no suffix tells.
    """

    main: Path
    others: tuple[Path, ...] | None
    language: Language | None

    @property
    def paths(self) -> tuple[Path, ...]:
        """All that were named, the main one first."""
        return self.main, *(self.others or ())


def program_files(paths: Sequence[str | os.PathLike[str]], name: str | None = None) -> ProgramFiles:
    """The files of the program that a user named: one file, several, or the folder that holds them.

    Args:
        paths: as given; of several, the main one may stand anywhere.
        name: of the language, where the suffix does not tell it.

    Raises:
        ReadError: files of several languages, of a language whose programs are one file, or no main one among them.
    """
    given = [Path(path) for path in paths]
    if len(given) == 1 and given[0].is_dir():
        return _of_folder(given[0], name)
    language = next((known for path in given if (known := reading(path, name))), None)
    if name is not None and language is None:
        raise ReadError(str(given[0]), None, f"no language {name!r}", f"Known: {', '.join(x.name for x in READ)}")
    if len(given) == 1:
        return _listed(given[0], language) or ProgramFiles(given[0], None, language)
    for path in given:
        if path.is_dir():
            raise ReadError(str(path), None, "a folder among files", "Name the files, or the folder alone.")
        if (other := reading(path, name)) is not language and not (language and path.suffix.lower() in language.parts):
            problem = f"{_shown(other)} beside {_shown(language)}"
            raise ReadError(str(path), None, problem, "Name the files of one program.")
    if language is None or not language.several:
        problem = f"{len(given)} files, and programs in {_shown(language)} are one file"
        raise ReadError(str(given[1]), None, problem, "Name one file.")
    main = language.main_of([path for path in given if path.suffix.lower() not in (*language.parts, LIST)])
    return ProgramFiles(main, tuple(path for path in given if path != main), language)


def _shown(language: Language | None) -> str:
    return "a language that is not known" if language is None else language.name


def _of_folder(folder: Path, name: str | None) -> ProgramFiles:
    files = sorted(path for path in folder.iterdir() if path.is_file())
    lists = [path for path in files if path.suffix.lower() == LIST]
    if len(lists) == 1 and (listed := _listed(lists[0], reading(lists[0], name))):
        return listed
    several = [language for language in READ if language.several and name in (None, language.name)]
    programs = [path for path in files if path.suffix.lower() != LIST]
    found = {language.name: [p for p in programs if reading(p) is language] for language in several}
    present = [language for language in several if found[language.name]]
    if len(present) != 1:
        what = " and ".join(language.name for language in present) or "no program"
        names = ", ".join(language.name for language in several)
        problem = f"a folder with {what}; one program of one of {names} is expected"
        raise ReadError(str(folder), None, problem, "Name the toolpath file, or the files of one program.")
    language = present[0]
    return ProgramFiles(language.main_of(found[language.name]), None, language)


def _listed(path: Path, language: Language | None) -> ProgramFiles | None:
    """The modules that a .pgf lists."""
    if path.suffix.lower() != LIST or language is None or not path.is_file():
        return None
    files = language.listed(path)
    main = language.main_of([file for file in files if file.suffix.lower() not in language.parts])
    return ProgramFiles(main, tuple(file for file in files if file != main), language)
