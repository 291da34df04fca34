# Two commands do all: `make validate` (the main job) and `make test`.
PYTHON ?= python3
BIN = .venv/bin
# A process uses the threads that its configuration states; libraries must not add their own.
export OMP_NUM_THREADS = 1
export OPENBLAS_NUM_THREADS = 1

.PHONY: validate test long verification lint clean

validate: .venv/installed
	$(BIN)/atomistic validate inputs/validate/quick.toml

test: .venv/installed-dev lint
	$(BIN)/python -m pytest

# The long validations: minutes to an hour.
long: .venv/installed-dev
	$(BIN)/python -m pytest -m long

# The solver beside analytic contacts: tables and figure of docs/verification.md.
verification: .venv/installed-dev
	$(BIN)/python -m tests.verification.report docs

lint: .venv/installed-dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy

.venv/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "stickiness needs Python 3.11 or later: make PYTHON=python3.12 $(MAKECMDGOALS)"; exit 2; }
	$(PYTHON) -m venv .venv

.venv/installed: pyproject.toml | .venv/bin/python
	$(BIN)/python -m pip install --quiet --editable .
	@touch $@

.venv/installed-dev: pyproject.toml | .venv/bin/python
	$(BIN)/python -m pip install --quiet --editable '.[dev]'
	@touch $@ .venv/installed

clean:
	rm -rf .venv build dist results .pytest_cache .mypy_cache .ruff_cache .hypothesis
