"""What is computed is written before what is drawn: model and JSON first, the page after them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from compensator.errors import CompensatorError
from compensator.tasks.outputs import Outputs


def write_with_page(
    texts: Sequence[tuple[Path, str]],
    html: Path | None,
    page: Callable[[Callable[[str], None]], str],
    *,
    strict: bool = False,
) -> tuple[str, ...]:
    """Write files, then make a page and write it.

    Args:
        texts: target and content. page: makes the page at ``html``; is given what takes its warnings.
        strict: a warning of the page refuses all files: it is made first.

    Returns:
        Warnings of the page: figures that could not be drawn.

    Raises:
        CompensatorError: a file cannot be written, and then none is; or the page as a whole cannot be made, when the
            others are written already.
    """
    warnings: list[str] = []
    if strict and html is not None:
        made = page(warnings.append)
        if warnings:
            raise CompensatorError("\n  ".join([f"--strict: {html} is incomplete. Nothing was written", *warnings]))
        texts, html = [*texts, (html, made)], None
    with Outputs() as outputs:
        for target, text in texts:
            outputs.text(target, text)
        outputs.commit()
    if html is None:
        return ()
    with Outputs() as outputs:
        try:
            made = page(warnings.append)
        except Exception as error:
            there = ", ".join(str(target) for target, _ in texts) or "nothing else was asked for"
            why = f"the report could not be made ({type(error).__name__}: {error})"
            raise CompensatorError(f"{html}: {why}; written and complete: {there}") from error
        outputs.text(html, made)
        outputs.commit()
    return tuple(warnings)
