# Set-up and daily commands; the README has the same in plain pip lines.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
RUNS ?= runs
# Of a file's tests all run in one worker, so that what they share is made once; tests/conftest.py
# says which files come first.
TESTERS := --numprocesses logical --maxprocesses 4 --dist loadfile --no-loadscope-reorder
# A worker a core is enough: the linear algebra of small matrices only loses by threads of its own.
test: export OPENBLAS_NUM_THREADS := 1
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check \
	--constraint constraints.txt --editable

.PHONY: demo test fuzz lint bench validate planted reproduce wheel clean
.DELETE_ON_ERROR:

demo: $(VENV)/installed ## discharge silo A4: a number and pictures
	$(BIN)/silo2d run A4 --out $(RUNS)

test: $(VENV)/with-tests ## all tests but the long comparisons
	$(BIN)/python -m pytest -m "not validation" $(TESTERS)

fuzz: export FUZZ_TIMES := 20
fuzz: $(VENV)/with-tests ## the tests that draw their input, with twenty times as many examples
	$(BIN)/python -m pytest -m "hypothesis and not validation" $(TESTERS)

lint: $(VENV)/with-tests ## style, types, import order
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: $(VENV)/installed ## cost a step: the silo beside a reference kernel, the damper beside LAMMPS
	$(BIN)/python benchmarks/cost.py
	$(BIN)/python benchmarks/damper.py
	$(BIN)/python benchmarks/clusters.py

validate: $(VENV)/with-tests ## comparisons with published results (minutes)
	$(BIN)/python -m pytest -m validation

planted: $(VENV)/with-tests ## mistakes planted one at a time, and the test that catches each (ten minutes)
	$(BIN)/python tests/planted/plant.py

reproduce: $(VENV)/installed ## every published table beside ours, into docs/results (hours)
	for command in silo2d damper3d; do \
		for table in $$($(BIN)/$$command reproduce | cut -d' ' -f1); do \
			$(BIN)/$$command reproduce $$table --out $(RUNS) --write docs/results/$$command || exit 1; \
		done; \
	done

wheel: $(VENV)/installed
	$(BIN)/python -m pip wheel --no-deps --wheel-dir dist .

clean:
	rm -rf $(VENV) dist .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache

# One file says that the environment is whole; it is made anew when what it follows from changes.
# What only the tests need (other engines, readers of exports) is large and comes with them.
$(VENV)/installed: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(INSTALL) ".[pictures]"
	touch $@

$(VENV)/with-tests: $(VENV)/installed
	$(INSTALL) ".[pictures,tests]"
	touch $@
