"""The page of ``axis-map``: what its template shows."""

from __future__ import annotations

from compensator.report.csv.axis_map import STATUS
from compensator.report.figures.axis_map import axis_map_figure
from compensator.report.html.page import page
from compensator.report.json.text import Report
from compensator.report.words.findings import finding_sentences, note_sentences
from compensator.turn.axis_map import AxisMap
from toolpaths.finding import ERROR, WARNING


def axis_map_page(m: AxisMap, report: Report, robot: str) -> str:
    """The map as one file that opens without a network.

    Args:
        report: its JSON report.
    """
    shares = {word: report["share"][word.replace(" ", "_")] for word in STATUS.values()}
    return page(
        "axis_map",
        f"Turns about the tool axis: {m.path.toolpath.source}",
        {"map": axis_map_figure(m)},
        robot=robot,
        poses=f"{report['n_poses']:,}",
        turns=report["n_turns"],
        shares=[f"{word}: {share:.1%}" for word, share in shares.items() if share > 0],
        whole=len(report["turns_all_along_deg"]),
        deflection=_words(report["deflection_mm"]),
        sd=_words(report["deflection_sd_mm"]),
        findings=finding_sentences(report, (ERROR, WARNING)),
        notes=note_sentences(report),
    )


def _words(values: Report) -> dict[str, str]:
    """µm, one decimal; ``-`` where there is no such turn."""
    keys = ("chosen", "best_constant", "best_at_each_pose")
    return {key: "-" if values[key] is None else f"{values[key] * 1e3:.1f}" for key in keys}
