"""One page for a customer: the arm at work, three numbers, the error along the path, what it was computed from."""

from __future__ import annotations

from io import BytesIO
from typing import Any

import numpy as np
import numpy.typing as npt

from compensator.report.figures.layout import AFTER, BEFORE
from compensator.report.figures.thinning import path_length, thin
from compensator.report.html.path_tables import inputs
from compensator.report.scene.posed_bodies import Posed, posed_bodies
from compensator.report.words.findings import finding_sentences
from compensator.report.words.numbers import deflection_mm
from compensator.report.words.three_numbers import three_numbers
from compensator.solve.compensation import Compensation
from toolpaths.finding import ERROR, WARNING

Floats = npt.NDArray[np.float64]

A4 = (8.27, 11.69)  # inch
MOST_FINDINGS = 4
#: No text of a file is markup.
FONTS: dict[Any, Any] = {"pdf.fonttype": 42, "font.family": "DejaVu Sans", "text.parse_math": False}
LONGEST = 115  # characters of a line


def sheet(c: Compensation, report: dict[str, Any], after: Floats | None = None) -> bytes:
    """A PDF of one A4 page, the same bytes for the same result.

    Args:
        after: (N,) m, error with the program as written; None: nothing is corrected.
    """
    from matplotlib import rc_context

    with rc_context(FONTS):
        figure, title = sheet_figure(c, report, after)
        out = BytesIO()
        figure.savefig(out, format="pdf", metadata={"CreationDate": None, "Title": title, "Creator": "compensator"})
    return out.getvalue()


def sheet_figure(c: Compensation, report: dict[str, Any], after: Floats | None) -> tuple[Any, str]:
    """The page as a figure of matplotlib, and its title."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    corrected = after is not None
    figure = Figure(figsize=A4)
    FigureCanvasAgg(figure)
    title = "Compensated toolpath" if corrected else "Predicted deflection, not compensated"
    figure.text(0.08, 0.955, title, fontsize=17, weight="bold", va="top")
    figure.text(0.08, 0.925, _short(c.path.toolpath.source), fontsize=10, va="top", color="#5a646d")
    for k, number in enumerate(three_numbers(report, corrected)):
        figure.text(0.08 + 0.29 * k, 0.895, number["value"], fontsize=19, weight="bold", va="top")
        figure.text(0.08 + 0.29 * k, 0.862, _wrapped(number["words"], 32), fontsize=8.5, va="top")
    _arm(figure, c)
    _error(figure, c, after)
    _words(figure, c, report)
    return figure, title


def _arm(figure: Any, c: Compensation) -> None:
    """The arm at its worst pose, as it is."""
    from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

    axes = figure.add_axes((0.03, 0.44, 0.94, 0.40), projection="3d", computed_zorder=False)
    bodies, path = posed_bodies(c)
    path = path[thin(path, 1500)]
    corners = []
    for body in bodies:
        triangles = body.vertices[body.faces]
        corners.append(body.vertices)
        look = {"facecolors": _shaded(triangles, body), "linewidths": 0, "antialiased": False}
        axes.add_collection3d(Poly3DCollection(triangles, **look))
    axes.add_collection3d(Line3DCollection(np.stack([path[:-1], path[1:]], axis=1), colors=AFTER, linewidths=0.8))
    low, high = (f(np.concatenate([*corners, path]), axis=0) for f in (np.min, np.max))
    for name, a, b in zip("xyz", low, high, strict=True):
        getattr(axes, f"set_{name}lim")(a, b)
    axes.set_box_aspect(high - low, zoom=1.15)
    middle = path.mean(axis=0)
    axes.view_init(elev=18, azim=float(np.degrees(np.arctan2(middle[1], middle[0]))) - 65)
    axes.set_axis_off()


def _shaded(triangles: Floats, body: Posed) -> Floats:
    """Colours (F, 4) of triangles in the light from above the left shoulder."""
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    light = 0.55 + 0.45 * np.clip(normal @ np.array([0.3, -0.5, 0.81]), 0, 1)
    colour = np.array([int(body.colour[i : i + 2], 16) / 255 for i in (1, 3, 5)])
    return np.column_stack([light[:, None] * colour, np.full(len(light), body.opacity)])


def _error(figure: Any, c: Compensation, after: Floats | None) -> None:
    axes = figure.add_axes((0.1, 0.275, 0.82, 0.15))
    along = path_length(c)
    before = np.linalg.norm(c.error_before, axis=1) * 1e3
    curves = [("as the file stands", before, BEFORE)]
    if after is not None:
        curves.append(("with the program as written", after * 1e3, AFTER))
    for name, value, colour in curves:
        shown = np.where(c.cutting, value, np.nan)
        rows = thin(np.nan_to_num(shown)[:, None], 2000)
        axes.plot(along[rows], shown[rows], color=colour, linewidth=1, label=name)
    axes.set_xlabel("path length, rapids included, m", fontsize=8)
    axes.set_ylabel("TCP error, mm", fontsize=8)
    axes.tick_params(labelsize=8)
    axes.set_ylim(bottom=0)
    axes.legend(fontsize=8, frameon=False, loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=2)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def _words(figure: Any, c: Compensation, report: dict[str, Any]) -> None:
    lines = [f"{name}: {value}" for name, value in inputs(c).rows]
    lines.append(f"poses: {len(c):,}, of these cutting {int(c.cutting.sum()):,}")
    if c.is_corrected:
        lines.append(f"largest correction: {deflection_mm(report['max_correction_mm'])} mm")
    found = finding_sentences(report, (ERROR, WARNING))
    lines += ["", *(found[:MOST_FINDINGS] or ["no warnings"])]
    if len(found) > MOST_FINDINGS:
        lines.append(f"and {len(found) - MOST_FINDINGS} more warnings, in the report")
    version = report.get("provenance", {}).get("version", "")
    lines += ["", f"Predicted by a model of the arm's stiffness, not measured. compensator {version}".rstrip()]
    shown = [_wrapped(_short(line, 2 * LONGEST), LONGEST) for line in lines]
    figure.text(0.08, 0.235, "\n".join(shown), fontsize=7.5, va="top", linespacing=1.35)


def _short(text: str, most: int = LONGEST) -> str:
    plain = "".join(c if c.isprintable() else " " for c in text)
    return plain if len(plain) <= most else f"{plain[: most - 1]}…"


def _wrapped(text: str, width: int) -> str:
    from textwrap import wrap

    return "\n".join(wrap(text, width))
