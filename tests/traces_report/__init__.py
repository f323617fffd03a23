"""The tables of docs/traces-report.md: traces of a plant with one undeclared cause or more, diagnosed from files alone.

python -m tests.traces_report --keep FOLDER --out docs/traces-report.md     (goes on where it was stopped)
"""
