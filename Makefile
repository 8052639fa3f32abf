# Needs only make and a Python >= 3.11 with venv; everything else goes into .venv.
.DEFAULT_GOAL := help
.PHONY: help env env-test byte-code run test test-all lint format docs bench structure size audit lock release-check

bin := .venv/bin

# Recordings of other laboratories are never part of this project; where a copy lies beside it, use it.
ifeq ($(origin HANNES_MEASURED),undefined)
ifneq ($(wildcard ../shared/measured/.),)
export HANNES_MEASURED := $(realpath ../shared/measured)
endif
endif

help:  ## this list
	@sed -n 's/^\([a-z-]*\):.*## /make \1	/p' Makefile

env:  ## the environment in .venv, up to date: what hannes itself needs
	@sh tools/bootstrap.sh

env-test:  ## the same with what its tests and benchmarks need
	@sh tools/bootstrap.sh test

run: env  ## a first diagnosis, the paper's experiments, recognition: pages in results/
	$(bin)/python -m tools.first_run

# pip compiles nothing (tools/bootstrap.sh), and a machine may forbid Python to keep what it compiles
# (PYTHONDONTWRITEBYTECODE): else each of the tests' hundreds of processes compiles these anew.
imported := numpy scipy numba llvmlite h5py sklearn joblib narwhals pandas pyarrow dateutil matplotlib \
    mpl_toolkits PIL fontTools pyparsing pint flexparser jinja2 yaml tqdm rich pygments serial cobs \
    dask toolz tlz psutil sortedcontainers packaging hypothesis pytest _pytest

byte-code: env-test
	@cd .venv/lib/python3*/site-packages && ../../../bin/python -m compileall -q -j 0 -x /tests/ $(imported)
	@$(bin)/python -m compileall -q -j 0 hannes benchmarks

test: lint byte-code  ## format, lint, types, direction of imports, the quick tests on all cores
	$(bin)/python -m pytest -n auto --dist loadfile --no-loadscope-reorder -m "not slow"

test-all: lint byte-code  ## the same with the slow tests, for a release
	$(bin)/python -m pytest -n auto --dist loadfile --no-loadscope-reorder

lint: env-test  ## all of `make test` but the tests
	$(bin)/ruff format --check
	$(bin)/ruff check
	$(bin)/mypy
	$(bin)/lint-imports --no-logo --no-cache

format: env-test  ## put the code into the project's format
	$(bin)/ruff format
	$(bin)/ruff check --fix

docs: env  ## pictures of the README and generated pages of docs/reference anew
	$(bin)/hannes reproduce --out results/reproduce
	cp results/reproduce/figures/fig8.svg docs/grasp.svg
	$(bin)/hannes hand --schematic > docs/hand.svg
	$(bin)/hannes diagnose examples/closures/campaign.toml --out results/hidden-slack
	$(bin)/python -m tools.diagnosis_picture results/hidden-slack/report.html docs/diagnosis.svg
	$(bin)/python -m tools.reference

bench: env-test  ## speed and accuracy beside peers, batches, start: benchmarks/README.md
	$(bin)/python -m benchmarks

structure: env-test  ## how the packages are built, beside the limits they keep
	$(bin)/python -m tools.structure

size: env  ## size and time of an install of hannes without extras, downloads included
	$(bin)/python -m tools.install_size

audit: env-test  ## licences of all that is installed; known faults of the locked versions, where a server answers
	$(bin)/python -m tools.licences
	$(bin)/python -m tools.advisories

release-check: env-test  ## builds, installs and runs the README's lines from an empty folder, then a fresh clone
	$(bin)/python -m tools.release_check

# The second lock holds the first at the same versions: `make test` adds to what `make run` installed.
compiled := .venv/lock/bin/uv pip compile pyproject.toml --universal --python-version 3.11 \
    --fork-strategy fewest --generate-hashes --no-emit-index-url --quiet --custom-compile-command "make lock"

lock: env  ## choose package versions anew: requirements.lock, requirements-test.lock
	$(bin)/python -m venv .venv/lock
	.venv/lock/bin/pip install --quiet uv
	$(compiled) --upgrade --extra install --output-file requirements.lock
	$(compiled) --upgrade --extra install --extra test --extra dev --constraint requirements.lock \
	    --output-file requirements-test.lock
