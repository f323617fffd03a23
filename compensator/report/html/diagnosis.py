"""The HTML report of ``diagnose``: one file that opens without a network, the same bytes for the same diagnosis."""

from __future__ import annotations

from html import escape
from typing import Any

from compensator.report.figures.diagnosis import pattern_figure, ranking_figure, split_figure
from compensator.report.figures.residual_map import enlargement, map_figure
from compensator.report.figures.thinning import Figure
from compensator.report.html import diagnosis_tables as tables
from compensator.report.html.fit_tables import millimetres
from compensator.report.html.path import page_head, page_scripts
from compensator.report.views.diagnosis import Looked, Posture, looked_at, postures
from compensator.report.views.diagnosis_pattern import patterns
from compensator.report.views.diagnosis_remainder import remainder
from compensator.report.words import diagnosis as words
from stiffness.diagnosis.result import Diagnosis
from stiffness.model.model import ComplianceModel

SETUPS = 12  # in the menu of the map
Report = dict[str, Any]
_SCRIPT = """
const figures = JSON.parse(document.getElementById("figures").textContent);
const config = {responsive: true, displaylogo: false, plotlyServerURL: ""};
for (const [id, f] of Object.entries(figures)) Plotly.newPlot(id, f.data, f.layout, config);
const map = document.getElementById("map");
let turning = false;
if (map && figures.map.layout.scene2) map.on("plotly_relayout", change => {
  const camera = change["scene.camera"] || change["scene2.camera"];
  if (!camera || turning) return;
  turning = true;
  Plotly.relayout(map, {"scene.camera": camera, "scene2.camera": camera}).then(() => { turning = false; });
});
"""


def diagnosis_page(d: Diagnosis, model: ComplianceModel, report: Report) -> str:
    """The report of a diagnosis.

    Args:
        model: the model at hand.
        report: the JSON report of the same diagnosis, as ``diagnosis_report`` makes it.
    """
    looked = looked_at(d, model)
    shown = postures(looked, SETUPS)
    moved = bool(d.added or d.changed)
    figures: dict[str, Figure] = {
        "map": map_figure(shown, ["the model at hand", "the refined model"] if moved else ["the model at hand"]),
        "split": split_figure(report),
        **({"ranking": ranking_figure(d)} if any(c.where for c in d.candidates) else {}),
    }
    evidence = _pattern_figures(d, looked)
    figures |= {name: drawn for group in evidence for name, drawn in group.items()}
    rest = remainder(d, looked) if d.verdict == "unexplained" else None
    if rest is not None:
        figures["remainder"] = pattern_figure(rest)
    title = f"Diagnosis: {escape(looked[0].session.robot.name)}"
    body = [
        f"<h1>{title}</h1>",
        *_headline(d, report),
        *_map(d, shown, moved),
        *_split(report),
        *_ranking(d, "ranking" in figures),
        *_evidence(d, evidence),
        *_confusion(d),
        *_attribution(d, rest is not None),
        *_next(report),
        *_details(d, model),
    ]
    scripts = [*page_scripts(figures)[:-1], f"<script>{_SCRIPT}</script>"]
    return "\n".join([page_head(title), *body, *scripts, "</body>", "</html>", ""])


def _headline(d: Diagnosis, report: Report) -> list[str]:
    verdict, _, rest = words.verdict_sentence(d).partition(": ")
    out = [
        f'<p class="lead"><b>{escape(verdict)}:</b> {escape(rest)}</p>',
        *(f"<p>Added: {escape(words.added_sentence(a))}.</p>" for a in d.added),
        *(f"<p>Changed: {_arrow(words.changed_sentence(c))}.</p>" for c in d.changed[: words.LISTED]),
        f"<p>RMS per axis on readings that took no part: {_arrow(words.before_after(report))}.</p>",
        f'<p class="quiet">{escape(_capital(words.caution(d, report)))}.</p>',
    ]
    if d.notes:
        out.append("<ul>" + "".join(f"<li>{escape(note)}</li>" for note in d.notes) + "</ul>")
    return out


def _arrow(text: str) -> str:
    return escape(text).replace(" -&gt; ", "\u00a0→\u00a0")


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _map(d: Diagnosis, shown: list[Posture], moved: bool) -> list[str]:
    after = " Left with the model at hand, right with the refined one, both at one scale." if moved else ""
    sessions = [e.session for e in d.fit.sessions]
    return [
        "<h2>Where the readings miss the prediction</h2>",
        f"<p>An arrow is one reading: measured minus predicted, <b>{enlargement(shown):,.0f} times</b> as long as it "
        f"is, a dot at its tip.{after} Grey: the undeflected arm, base to flange; stalks to the reflectors. The menu "
        f"has the {len(shown)} set-ups with the largest residuals (RMS per axis), largest first. Drag to turn, scroll "
        "to zoom.</p>",
        '<div id="map" style="height:560px"></div>',
        tables.reflectors(sessions),
    ]


def _split(report: Report) -> list[str]:
    return [
        "<h2>Noise, parameters, structure</h2>",
        "<p>On readings that took no part. Noise: what repeats and data sheets leave for a perfect model. Parameters: "
        "goes when the model's own numbers are fitted anew. Structure: what is left then. Squares add, so the bars are "
        "mean squares; the text in them is the RMS per axis.</p>",
        '<div id="split"></div>',
        tables.split(report),
        tables.scores(report),
    ]


def _ranking(d: Diagnosis, drawn: bool) -> list[str]:
    out = ["<h2>Candidates</h2>"]
    if not d.candidates:
        return [*out, "<p>There are too few set-ups to leave some out, so nothing was compared.</p>"]
    bare = [c.effect for c in d.candidates if not c.where]
    if drawn:
        out += [
            "<p>The model with one effect of the catalogue more, at the sites where it pays, on set-ups left out in "
            "turn. Weighted by the noise and given as the RMS per axis of a tracker reading. Blue: what was added in "
            "the end.</p>",
            '<div id="ranking"></div>',
            tables.candidates(d),
        ]
    if bare:
        out.append(f'<p class="quiet">Of no help anywhere: {escape(words.joined(bare))}.</p>')
    return out


def _pattern_figures(d: Diagnosis, looked: tuple[Looked, ...]) -> list[dict[str, Figure]]:
    """Of every addition its figures by their id."""
    out = []
    for k, a in enumerate(d.added):
        drawn = [pattern_figure(p) for p in patterns(d, looked, a)]
        out.append({f"pattern-{k + 1}" + (f"-{i + 1}" if i else ""): f for i, f in enumerate(drawn)})
    return out


def _evidence(d: Diagnosis, figures: list[dict[str, Figure]]) -> list[str]:
    out = []
    for a, drawn in zip(d.added, figures, strict=True):
        out += [
            f"<h2>Evidence: {escape(a.effect)} in {escape(words.joined(a.where))}</h2>",
            "<p>Left: what the readings show when only this addition is taken out of the refined model, and what it "
            "says there (black). Right: what is left with it, at the same scale. Every reading that is no outlier is "
            "used, those that took no part too.</p>",
            *(f'<div id="{name}"></div>' for name in drawn),
        ]
    return [*out, tables.additions(d)] if d.added else out


def _confusion(d: Diagnosis) -> list[str]:
    out = ["<h2>What could not be told apart</h2>"]
    alike = [a for a in d.added if a.confused_with]
    for a in alike:
        names = escape(words.joined(a.confused_with, "or"))
        out.append(
            f"<p><b>{escape(a.effect)}</b> in {escape(words.joined(a.where))} or {names}: these readings fit either. "
            "The refined model has the first; the set-ups below would tell.</p>"
        )
    if not alike:
        told = words.confusion_sentence(d) if d.added or d.verdict == "unexplained" else "nothing was added"
        out.append(f"<p>{escape(_capital(told))}.</p>")
    return out


def _attribution(d: Diagnosis, drawn: bool) -> list[str]:
    out = ["<h2>What the residual points at</h2>"]
    if not d.points_at:
        return [*out, "<p>No place and no column carries any structure: what is left is noise.</p>"]
    moved = "with what was found in the model" if d.added or d.changed else "with the model's numbers fitted anew"
    when = moved if d.verdict == "unexplained" else "before anything was added"
    return [
        *out,
        f"<p>Without the catalogue, {when}: how much of the structure in set-ups left out is explained when one place "
        "moves, or everything follows one column. Shares overlap and need not add up to 100 %.</p>",
        tables.attribution(d),
        *(['<div id="remainder"></div>'] if drawn else []),
    ]


def _next(report: Report) -> list[str]:
    if not report["next_setups"]:
        return []
    return [
        "<h2>What to measure next</h2>",
        "<p>Postures that the arm can reach; unloaded and loaded.</p>",
        tables.next_setups(report),
    ]


def _details(d: Diagnosis, model: ComplianceModel) -> list[str]:
    out = ["<h2>Parameters that have moved</h2>"]
    out.append(tables.changed(d.changed) if d.changed else "<p>None, beyond what model and readings leave open.</p>")
    spread = millimetres(d.fit.solution.misfit)
    return [
        *out,
        "<h2>Rows left out</h2>",
        tables.outliers(d),
        "<h2>What this was computed from</h2>",
        tables.inputs(d, model),
        f'<p class="quiet">Residual of the refined fit over the noise, weighted: {spread}.</p>',
    ]
