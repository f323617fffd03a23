"""The residual map: arrows at the reflectors of one set-up at a time, on the arm as it stood, before and after."""

from __future__ import annotations

import numpy as np

from compensator.report.analysis.diagnosis import Floats, Posture
from compensator.report.figures.layout import AFTER, BEFORE, FONT, INK, Figure, heading, number
from compensator.report.figures.thinning import numbers

LONGEST = 0.14  # of the size of the arm: the longest arrow but for one in twenty
ARM, POINT = "#5a646d", INK


def enlargement(postures: list[Posture]) -> float:
    """How many times arrows are longer than residuals: 1, 2 or 5 times a power of ten."""
    length = np.concatenate([np.linalg.norm(p.before, axis=1) for p in postures])
    reach = max(float(np.ptp(np.concatenate([p.skeleton for p in postures]), axis=0).max()), 1e-3)
    wanted = LONGEST * reach / max(float(np.percentile(length, 95)), 1e-9)
    power = 10.0 ** np.floor(np.log10(wanted))
    return float(power * max(f for f in (1.0, 2.0, 5.0) if f * power <= wanted * 1.000001))


def map_figure(postures: list[Posture], titles: list[str]) -> Figure:
    """One scene, or two beside each other: ``titles`` of one or both; a menu picks the set-up."""
    scale = enlargement(postures)
    boxes = _boxes(postures, scale)
    data: list[Figure] = []
    per: list[int] = []
    for at, p in enumerate(postures):
        start = len(data)
        for k in range(len(titles)):
            data += _traces(p, p.after if k else p.before, scale, k, AFTER if k else BEFORE, at == 0)
        per.append(len(data) - start)
    layout: Figure = {
        "font": FONT, "height": 560, "margin": {"l": 0, "r": 0, "t": 60, "b": 0}, "showlegend": False,
        "annotations": [], "updatemenus": [_menu(postures, per, boxes, len(titles))] if len(postures) > 1 else [],
    }  # fmt: skip
    for k, title in enumerate(titles):
        across = [k / len(titles) + 0.005, (k + 1) / len(titles) - 0.005]
        layout[f"scene{number(k)}"] = _scene(boxes[0], across)
        layout["annotations"].append(heading(title, sum(across) / 2, above=True))
    return {"data": data, "layout": layout}


def _traces(p: Posture, residual: Floats, scale: float, scene: int, colour: str, visible: bool) -> list[Figure]:
    common: Figure = {"scene": f"scene{number(scene)}", "visible": visible, "showlegend": False}
    tip = p.root + scale * residual
    shafts = np.full((3 * len(tip), 3), np.nan)
    shafts[0::3], shafts[1::3] = p.root, tip
    stalks = np.full((3 * len(p.at), 3), np.nan)
    stalks[0::3], stalks[1::3] = p.link, p.at
    size = np.linalg.norm(residual, axis=1) * 1e3
    arm: Figure = {
        "type": "scatter3d", "mode": "lines+markers", **_xyz(p.skeleton), "hoverinfo": "skip",
        "line": {"width": 8, "color": ARM}, "marker": {"size": 4, "color": ARM},
    }  # fmt: skip
    stalk: Figure = {
        "type": "scatter3d", "mode": "lines", **_xyz(stalks), "hoverinfo": "skip",
        "line": {"width": 3, "color": "#b9c4cd"},
    }  # fmt: skip
    points: Figure = {
        "type": "scatter3d", "mode": "markers", **_xyz(p.at), "hoverinfo": "skip",
        "marker": {"size": 4, "color": POINT, "symbol": "diamond"},
    }  # fmt: skip
    arrows: Figure = {
        "type": "scatter3d", "mode": "lines", **_xyz(shafts), "hoverinfo": "skip",
        "line": {"width": 4, "color": colour},
    }  # fmt: skip
    heads: Figure = {
        "type": "scatter3d", "mode": "markers", **_xyz(tip), "marker": {"size": 3, "color": colour},
        "customdata": [[int(r), round(float(s), 5)] for r, s in zip(p.reflector, size, strict=True)],
        "hovertemplate": "reflector %{customdata[0]}: %{customdata[1]:.3~g} mm<extra></extra>",
    }  # fmt: skip
    return [{**t, **common} for t in (arm, stalk, points, arrows, heads)]


def _xyz(points: Floats) -> Figure:
    return {a: numbers(points[:, i], 5) for i, a in enumerate("xyz")}


def _menu(postures: list[Posture], per: list[int], boxes: list[Floats], scenes: int) -> Figure:
    """A list of set-ups by number; where there are several sessions, those too. A scene moves to its set-up."""
    several = len({p.session for p in postures}) > 1
    buttons = []
    for k, p in enumerate(postures):
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


def _boxes(postures: list[Posture], scale: float) -> list[Floats]:
    """(3, 2) m for every set-up: a cube about what is drawn of it; all of one size, so that lengths compare."""
    clouds = [
        np.concatenate([p.skeleton, p.root, p.root + scale * p.before, p.root + scale * p.after]) for p in postures
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
