# Everything runs in a virtual environment in .venv; `make` alone says what there is.
PYTHON ?= python3
BIN := .venv/bin

help:
	@echo "make tour    set up, then replay the course: tables, and figures in figures/"
	@echo "make test    set up, then run the tests"
	@echo "make check   set up, then ruff, pyright, import-linter"
	@echo "make bench   set up with the rival solvers that install, then all benchmarks"

.venv/.user: pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --editable .
	@touch $@

.venv/.dev: pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --editable ".[dev]"
	@touch $@ .venv/.user

tour: .venv/.user
	$(BIN)/fastdyn tour --out figures

test: .venv/.dev
	$(BIN)/python -m pytest --numprocesses 2 --dist loadgroup

check: .venv/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright
	$(BIN)/lint-imports

bench: .venv/.dev
	-$(BIN)/python -m pip install --quiet --editable ".[bench]"
	-$(BIN)/python -m pip install --quiet numbalsoda  # needs a Fortran compiler
	$(BIN)/python -m bench

.PHONY: help tour test check bench
