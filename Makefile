# Needs only make and a Python >= 3.11 with venv; everything else goes into .venv.
.DEFAULT_GOAL := help
.PHONY: help env run test lint format docs bench lock

bin := .venv/bin

# Recordings of other laboratories are never part of this project; where a copy lies beside it, use it.
ifeq ($(origin HANNES_MEASURED),undefined)
ifneq ($(wildcard ../shared/measured/.),)
export HANNES_MEASURED := $(realpath ../shared/measured)
endif
endif

help:  ## this list
	@sed -n 's/^\([a-z]*\):.*## /make \1	/p' Makefile

env:  ## the environment in .venv, up to date
	@sh tools/bootstrap.sh

run: env  ## the paper's experiments and a first diagnosis: pages in results/
	$(bin)/python -m benchmarks.truth.closures --out results/closures --slack "3 mm" --runs 6 --seed 1
	$(bin)/hannes diagnose results/closures/campaign.toml --out results/hidden-slack
	$(bin)/python -m benchmarks.truth.closures --out results/taut-closures --slack none --runs 6 --seed 1
	$(bin)/hannes diagnose results/taut-closures/campaign.toml --out results/no-slack
	$(bin)/python -m benchmarks.truth.objects --out results/ten-objects --grasps 10 --seed 1
	$(bin)/hannes dataset large --out results/large.h5
	$(bin)/hannes train results/large.h5 --out results/large-model.h5
	$(bin)/hannes evaluate results/large-model.h5 results/ten-objects/evaluation.toml --out results/rigid-or-soft \
	    --learning-curve results/large.h5
	$(bin)/hannes reproduce --out results/reproduce --slack results/hidden-slack --taut results/no-slack \
	    --recognition results/rigid-or-soft

test: lint  ## format, lint, types, direction of imports, tests on all cores
	$(bin)/python -m pytest -n auto --dist loadfile --no-loadscope-reorder

lint: env  ## all of `make test` but the tests
	$(bin)/ruff format --check
	$(bin)/ruff check
	$(bin)/mypy
	$(bin)/lint-imports --no-logo --no-cache

format: env  ## put the code into the project's format
	$(bin)/ruff format
	$(bin)/ruff check --fix

docs: env  ## the README's picture anew: figure 8 of `hannes reproduce`
	$(bin)/hannes reproduce --out results/reproduce
	cp results/reproduce/figures/fig8.svg docs/grasp.svg

bench: env  ## speed and accuracy beside peers, batches, start: benchmarks/README.md
	$(bin)/python -m benchmarks

lock: env  ## choose package versions anew: requirements.lock
	$(bin)/python -m pip install --quiet uv
	$(bin)/uv pip compile pyproject.toml --universal --python-version 3.11 --fork-strategy fewest \
	    --all-extras --generate-hashes --upgrade --no-emit-index-url --quiet \
	    --custom-compile-command "make lock" --output-file requirements.lock
