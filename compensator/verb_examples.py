"""Two examples for every verb: --help and the man page have them, and a test parses them."""

from __future__ import annotations

EXAMPLES: dict[str, tuple[str, str]] = {
    "axis-map": (
        "axis-map part.nc --cell cell.toml",
        "axis-map part.nc --cell cell.toml --png turns.png --csv turns.csv --report turns.html",
    ),
    "check": ("check cell.toml", "check cell.toml part.nc --json check.json"),
    "clamped": (
        "clamped readings.csv --robot ur10 -o stiffness.toml",
        "clamped readings.csv --robot arm.toml -o stiffness.toml --above 0.4 --json clamped.json",
    ),
    "compare": ("compare before.json after.json", "compare monday.json friday.json --json differences.json"),
    "compensate": (
        "compensate part.nc --cell cell.toml -o part.mod",
        "compensate part.nc --cell cell.toml -o part.src --report part.html --json part.json --strict",
    ),
    "completion": (
        "completion bash > ~/.local/share/bash-completion/completions/compensator",
        "completion fish > ~/.config/fish/completions/compensator.fish",
    ),
    "cutting": (
        "cutting forces.csv -o material.toml",
        "cutting powers.csv -o material.toml --json material.json",
    ),
    "datasheet": ("datasheet arm.toml -o stiffness.toml", "datasheet arm.toml -o stiffness.toml --json stiffness.json"),
    "diagnose": (
        "diagnose session.toml --model stiffness.toml",
        "diagnose day1.toml day2.toml --model stiffness.toml -o better.toml --report diagnosis.html",
    ),
    "effects": ("effects", "effects backlash"),
    "evaluate": (
        "evaluate session.toml --model stiffness.toml",
        "evaluate session.toml --model stiffness.toml --register 40 --json score.json",
    ),
    "identify": (
        "identify session.toml -o stiffness.toml",
        "identify day1.toml day2.toml -o stiffness.toml --prior datasheet.toml --report fit.html",
    ),
    "init": (
        "init",
        'init --robot kuka-kr500 --tool "0 0 250 35" --part "1500 -100 800" --cam part.nc --stiffness unknown '
        '--controller krl --cutter "flat 10 2 25" --material aluminium-6082-t6 --stock "box 0 0 -25 140 100 0"',
    ),
    "man": ("man | man -l -", "man > ~/.local/share/man/man1/compensator.1"),
    "place": (
        'place part.nc --cell cell.toml -o study.parquet --box "x=1200:1800:13,y=-400:400:9,yaw=0:90:3"',
        "place part.nc --cell cell.toml -o study.parquet --list places.csv --png places.png --best best.toml",
    ),
    "plan": (
        "plan stiffness.toml --cell cell.toml -o day1/setups.csv --program day1/drive.src",
        "plan --ballbar --cell cell.toml -o day1/circles.mod --radius 150",
    ),
    "preview": (
        "preview part.nc --cell cell.toml",
        "preview part.nc --cell cell.toml --csv deflection.csv --report part.html",
    ),
    "robots": ("robots", "robots abb-irb6600-175-255"),
    "stiffness-map": (
        "stiffness-map stiffness.toml --png map.png",
        "stiffness-map stiffness.toml --grid -20:60:10,0:80:10 --tool-xyz 0 0 250 --csv map.csv",
    ),
    "trace": (
        "trace points.csv -o trace.toml --frame base --noise 0.02",
        "trace bar.csv -o trace.toml --cell cell.toml --program run.csv --center 1500 0 900 --radius 150",
    ),
    "view": ("view cell.toml part.nc", "view cell.toml part.nc --port 8080 --no-browser"),
    "verify": (
        "verify part.mod --cell cell.toml",
        "verify part.mod --cell cell.toml --toolpath part.nc --json verdict.json",
    ),
}
