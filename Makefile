# Two targets do everything on a fresh machine with Python 3.11 and git: `make demo` and `make test`.
PYTHON ?= python3
VENV   ?= .venv
BIN     = $(VENV)/bin
INSTALLED = $(VENV)/.installed
OUT    ?= demo-out
BENCH_OUT ?= bench-out

OWNERS  = $(VENV)/owners
PIP_FLAGS ?=

# hundreds of processes import the same modules: compiled ones are kept, whatever the shell says
export PYTHONDONTWRITEBYTECODE =

.PHONY: help demo test quick check bench accuracy site release-notes mutants fuzz nightly owners wheel-test clean

help:            ## this list
	@grep -hE '^[a-z-]+: .*##|^[a-z-]+:  *##' $(MAKEFILE_LIST) | sed 's/:.*##/\t/'

$(INSTALLED): pyproject.toml constraints.txt
	$(PYTHON) -c 'import sys; sys.exit(0 if sys.version_info >= (3, 11) else "tactiledata needs Python 3.11 or later; found " + sys.version.split()[0] + ". Name another: make PYTHON=python3.11 ...")'
	$(PYTHON) -m venv $(VENV)
	# the pip that comes with Python takes half as long again
	$(BIN)/pip install --quiet --upgrade -c constraints.txt pip
	$(BIN)/pip install --quiet $(PIP_FLAGS) -c constraints.txt -e '.[sim,models,report,dask,site,view,s3,dev]'
	@touch $@

demo: $(INSTALLED)   ## the main job end to end on the embedded recorded world; ends with a report to open
	$(BIN)/tactiledata demo --out $(OUT)

$(OWNERS)/.installed: $(INSTALLED) tests/export/owners.txt
	rm -rf $(OWNERS)
	$(BIN)/pip install --quiet $(PIP_FLAGS) --no-deps --target $(OWNERS) -r tests/export/owners.txt
	@touch $@

owners: $(OWNERS)/.installed  ## the loaders of LeRobot and robomimic, beside the environment, for the tests of exports

# two workers share the cores: threads of each would only get in each other's way
test: $(INSTALLED) $(OWNERS)/.installed   ## every test but those of `make nightly`
	OMP_NUM_THREADS=1 TACTILE_REQUIRE_ALL=1 $(BIN)/python -m pytest -n 2 --dist worksteal -m 'not nightly'

quick: $(INSTALLED)  ## the fast tests
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 --dist worksteal -m 'not slow and not nightly'

check: $(INSTALLED)  ## formatting, lint, types
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy

bench: $(INSTALLED)  ## benchmarks of speed: ours and the alternatives side by side, and how costs grow (an hour)
	$(BIN)/python benchmarks/run_all.py --what speed --out $(BENCH_OUT)

accuracy: $(INSTALLED) ## benchmarks of accuracy: gel, calibration, naming and locating on simulated worlds (many hours)
	$(BIN)/python benchmarks/run_all.py --what accuracy --out $(BENCH_OUT)

site: $(INSTALLED)   ## the documentation as a site, in site/
	$(BIN)/mkdocs build --strict

release-notes: $(INSTALLED) ## gather the fragments of changes/ into CHANGELOG.md: make release-notes VERSION=0.2.0
	$(if $(VERSION),,$(error say which release: make release-notes VERSION=0.2.0))
	$(BIN)/towncrier build --yes --version $(VERSION)

# SAMPLE=0 takes every place; what was measured is kept in .mutants, so that a run can be stopped and taken up again
mutants: $(INSTALLED) ## the mutation score of a sample, and the changes that no fast test notices (long)
	$(BIN)/pip install --quiet -c constraints.txt -e '.[mutants]'
	OMP_NUM_THREADS=1 $(BIN)/python benchmarks/mutants.py --sample $(or $(SAMPLE),60) --seed $(or $(SEED),1)

# every night: a fault ends it with 1, and its files are in .fuzz; FUZZ_MINUTES=1 for a look
fuzz: $(INSTALLED)   ## changed bytes into every reader, for half an hour
	OMP_NUM_THREADS=1 $(BIN)/python tests/fuzz/run_fuzz.py --minutes $(or $(FUZZ_MINUTES),30)

# what a change of a solver, of a benchmark or of the naming's thresholds asks for at once
nightly: $(INSTALLED)  ## the tests that take longest: solvers compared, rates of false alarms, benchmarks; then fuzzing
	OMP_NUM_THREADS=1 TACTILE_REQUIRE_ALL=1 $(BIN)/python -m pytest -n 2 --dist worksteal -m nightly
	$(MAKE) fuzz

clean:           ## remove what make made, the virtual environment included
	rm -rf $(VENV) $(OUT) $(BENCH_OUT) build dist site .pytest_cache .mypy_cache .ruff_cache .mutants .fuzz
