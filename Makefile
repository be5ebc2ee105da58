# make demo   creates .venv, installs, flies scene 42
# make test   the same environment with the test tools, then every test
# make check  lint, types, import rules, unused dependencies

VENV := .venv
BIN := $(VENV)/bin
# The first interpreter on the path that is supported; PYTHON=... names another.
PYTHON ?= $(shell for p in python3.12 python3.11 python3 python; do \
	$$p -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 12))' 2>/dev/null && echo $$p && break; done)
WORKERS ?= 2

.PHONY: demo test check clean

$(VENV)/bin/python:
	@test -n "$(PYTHON)" || { echo "AeroScene needs Python 3.11 or 3.12 on the path; or name one: make PYTHON=/path/to/python3.12" >&2; exit 2; }
	$(PYTHON) -m venv $(VENV)

# Installing also compiles every kernel once, so that the first flight starts at once.
$(VENV)/.installed: pyproject.toml | $(VENV)/bin/python
	@echo "Installing into $(VENV), about a minute"
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable .
	$(BIN)/aeroscene compile
	@touch $@

$(VENV)/.installed-dev: pyproject.toml $(VENV)/.installed
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	# MAVProxy asks for VTK and a second OpenCV, for maps and video that its console does not use.
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps 'MAVProxy>=1.8.75,<2'
	@touch $@

demo: $(VENV)/.installed
	$(BIN)/aeroscene-sitl --scene 42 --demo --speed max --record recordings/scene-42.rrd

test: $(VENV)/.installed-dev
	$(BIN)/python -m pytest --numprocesses $(WORKERS) --dist worksteal

check: $(VENV)/.installed-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright
	$(BIN)/lint-imports
	$(BIN)/deptry .

clean:
	rm -rf $(VENV) recordings .pytest_cache .ruff_cache .hypothesis build dist
