# Two commands for a fresh machine: `make demo` and `make test`.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

.PHONY: help demo test check bench reproduce pictures format clean
help:
	@echo "make demo    learn, plan and project on real recordings; pictures in demo/"
	@echo "make test    lint, types and the whole test suite"
	@echo "make check   lint and types only"
	@echo "make pictures  draw the README pictures anew"
	@echo "make bench   measure everything the README claims (DATA=folder adds recordings of your own)"
	@echo "make reproduce  repeat the papers' experiments; one report in results/ (DATA=folder as above)"

$(BIN)/python:
	$(PYTHON) -m venv $(VENV)

$(VENV)/.demo: pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --editable ".[data]"
	@touch $@

$(VENV)/.dev: pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --editable ".[dev]"
	@touch $@ $(VENV)/.demo

demo: $(VENV)/.demo
	$(BIN)/skillfold demo --out demo

test: check
	$(BIN)/python -m pytest -q -n 2

check: $(VENV)/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright

bench: $(VENV)/.dev
	$(BIN)/skillfold bench $(if $(DATA),--data $(DATA)) --json bench.json

reproduce: $(VENV)/.dev
	$(BIN)/skillfold reproduce $(if $(DATA),--data $(DATA)) --out results

pictures: demo
	$(BIN)/skillfold demo keyframes --out demo
	cp demo/demo.png demo/tray.png demo/keyframes.png docs/pictures/

format: $(VENV)/.dev
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

clean:
	find src -name '*.nb[ic]' -delete
	rm -rf $(VENV) demo bench.json .pytest_cache .ruff_cache .hypothesis
