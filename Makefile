# The commands of the README. They use the active virtual environment, or else make .venv with PYTHON.
VENV := $(if $(VIRTUAL_ENV),$(VIRTUAL_ENV),$(CURDIR)/.venv)
PYTHON := $(firstword $(wildcard $(VENV)/bin/python) python3)
RUN := $(VENV)/bin
ifneq ($(words $(CURDIR) $(VENV)),2)
$(error make cannot work in a folder with spaces in its path: $(CURDIR))
endif

# Without compiled modules every process that a test starts would compile hundreds.
unexport PYTHONDONTWRITEBYTECODE
# A sourced ROS installation must not mix with ROS 2 from PyPI.
unexport AMENT_PREFIX_PATH CMAKE_PREFIX_PATH COLCON_PREFIX_PATH PYTHONPATH
ifdef ROS_DISTRO
unexport LD_LIBRARY_PATH
endif

.NOTPARALLEL: # two targets must not install into one environment at once
.PHONY: help setup demo test test-all test-remaining lint docs colcon clean

help: ## say what there is
	@sed -n 's/^\([a-z-]*\):[^#]*## /  make \1\t/p' Makefile

setup: ## install ROS 2 from PyPI, the interfaces and this package
	@$(PYTHON) tools/environment.py $(VENV) run

demo: setup ## play the recorded trajectory into the node, show and plot what comes out
	$(RUN)/python -m hybrid_dynamics_ros.demo $(ARGS)

test: ## install, lint, build the pages and run all tests, whole sets by a sample
	@$(PYTHON) tools/checks.py $(VENV) test $(ARGS)

test-all: ## the same with whole sets: all robots, long random searches, floods
	@$(PYTHON) tools/checks.py $(VENV) all $(ARGS)

test-remaining: # what .ci/run does after make test
	@$(PYTHON) tools/checks.py $(VENV) remaining

lint: ## ruff, mypy and import-linter
	@$(PYTHON) tools/checks.py $(VENV) lint

docs: ## build the pages of docs/, build/docs/index.html
	@$(PYTHON) tools/checks.py $(VENV) docs
	@echo "built: build/docs/index.html"

colcon: ## build both packages with colcon, as on a ROS installation, and try what it built
	@$(PYTHON) tools/environment.py $(VENV) colcon
	tools/colcon.sh $(VENV)

clean: ## remove what the other targets made, .venv too
	rm -rf .venv build install log demo_output *.egg-info msg_defs/build msg_defs/*.egg-info
	rm -rf .hypothesis .import_linter_cache .mypy_cache .pytest_cache .ruff_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
