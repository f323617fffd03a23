"""The table of docs/effects-report.md: every ailment of the plant on every arm, diagnosed from session files alone.

python -m tests.effects_report --out docs/effects-report.md        (all of it)
python -m tests.effects_report --quick                             (a part, for CI)
"""
