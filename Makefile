# Every target works on a fresh machine with Python 3.10-3.13 and make: the environment it needs is
# made on demand in .venv. Where a ROS 2 distribution is sourced, that one is used; otherwise the
# wheels on PyPI are, of the distribution ROS_DISTRO.

PYTHON ?= python3
ROS_DISTRO ?= jazzy
export ROS_DISTRO

# Without it `python -m` would import the checkout around it instead of the installed package. Python
# 3.10 does not know it: there the tests see the same code in the checkout.
export PYTHONSAFEPATH = 1
export PIP_DISABLE_PIP_VERSION_CHECK = 1

# A python that has the ROS wheels in a virtual environment of its own lends them to nobody.
ifdef AMENT_PREFIX_PATH
SOURCED := $(shell $(PYTHON) -c 'import rclpy, sys; print(sys.prefix == sys.base_prefix or \
	not rclpy.__file__.startswith(sys.prefix))' 2>/dev/null)
endif

# LOCKED=1: what locked.txt names, checked by its hashes, in an environment of its own.
ifdef LOCKED
ifneq ($(filter True,$(SOURCED))$(ROS_DISTRO),jazzy)
$(error LOCKED=1 is for the jazzy wheels: unset AMENT_PREFIX_PATH and ROS_DISTRO)
endif
endif

ifeq ($(SOURCED),True)
VENV := .venv-sourced-$(ROS_DISTRO)
VENV_OPTIONS := --system-site-packages
else
VENV := .venv$(if $(LOCKED),-locked)$(if $(filter-out jazzy,$(ROS_DISTRO)),-$(ROS_DISTRO))
# The wheels re-execute python once to find their libraries and say so in the environment. Called
# from inside another environment, ours would inherit that and load the other one's libraries.
ifneq ($(_ROS_WHEELS_BOOTSTRAP_COMPLETE)$(AMENT_PREFIX_PATH),)
unexport _ROS_WHEELS_BOOTSTRAP_COMPLETE LD_LIBRARY_PATH AMENT_PREFIX_PATH PYTHONPATH
endif
endif

UV = $(VENV)/bin/uv
PYTHON_VERSION := $(shell $(PYTHON) -c 'import sys; print("%d.%d" % sys.version_info[:2])')
PACKAGES := rodless_base rodless_sim rodless_control rodless_lab rodless_pytest
# Folders too, so that a deleted file counts as a change.
SOURCES := package.xml pyproject.toml setup.py $(shell find $(PACKAGES) benchmarks config description launch \
	resource templates scripts -name __pycache__ -prune -o -print)

# Per cent: of all packages that are measured, and of those a rig is made of. Not in pyproject.toml:
# `colcon test` measures the checkout while it runs the installation.
COVERAGE_FLOOR := 85
COVERAGE_FLOOR_CORE := 95

# What `make mutation` is to try: modules, such as rodless_sim/physics/flow.py; all without it.
MODULES ?=

# How long `make fuzz` takes, in s, and the seed it draws from.
SECONDS ?= 60
SEED ?= 1

.PHONY: demo view experiments docs docs-links test test-extensive test-fast test-lowest fuzz mutation reliability bench lint \
	lock audit sbom headers release-check clean

demo: installed
	$(VENV)/bin/rodless demo

# A rig of its own in the browser, until Ctrl-C.
view: view-tools
	$(VENV)/bin/rodless view --rig --preset calibrated

# Fails if a reproduced number leaves its stated tolerance.
experiments: installed
	$(VENV)/bin/rodless experiment all

# The site, in build/docs: warnings are errors, and a link that leads nowhere is one. A test does the
# same, without the addresses of others, which docs-links tries.
SPHINX = $(VENV)/bin/python -m sphinx --fail-on-warning --keep-going --fresh-env --quiet docs

docs: docs-tools
	$(SPHINX) build/docs
	@echo "build/docs/index.html"

docs-links: docs-tools
	$(SPHINX) build/docs-links --builder linkcheck

BY_FILE := --dist loadfile --no-loadscope-reorder
PARALLEL := -n auto $(BY_FILE)
# Tests with nodes wait for a third of their time: one more than there are cores, and 4 at most.
WITH_NODES := -n $(shell cores=$$(getconf _NPROCESSORS_ONLN); echo $$((cores < 3 ? cores + 1 : 4))) $(BY_FILE)

# A test that takes so many s hangs, in compiled code too: its process shows where, and ends.
LONGEST = 900
HANGING = -o faulthandler_timeout=$(LONGEST) -o faulthandler_exit_on_timeout=true

# One thread each for numpy's linear algebra, whose own would crowd out the other tests: identification
# takes half the time.
test test-fast test-lowest fuzz mutation: export OPENBLAS_NUM_THREADS = 1

# Each process that runs tests reads all of them first, which takes half the time where one has kept
# what pytest makes of their assertions.
test test-fast: export PYTHONDONTWRITEBYTECODE =

# First what needs no nodes, on every core; then the nodes, which mostly wait, each file of tests in a
# ROS domain of its own. A ROS test that fails gets further tries, with a rig of its own, and stands
# with what failed in the summary as RERUN.
# The coverage data has a folder of its own, so that two runs at once do not mix theirs.
test: test-tools
	@scratch=$$(mktemp -d) && trap 'rm -rf "$$scratch"' EXIT && \
	export COVERAGE_FILE="$$scratch/coverage" && \
	$(VENV)/bin/python -m pytest $(PARALLEL) $(HANGING) -m "not ros" --cov --cov-report= && \
	$(VENV)/bin/python -m pytest $(WITH_NODES) $(HANGING) -m ros --reruns 3 --rerun-show-tracebacks \
	--cov --cov-append --cov-report=term:skip-covered --cov-fail-under=$(COVERAGE_FLOOR) && \
	echo 'Of them rodless_base, rodless_sim and rodless_control:' && \
	$(VENV)/bin/python -m coverage report --skip-covered \
	--include='*/rodless_base/*,*/rodless_sim/*,*/rodless_control/*' \
	--fail-under=$(COVERAGE_FLOOR_CORE)

# The same with all cases and draws, of which `make test` leaves out some that take long.
test-extensive: export RODLESS_EXTENSIVE = 1
test-extensive: export ALSO_COVERED = rodless_lab
test-extensive: LONGEST = 7200
test-extensive: test

# For the edit-run loop: no nodes, nothing slow, no coverage.
test-fast: test-tools
	@$(VENV)/bin/python -m pytest -q $(PARALLEL) -m "not ros and not slow"

# What needs root, namespaces for the network and for mounts, and what takes long: a hundred starts
# and stops. docs/reliability.md names the tests.
reliability: test-tools
	@$(VENV)/bin/python -m pytest test/privileged
	@RODLESS_CYCLES=$${RODLESS_CYCLES:-100} $(VENV)/bin/python -m pytest test/privileged/test_start_and_stop.py

# Small faults put into the code: do the quick tests find them? Takes an hour or two.
mutation: test-tools mutation-tools
	@$(VENV)/bin/python .ci/mutation.py $(MODULES)

# Odd inputs to everything public; fails if one ends in anything but success or a refusal.
fuzz: test-tools
	@$(VENV)/bin/python test/fuzz --seconds $(SECONDS) --seed $(SEED)

# The quick tests with the oldest dependencies that setup.py admits.
test-lowest: supply-tools
	$(PYTHON) -m venv --clear .venv-lowest
	$(UV) pip install -q --python .venv-lowest --resolution lowest-direct '.[data,bags,bench,control,dask,gym,sensitivity]'
	$(UV) pip install -q --python .venv-lowest '.[test]'
	.venv-lowest/bin/python -m pytest -q $(PARALLEL) -m "not ros and not slow"

bench: bench-tools
	$(VENV)/bin/rodless bench

lint: test-tools
	$(VENV)/bin/python -m ruff check .
	$(VENV)/bin/python -m ruff format --check .
	$(VENV)/bin/python -m mypy

# The newest dependencies that setup.py admits, for all versions of Python at once, with hashes.
lock: supply-tools
	env -u AMENT_PREFIX_PATH ROS_DISTRO=jazzy $(UV) pip compile -q --upgrade --universal \
	--python-version 3.10 --generate-hashes --custom-compile-command 'make lock' \
	setup.py -o locked.txt

audit: supply-tools
	@$(VENV)/bin/python .ci/audit.py locked.txt

# The bill of materials of what LOCKED=1 installs, in CycloneDX.
sbom: supply-tools
	@$(MAKE) -s LOCKED=1 installed
	@mkdir -p results
	$(VENV)/bin/cyclonedx-py environment .venv-locked/bin/python --output-reproducible \
	-o results/sbom.cdx.json

# The licence's header, where a Python file lacks it.
headers:
	@$(PYTHON) .ci/headers.py

# What a release needs and a checkout may lack; docs/release.md says more.
release-check:
	@lacking=0; \
	if grep -n '\.example' package.xml; then \
	echo 'package.xml: put real names for these' >&2; lacking=1; fi; \
	if $(PYTHON) .ci/headers.py --missing; then echo 'make headers' >&2; lacking=1; fi; \
	exit $$lacking

clean:
	rm -rf .venv .venv-* build *.egg-info .mypy_cache .pytest_cache .ruff_cache

# One make at a time builds the environment, however many run in this checkout: the inner make looks
# at the stamps again once it holds the lock.
.PHONY: installed test-tools view-tools bench-tools docs-tools mutation-tools supply-tools
installed test-tools view-tools bench-tools docs-tools mutation-tools supply-tools:
	@flock Makefile $(MAKE) -s $(VENV)/$@

$(VENV)/python$(PYTHON_VERSION):
	@echo "Making $(VENV) with Python $(PYTHON_VERSION)"
	@$(PYTHON) -m venv --clear $(VENV_OPTIONS) $(VENV)
	@touch $@

ifdef LOCKED
# setuptools is among the locked, so that the build fetches nothing beside.
define INSTALL
	@$(VENV)/bin/pip install -qq --require-hashes -r locked.txt
	@$(VENV)/bin/pip install -qq --force-reinstall --no-deps --no-build-isolation .
endef
else
define INSTALL
	@$(VENV)/bin/pip install -qq --force-reinstall --no-deps .
	@$(VENV)/bin/pip install -qq rodless_sim
endef
endif

# setuptools would carry modules deleted since the last build from build/lib into the new one.
# With -qq pip prints errors only.
$(VENV)/installed: $(SOURCES) $(if $(LOCKED),locked.txt) | $(VENV)/python$(PYTHON_VERSION)
	@echo "Installing rodless_sim into $(VENV)$(if $(wildcard $@),, (a minute or two the first time))"
	@rm -rf build/lib build/bdist.*
	$(INSTALL)
	@touch $@

# By name, for the extra's own requirements: the project itself is installed already.
$(VENV)/%-tools: package.xml setup.py | $(VENV)/installed
	@echo "Installing the $* tools into $(VENV)"
	@$(VENV)/bin/pip install -qq 'rodless_sim[$*]'
	@touch $@
