# Each target sets up .venv first if it is missing or older than what it is made from.
.DEFAULT_GOAL := help
SHELL := bash
export PYTHON
# Bytecode is kept: tests and campaigns start hundreds of processes, and each would compile the package anew.
export PYTHONDONTWRITEBYTECODE :=
# The stamp knows the folder: an environment that was moved with the project no longer works.
HERE := $(shell pwd | cksum | cut -d ' ' -f 1)
USE := .venv/.use-$(HERE)
ENVIRONMENT := .venv/.ready-$(HERE)
SOURCES := packages/tierod/pyproject.toml packages/tierod-lab/pyproject.toml constraints.txt scripts/setup.sh

.PHONY: help demo test bench study attack lint docs clean

help:  ## say what there is
	@grep -hE '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed -E 's/^([a-z]+):.*## (.*)/make \1\t\2/' | expand -t 14

$(USE): $(SOURCES)
	@bash scripts/setup.sh use && touch $@

$(ENVIRONMENT): $(SOURCES)
	@bash scripts/setup.sh dev && touch $(USE) $@

demo: $(USE)  ## diagnose a drive whose friction rises, print verdict and report
	@.venv/bin/tierod demo

test: $(ENVIRONMENT)  ## run all tests
	.venv/bin/python -m pytest -n 2 --dist worksteal -m "not slow"

bench: $(ENVIRONMENT)  ## measure the speed, print the table, write bench.json
	.venv/bin/python -m benchmarks

study: $(ENVIRONMENT)  ## measure what papers and tierod claim, claim by claim, into out/ (minutes)
	.venv/bin/tierod study --output out
	.venv/bin/python -m pytest -m slow

# COUNT files of each kind, SEED of all chance, no further file after SECONDS; another seed tries other files.
attack: COUNT ?= 2000
attack: SECONDS ?= 3600
attack: SEED ?= 20261123
attack: SHARE ?= 1
attack: $(ENVIRONMENT)  ## open thousands of damaged files, kill what writes; figures in attack.json (an hour)
	PYTHONPATH=tests .venv/bin/python -m attack all --count $(COUNT) --seconds $(SECONDS) --seed $(SEED) --share $(SHARE)

lint: $(ENVIRONMENT)  ## check style and types
	.venv/bin/ruff check .
	.venv/bin/ruff format --check .
	.venv/bin/mypy

docs: $(ENVIRONMENT)  ## write the generated pages of docs/ anew, and build the site into site/
	.venv/bin/python scripts/docs.py
	.venv/bin/python -m benchmarks.readme
	@.venv/bin/python -c 'import material, mkdocstrings' 2>/dev/null || \
		.venv/bin/python -m pip install -qq --disable-pip-version-check -c constraints.txt mkdocs-material 'mkdocstrings[python]'
	NO_MKDOCS_2_WARNING=1 .venv/bin/mkdocs build --strict --quiet

clean:  ## remove .venv and what tools left behind
	rm -rf .venv .pytest_cache .mypy_cache .ruff_cache .hypothesis build dist out site packages/*/build packages/*/src/*.egg-info bench.json attack.json .coverage
	find packages tests benchmarks scripts -name __pycache__ -prune -exec rm -rf {} +
