# Everything runs in virtual environments, .venv and .venvs/*; `make` alone says what there is.
PYTHON ?= python3
LEVELS ?= $(if $(filter aarch64,$(shell uname -m)),generic,x86-64-v2 x86-64-v3 x86-64-v4)
PLATFORM ?= manylinux_2_17_$(shell uname -m)
TESTS ?=
HUNTS ?=
SCRIPTS := $(if $(filter Windows_NT,$(OS)),Scripts,bin)
BIN := .venv/$(SCRIPTS)
TEST := $(BIN)/python -m pytest --dist worksteal
WITH_HUNTS := $(TEST) -m "not browser"
WITH := -$(notdir $(PYTHON))
PIP_WITH_GROUPS := "pip>=25.1"
# The kernels call nothing but what any libm has; Numba's wheels are for this platform or a later.
BUILD_WHEEL ?= $(BIN)/python -m pip wheel

help:
	@echo "make tour    set up, then replay the course: tables, and figures in figures/"
	@echo "make test    set up, then run the tests"
	@echo "make fast    the quickest of them, known from 'make test': less than a minute"
	@echo "make hunt    the tests that 'make test' leaves to .ci/run"
	@echo "make processors    the tests under other processors' instructions, and 1 and 4 workers"
	@echo "make oldest newest    the tests with the lowest and the newest versions of all dependencies,"
	@echo "             in an environment for each PYTHON=; TESTS= chooses files"
	@echo "make check   set up, then ruff, pyright, import-linter"
	@echo "make wheel   set up, then build dist/*.whl, with kernels compiled for $(LEVELS)"
	@echo "make release set up, then build dist/*: sources, wheel, wheel with kernels; check and try each"
	@echo "make docs    set up, then build the documentation in site/"
	@echo "make notebooks    set up, then execute the notebooks"
	@echo "make bench   set up with the rival solvers that install, then all benchmarks, or those of ONLY=;"
	@echo "             ratios to the last run on this machine"
	@echo "make tables  make bench, then all tables and diagrams of README and docs/"

.venv/.pip:
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --upgrade $(PIP_WITH_GROUPS)
	@touch $@

.venv/.user: pyproject.toml .venv/.pip
	$(BIN)/python -m pip install --quiet --editable ".[derive]"
	@touch $@

.venv/.dev: pyproject.toml .venv/.pip
	$(BIN)/python -m pip install --quiet --group dev --editable ".[cluster,derive,explore,jax,video]"
	@touch $@ .venv/.user

.venv/.docs: pyproject.toml .venv/.pip
	$(BIN)/python -m pip install --quiet --group docs --editable ".[derive,jax]"
	@touch $@ .venv/.user

tour: .venv/.user
	$(BIN)/fastdyn tour --out figures

test: .venv/.dev
	$(TEST) --numprocesses 2

fast: .venv/.dev
	$(TEST) --numprocesses 2 --fast

hunt: .venv/.dev
	$(TEST) --numprocesses 2 -m hunt $(HUNTS)

processors: .venv/.dev
	for core in Prescott Haswell SkylakeX; do \
	    OPENBLAS_CORETYPE=$$core $(WITH_HUNTS) --numprocesses 2 || exit 1; done
	for cpu in x86-64-v2 x86-64-v3; do \
	    NUMBA_CPU_NAME=$$cpu NUMBA_CPU_FEATURES= $(WITH_HUNTS) --numprocesses 2 || exit 1; done
	for workers in 1 4; do $(WITH_HUNTS) --numprocesses $$workers || exit 1; done

.venvs/oldest$(WITH).txt: pyproject.toml .ci/oldest.py
	@mkdir -p .venvs
	$(PYTHON) .ci/oldest.py > $@

.venvs/newest$(WITH).txt:
	@mkdir -p .venvs
	@touch $@

oldest newest: %: .venvs/%$(WITH).txt
	$(PYTHON) -m venv .venvs/$@$(WITH)
	.venvs/$@$(WITH)/$(SCRIPTS)/python -m pip install --quiet --upgrade $(PIP_WITH_GROUPS)
	.venvs/$@$(WITH)/$(SCRIPTS)/python -m pip install --quiet --upgrade --upgrade-strategy eager \
	    --group test --editable ".[cluster,derive,explore,jax,video]" --constraint $<
	.venvs/$@$(WITH)/$(SCRIPTS)/python -m pip list
	.venvs/$@$(WITH)/$(SCRIPTS)/python -m pytest --dist worksteal -m "not browser" \
	    --numprocesses 2 $(TESTS)

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
	$(BUILD_WHEEL) --quiet --no-deps --wheel-dir dist \
	    --config-settings=--build-option=--plat-name=$(PLATFORM) .
	rm -rf build fastdyn/code_store/objects
	@for level in $(LEVELS); do \
	    $(BIN)/python -m zipfile --list dist/fastdyn-*.whl | grep "objects/$$level/" > /dev/null || { \
	        echo "dist/ has no wheel with kernels for $$level: two 'make wheel' at once?"; \
	        exit 1; }; done

.venvs/release/.made: pyproject.toml
	$(PYTHON) -m venv .venvs/release
	.venvs/release/$(SCRIPTS)/python -m pip install --quiet --upgrade $(PIP_WITH_GROUPS)
	.venvs/release/$(SCRIPTS)/python -m pip install --quiet --group release
	@touch $@

release: .venvs/release/.made
	$(MAKE) wheel BUILD_WHEEL=".venvs/release/$(SCRIPTS)/python -m pip wheel --no-build-isolation"
	.venvs/release/$(SCRIPTS)/python -m build --no-isolation --outdir dist .
	.venvs/release/$(SCRIPTS)/python -m twine check --strict dist/*
	$(PYTHON) .ci/check_release.py dist/*

docs: .venv/.docs
	$(BIN)/python -m sphinx --jobs 2 --fail-on-warning --keep-going --quiet docs site

notebooks: .venv/.docs
	$(BIN)/python .ci/notebooks.py | xargs -n 1 -P 2 $(BIN)/jupyter execute

bench: .venv/.dev
	-$(BIN)/python -m pip install --quiet --group bench
	-$(BIN)/python -m pip install --quiet numbalsoda  # needs a Fortran compiler
	$(BIN)/python -m bench $(if $(ONLY),--only $(ONLY))

tables: bench
	$(BIN)/python -m bench.report

.DELETE_ON_ERROR:
.PHONY: help tour test fast hunt oldest newest processors check wheel release docs notebooks bench tables
