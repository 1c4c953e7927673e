# Everything runs in a virtual environment in .venv; `make` alone says what there is.
PYTHON ?= python3
LEVELS ?= x86-64-v2 x86-64-v3 x86-64-v4
BIN := .venv/bin
TEST := $(BIN)/python -m pytest --dist worksteal

help:
	@echo "make tour    set up, then replay the course: tables, and figures in figures/"
	@echo "make test    set up, then run the tests"
	@echo "make processors    the tests under other processors' instructions, and 1 and 4 workers"
	@echo "make check   set up, then ruff, pyright, import-linter"
	@echo "make wheel   set up, then build dist/*.whl, with kernels compiled for $(LEVELS)"
	@echo "make docs    set up, then build the documentation in site/"
	@echo "make bench   set up with the rival solvers that install, then all benchmarks"

.venv/.user: pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --editable ".[derive]"
	@touch $@

.venv/.dev: pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --editable ".[dev]"
	@touch $@ .venv/.user

.venv/.docs: pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --editable ".[docs]"
	@touch $@ .venv/.user

tour: .venv/.user
	$(BIN)/fastdyn tour --out figures

test: .venv/.dev
	$(TEST) --numprocesses 2

processors: .venv/.dev
	for core in Prescott Haswell SkylakeX; do \
	    OPENBLAS_CORETYPE=$$core $(TEST) --numprocesses 2 || exit 1; done
	for cpu in x86-64-v2 x86-64-v3; do \
	    NUMBA_CPU_NAME=$$cpu NUMBA_CPU_FEATURES= $(TEST) --numprocesses 2 || exit 1; done
	for workers in 1 4; do $(TEST) --numprocesses $$workers || exit 1; done

check: .venv/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright
	$(BIN)/lint-imports

wheel: .venv/.user
	rm -rf build dist fastdyn/code_store/objects
	for level in $(LEVELS); do \
	    NUMBA_CPU_NAME=$$level NUMBA_CPU_FEATURES= \
	        $(BIN)/python -m fastdyn.specialise.precompile || exit 1; done
	$(BIN)/python -m pip wheel --quiet --no-deps --wheel-dir dist .
	rm -rf build fastdyn/code_store/objects
	@for level in $(LEVELS); do \
	    $(BIN)/python -m zipfile --list dist/fastdyn-*.whl | grep "objects/$$level/" > /dev/null || { \
	        echo "dist/ has no wheel with kernels for $$level: two 'make wheel' at once?"; \
	        exit 1; }; done

docs: .venv/.docs
	$(BIN)/python -m sphinx --fail-on-warning --keep-going --quiet docs site

bench: .venv/.dev
	-$(BIN)/python -m pip install --quiet --editable ".[bench]"
	-$(BIN)/python -m pip install --quiet numbalsoda  # needs a Fortran compiler
	$(BIN)/python -m bench

.PHONY: help tour test processors check wheel docs bench
