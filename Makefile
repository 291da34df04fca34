# Two commands do all: `make validate` (the main job) and `make test`.
PYTHON ?= python3
BIN = .venv/bin
# A process uses the threads that its configuration states; libraries must not add their own.
export OMP_NUM_THREADS = 1
export OPENBLAS_NUM_THREADS = 1

.PHONY: validate test long verification kappa stickiness bench lint clean

validate: .venv/installed
	$(BIN)/atomistic validate inputs/validate/quick.toml

# On all cores, at most 8.
test: .venv/installed-dev lint
	$(BIN)/python -m pytest --numprocesses auto --maxprocesses 8 --dist worksteal

# The long validations: minutes to an hour.
long: .venv/installed-dev
	$(BIN)/python -m pytest -m long

# The solver beside analytic contacts: tables and figure of docs/verification.md.
verification: .venv/installed-dev
	$(BIN)/python -m tests.verification.report docs

# Studies of many systems; each goes on from where it was stopped.  WORKERS systems at once.
WORKERS = 2
# The paper's system at 1 % area on 4096² points, 1.5 GiB for each worker: docs/kappa.md.
kappa: .venv/installed-dev
	$(BIN)/python -m tests.studies.kappa --workers 1 --threads $(WORKERS)
# Measured and predicted stickiness of 24 surfaces: docs/stickiness.md.
stickiness: .venv/installed-dev
	$(BIN)/python -m tests.studies.stickiness --workers $(WORKERS)

# Counts, times and memory, beside those of the peers, into docs/benchmarks.md: at most MINUTES, one core; goes on from
# where it was stopped.  SIZES="512 1024": these grids only; 8192 on request.  TABLES="work iteration adhesive hard_wall".
SIZES = 512 1024 2048 4096
TABLES = work iteration adhesive hard_wall
# Surface atoms a side of the equilibria of atoms; 128 on request.
ATOMS = 32 64
MINUTES = 20
bench: .venv-bench/installed
	.venv-bench/bin/python -m tests.benchmarks.run --sizes $(SIZES) --tables $(TABLES) --atoms $(ATOMS) --minutes $(MINUTES)

lint: .venv/installed-dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy

.venv/bin/python .venv-bench/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "stickiness needs Python 3.11 or later: make PYTHON=python3.12 $(MAKECMDGOALS)"; exit 2; }
	$(PYTHON) -m venv $(@:/bin/python=)

.venv/installed: pyproject.toml | .venv/bin/python
	$(BIN)/python -m pip install --quiet --editable .
	@touch $@

.venv/installed-dev: pyproject.toml | .venv/bin/python
	$(BIN)/python -m pip install --quiet --editable '.[dev]'
	@touch $@ .venv/installed

# A peer that cannot be installed here is skipped, and its rows say so.
.venv-bench/installed: pyproject.toml | .venv-bench/bin/python
	.venv-bench/bin/python -m pip install --quiet --editable .
	@for extra in bench-adhesion bench-tamaas; do \
	  .venv-bench/bin/python -m pip install --quiet --editable ".[$$extra]" || echo "skipped: the peer of $$extra"; \
	done
	@touch $@

clean:
	rm -rf .venv .venv-bench build dist results .pytest_cache .mypy_cache .ruff_cache .hypothesis
