# make demo   set up and run the main job on the example
# make test   set up and run everything that guards main
# make docs   the site, with search: out/site/index.html
# make bench  ratios of speed (docs/performance.md)
# make reference  the generated pages of docs/, after a change of keys, functions or classes
# make effects-report  diagnosis of every effect on three arms (docs/effects-report.md; over an hour on two cores)
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
# small matrices: more BLAS threads only wait for each other
export OPENBLAS_NUM_THREADS = 1
PIP    := $(BIN)/python -m pip --disable-pip-version-check install --quiet -c constraints.txt

.PHONY: demo test docs bench effects-report effects-quick pictures reference wheel-check clean

demo: $(VENV)/.run
	mkdir -p out
	$(BIN)/compensator compensate examples/wave.nc --cell examples/cell.toml -o out/wave.mod \
	    --report out/wave.html --json out/wave.json
	@$(BIN)/python examples/show.py out/wave.json

test: $(VENV)/.test
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/python -m pytest -n 2 --dist worksteal

docs: $(VENV)/.test
	$(BIN)/python -m sphinx -q -W --keep-going -b html docs out/site
	@echo "the site: out/site/index.html"

bench: $(VENV)/.test
	$(BIN)/python -m benchmarks

effects-report: $(VENV)/.test
	$(BIN)/python -m tests.effects_report --out docs/effects-report.md

effects-quick: $(VENV)/.test
	@$(BIN)/python -m tests.effects_report --quick

pictures: $(VENV)/.test
	$(BIN)/python -m docs.make_pictures
	$(BIN)/python -m docs.make_circle_picture
	$(BIN)/python -m docs.make_measuring_picture
	$(BIN)/python -m docs.make_trace_pictures
	$(BIN)/python -m docs.make_cut_picture
	$(BIN)/python -m docs.make_frames_picture

reference: $(VENV)/.test
	$(BIN)/python -m docs.make_glossary
	$(BIN)/python -m docs.make_keys
	$(BIN)/python -m docs.make_json_keys
	$(BIN)/python -m docs.make_functions

wheel-check: $(VENV)/.test
	rm -rf build dist out/wheel
	$(BIN)/python -m build >/dev/null
	$(PYTHON) -m venv out/wheel
	out/wheel/bin/python -m pip --disable-pip-version-check install --quiet -c constraints.txt dist/*.whl
	cp examples/wave.nc examples/wave-stock.obj examples/cell.toml examples/stiffness.toml out/wheel/
	cd out/wheel && bin/compensator robots && bin/compensator compensate wave.nc --cell cell.toml -o wave.src \
	    --json wave.json && bin/compensator preview wave.nc --cell cell.toml --csv wave.csv && ls -l wave.*

$(VENV)/bin/python:
	$(PYTHON) -m venv $(VENV)

$(VENV)/.run: pyproject.toml constraints.txt | $(VENV)/bin/python
	$(PIP) -e .
	touch $@

$(VENV)/.test: pyproject.toml constraints.txt | $(VENV)/bin/python
	$(PIP) -e '.[test,example]'
	touch $@ $(VENV)/.run

clean:
	rm -rf $(VENV) out build dist *.egg-info
