"""The residual map: arrows at the reflectors of one set-up at a time, on the arm as it stood, before and after."""

from __future__ import annotations

import numpy as np

from compensator.report.analysis.session_residuals import Floats
from compensator.report.analysis.setup_residuals import SetupResiduals
from compensator.report.figures.layout import AFTER, BEFORE, FONT, INK, Figure, heading, hover, number
from compensator.report.figures.thinning import numbers

LONGEST = 0.14  # of the size of the arm: the longest arrow but for one in twenty
ARM = "#5a646d"


def enlargement(setups: list[SetupResiduals]) -> float:
    """How many times arrows are longer than residuals: 1, 2 or 5 times a power of ten."""
    length = np.concatenate([np.linalg.norm(p.before, axis=1) for p in setups])
    reach = max(float(np.ptp(np.concatenate([p.skeleton for p in setups]), axis=0).max()), 1e-3)
    wanted = LONGEST * reach / max(float(np.percentile(length, 95)), 1e-9)
    power = 10.0 ** np.floor(np.log10(wanted))
    return float(power * max(f for f in (1.0, 2.0, 5.0) if f * power <= wanted * 1.000001))


def map_figure(setups: list[SetupResiduals], titles: list[str]) -> Figure:
    """One scene, or two beside each other: ``titles`` of one or both; a menu picks the set-up."""
    scale = enlargement(setups)
    boxes = _boxes(setups, scale)
    data: list[Figure] = []
    per: list[int] = []
    for at, p in enumerate(setups):
        start = len(data)
        for k in range(len(titles)):
            residual, colour = (p.after, AFTER) if k else (p.before, BEFORE)
            common = {"scene": f"scene{number(k)}", "visible": at == 0, "showlegend": False}
            data += [{**trace, **common} for trace in (*_arm(p), *_arrows(p, residual, scale, colour))]
        per.append(len(data) - start)
    layout: Figure = {
        "font": FONT, "height": 560, "margin": {"l": 0, "r": 0, "t": 60, "b": 0}, "showlegend": False,
        "annotations": [], "updatemenus": [_menu(setups, per, boxes, len(titles))] if len(setups) > 1 else [],
    }  # fmt: skip
    for k, title in enumerate(titles):
        across = [k / len(titles) + 0.005, (k + 1) / len(titles) - 0.005]
        layout[f"scene{number(k)}"] = _scene(boxes[0], across)
        layout["annotations"].append(heading(title, sum(across) / 2, above=True))
    return {"data": data, "layout": layout}


def _arm(p: SetupResiduals) -> list[Figure]:
    """The arm as it stood, stalks to its reflectors, and these."""
    stalks = np.full((3 * len(p.reflector), 3), np.nan)
    stalks[0::3], stalks[1::3] = p.link, p.reflector
    return [
        {
            "type": "scatter3d", "mode": "lines+markers", **_xyz(p.skeleton), "hoverinfo": "skip",
            "line": {"width": 8, "color": ARM}, "marker": {"size": 4, "color": ARM},
        },
        {
            "type": "scatter3d", "mode": "lines", **_xyz(stalks), "hoverinfo": "skip",
            "line": {"width": 3, "color": "#b9c4cd"},
        },
        {
            "type": "scatter3d", "mode": "markers", **_xyz(p.reflector), "hoverinfo": "skip",
            "marker": {"size": 4, "color": INK, "symbol": "diamond"},
        },
    ]  # fmt: skip


def _arrows(p: SetupResiduals, residual: Floats, scale: float, colour: str) -> list[Figure]:
    """Residuals (R, 3) m, enlarged, with a dot at their tips."""
    tip = p.read_at + scale * residual
    shafts = np.full((3 * len(tip), 3), np.nan)
    shafts[0::3], shafts[1::3] = p.read_at, tip
    size = np.linalg.norm(residual, axis=1) * 1e3
    return [
        {
            "type": "scatter3d", "mode": "lines", **_xyz(shafts), "hoverinfo": "skip",
            "line": {"width": 4, "color": colour},
        },
        {
            "type": "scatter3d", "mode": "markers", **_xyz(tip), "marker": {"size": 3, "color": colour},
            "customdata": [[int(r), round(float(s), 5)] for r, s in zip(p.number, size, strict=True)],
            "hovertemplate": hover("reflector %{customdata[0]}: %{customdata[1]:.3~g} mm"),
        },
    ]  # fmt: skip


def _xyz(points: Floats) -> Figure:
    return {a: numbers(points[:, i], 5) for i, a in enumerate("xyz")}


def _menu(setups: list[SetupResiduals], per: list[int], boxes: list[Floats], scenes: int) -> Figure:
    """A list of set-ups by number; where there are several sessions, those too. A scene moves to its set-up."""
    several = len({p.session for p in setups}) > 1
    buttons = []
    for k, p in enumerate(setups):
        name = f"session {p.session + 1}, set-up {p.setup}" if several else f"set-up {p.setup}"
        shown = [i == k for i, count in enumerate(per) for _ in range(count)]
        moved = {
            f"scene{number(scene)}.{a}axis.range": numbers(boxes[k][i], 4)
            for scene in range(scenes)
            for i, a in enumerate("xyz")
        }
        label = f"{name}: {p.size * 1e3:.3f} mm"
        buttons.append({"label": label, "method": "update", "args": [{"visible": shown}, moved]})
    place = {"x": 0.0, "xanchor": "left", "y": 1.0, "yanchor": "top", "direction": "down"}
    return {"type": "dropdown", "buttons": buttons, "showactive": True, "font": {"size": 12}, **place}


def _boxes(setups: list[SetupResiduals], scale: float) -> list[Floats]:
    """(3, 2) m for every set-up: a cube about what is drawn of it; all of one size, so that lengths compare."""
    clouds = [
        np.concatenate([s.skeleton, s.read_at, s.read_at + scale * s.before, s.read_at + scale * s.after])
        for s in setups
    ]
    middle = [0.5 * (c.min(axis=0) + c.max(axis=0)) for c in clouds]
    half = 0.53 * max(float(np.ptp(c, axis=0).max()) for c in clouds)
    return [m[:, None] + np.array([-half, half]) for m in middle]


def _scene(box: Floats, across: list[float]) -> Figure:
    """Equal axes in m."""
    scene: Figure = {
        "domain": {"x": across, "y": [0.0, 0.97]}, "aspectmode": "cube",
        "camera": {"eye": {"x": 1.08, "y": -1.18, "z": 0.62}, "center": {"x": 0, "y": 0, "z": -0.1}},
    }  # fmt: skip
    for i, a in enumerate("xyz"):
        scene[f"{a}axis"] = {
            "title": {"text": f"{a}, m"}, "range": numbers(box[i], 4), "backgroundcolor": "#eef0f2",
            "showbackground": True, "gridcolor": "#ffffff", "nticks": 5, "tickfont": {"size": 11},
        }  # fmt: skip
    return scene
