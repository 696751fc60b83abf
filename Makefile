# Set-up and daily commands; the README has the same in plain pip lines.
PYTHON ?= python3
PYTHONS ?= python3.11 python3.12 python3.13
VENV := .venv
CONSTRAINTS := constraints.txt
BIN := $(VENV)/bin
RUNS ?= runs
# Of a file's tests all run in one worker, so that what they share is made once; tests/conftest.py
# says which files come first.
TESTERS := --numprocesses logical --maxprocesses 4 --dist loadfile --no-loadscope-reorder
# A worker a core is enough: the linear algebra of small matrices only loses by threads of its own.
test: export OPENBLAS_NUM_THREADS := 1
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check \
	--constraint $(CONSTRAINTS) --editable

.PHONY: demo test test-oldest test-pythons test-plain browse fuzz fuzz-brief own-silos own-dampers low-drops estimates lint bench bench-check docs \
	verified commands pictures validate planted \
	reproduce clogging wheel clean
.DELETE_ON_ERROR:

demo: $(VENV)/installed ## discharge silo A4: a number, pictures, and a page that plays it
	$(BIN)/silo2d run A4 --page --out $(RUNS)

test: $(VENV)/with-tests ## all tests but the long comparisons and those in a browser
	$(BIN)/python -m pytest -m "not validation and not browser and not docs" $(TESTERS)

test-oldest: ## the same with the oldest versions of what pyproject.toml asks for
	$(MAKE) test VENV=.venv-oldest CONSTRAINTS=constraints-oldest.txt

test-pythons: ## the same with each of PYTHONS
	for python in $(PYTHONS); do \
		$(MAKE) test PYTHON=$$python VENV=.venv-$$(basename $$python) || exit 1; \
	done

test-plain: export NUMBA_CPU_NAME := generic
test-plain: export NUMBA_CPU_FEATURES :=
test-plain: test ## the same with kernels for a plain processor, which round differently

fuzz: export FUZZ_TIMES := 20
fuzz: $(VENV)/with-tests ## twenty thousand wrong inputs, a hundred kills, full disks; drawn tests (an hour)
	$(BIN)/python tests/fuzz/campaign.py --write docs/results/fuzz.txt
	$(BIN)/python tests/fuzz/kills.py --write docs/results/kills.txt
	$(BIN)/python -m pytest -m "hypothesis and not validation" $(TESTERS)

fuzz-brief: $(VENV)/with-tests ## a part of it (five minutes at most)
	$(BIN)/python tests/fuzz/campaign.py --times 0.05 --minutes 3
	$(BIN)/python tests/fuzz/kills.py --kills 4

own-silos: $(VENV)/with-tests ## two hundred silos as strangers would describe them (an hour or two)
	$(BIN)/python tests/fuzz/own_silos.py --write docs/results/own-silos.csv

own-dampers: $(VENV)/with-tests ## forty dampers as strangers would describe them (ten minutes)
	$(BIN)/python tests/fuzz/own_dampers.py --write docs/results/own-dampers.csv

low-drops: $(VENV)/with-tests ## the paper's drop test: 900 films of two renderers (an hour)
	$(BIN)/python benchmarks/low_drops.py docs/results/calibration

estimates: $(VENV)/with-tests ## the time left that runs state, compared with what they take (ten minutes)
	$(BIN)/python tests/fuzz/estimates.py --write docs/results/estimates.csv

lint: $(VENV)/with-tests ## style, types, import order
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

docs: $(VENV)/with-docs ## the documentation as a site, build/docs/index.html; its first commands run (five minutes)
	$(BIN)/sphinx-build --fail-on-warning --keep-going --quiet -b html docs build/docs
	$(BIN)/python -m pytest -m docs tests/docs

verified: $(VENV)/with-tests ## the tests, and how far what they compare is apart: pages docs/verification (as long as make test)
	PYTHONPATH=tests/helpers $(BIN)/python -m pytest -m "not validation and not browser and not docs" $(TESTERS) \
		-p measured --measured docs/results/verification.csv
	$(BIN)/python docs/generate.py

commands: $(VENV)/with-tests ## every command of the pages, run once (half an hour): docs/results/commands.csv
	$(BIN)/python tests/docs/every_command.py --write docs/results/commands.csv

pictures: $(VENV)/with-tests ## the pictures of the pages, each by its commands (docs/pictures/made.toml; ten minutes)
	$(BIN)/python docs/picture.py

bench: $(VENV)/with-tests ## cost of each scene, here and in other engines: docs/results/bench.json (half an hour, nothing else running)
	$(BIN)/python -m benchmarks.speed --write docs/results/bench.json
	$(BIN)/python docs/generate.py

bench-check: $(VENV)/with-tests ## the same, compared: fails where a ratio is more than 10 % above the one that is kept
	$(BIN)/python -m benchmarks.speed --check docs/results/bench.json

browse: $(VENV)/with-tests ## pages in Chromium, where it is installed (Debian: apt-get install chromium)
	$(BIN)/python -m pytest -m browser tests/browser

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

# Flat silo of the paper's width, filled as high as it is wide. Beds of squares and hexagons end in
# ratholes before their time: more seeds make up for it. Discs take the step that the others
# choose (their energy hardly closes where nothing flows, and the chosen step would be a quarter).
clogging: $(VENV)/installed ## clogging as statistics: six shapes, 1,000 avalanches each, and A to D (7 to 14 h)
	for shapes in "wood19 --seeds 5" "triangle --seeds 5" "square --seeds 10" "pentagon --seeds 5" \
			"hexagon --seeds 6" "disc --seeds 5 --time-step 5us"; do \
		$(BIN)/silo2d clog D3 --out $(RUNS) --fill-level "300 mm" --shapes $$shapes --outlets "45 mm,50 mm,55 mm,60 mm,70 mm" \
			--avalanches 40 --largest 1000 --write docs/results/silo2d/clogging || exit 1; \
	done
	for silo in A3 B3 C3 D3; do \
		$(BIN)/silo2d clog $$silo --out $(RUNS) --outlets "60 mm,70 mm,80 mm,100 mm,120 mm" --seeds 5 --avalanches 10 \
			--write docs/results/silo2d/clogging-threshold || exit 1; \
	done

wheel: $(VENV)/installed
	$(BIN)/python -m pip wheel --no-deps --wheel-dir dist .

clean:
	rm -rf .venv .venv-* dist build docs/gallery .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache

# One file says that the environment is whole; it is made anew when what it follows from changes.
# What only the tests need (other engines, readers of exports) is large and comes with them.
$(VENV)/installed: pyproject.toml $(CONSTRAINTS)
	$(PYTHON) -m venv $(VENV)
	$(INSTALL) ".[pictures]"
	touch $@

$(VENV)/with-tests: $(VENV)/installed
	$(INSTALL) ".[pictures,tests]"
	touch $@

$(VENV)/with-docs: $(VENV)/with-tests
	$(INSTALL) ".[pictures,tests,docs]"
	touch $@
