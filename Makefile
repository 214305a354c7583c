# make run · make test · make lint · make bench; each prepares its own environment in .venv first.
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin

.PHONY: run test lint bench picture clean
.DELETE_ON_ERROR:

run: $(VENV)/.installed
	$(BIN)/splinescope $(ARGS)

test: $(VENV)/.browser
	$(BIN)/pytest $(ARGS)

lint: $(VENV)/.installed-dev
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/pyright

bench: $(VENV)/.browser
	$(BIN)/python tests/bench/run_all.py $(ARGS)

picture: $(VENV)/.browser
	PYTHONPATH=tests $(BIN)/python docs/screenshot.py

clean:
	rm -rf $(VENV) build dist artefacts bench.json .pytest_cache .ruff_cache .hypothesis

# Debian keeps ensurepip in a package of its own: without it, the system's pip fills the environment from outside.
$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "SplineScope needs Python 3.11 or later; choose one with: make PYTHON=python3.12 …" >&2; exit 1; }
	@echo "Creating $(VENV) …"
	@$(PYTHON) -m venv $(VENV) >/dev/null 2>&1 || { \
	  rm -rf $(VENV); \
	  $(PYTHON) -m venv --without-pip $(VENV) && $(PYTHON) -m pip --quiet --python $(VENV)/bin/python install pip; } || { \
	  rm -rf $(VENV); \
	  echo "No environment could be made: install python3-venv or python3-pip and try again." >&2; exit 1; }

$(VENV)/.installed: pyproject.toml | $(BIN)/python
	@echo "Installing SplineScope and what it needs (once, a few minutes) …"
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable .
	@echo "Compiling the inner loops for this machine (once, about a minute) …"
	@$(BIN)/splinescope run office --out $(VENV)/first_run >/dev/null 2>&1 || true
	@touch $@

$(VENV)/.installed-dev: pyproject.toml | $(BIN)/python
	@echo "Installing what tests and checks need (once, a few minutes) …"
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	@touch $@ $(VENV)/.installed

$(VENV)/.browser: tests/chromium.py $(VENV)/.installed-dev
	$(BIN)/python tests/chromium.py
	@touch $@
