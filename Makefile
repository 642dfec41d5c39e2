# `make demo` runs the main job, `make test` the tests. The first call sets up .venv (one to two minutes), later calls start at once.

SHELL := bash
.SHELLFLAGS := -o pipefail -ec
.DEFAULT_GOAL := help
.PHONY: help demo test bench lint ros clean

VENV := $(CURDIR)/.venv
READY := $(VENV)/ready

# One thread a process: two cores are better used by two processes.
export OMP_NUM_THREADS := 1
# rclpy from pip finds its parts here, and only here: an installed ROS 2 stays out of this environment (README: on top of ROS 2).
export AMENT_PREFIX_PATH := $(VENV)
export ROS_AUTOMATIC_DISCOVERY_RANGE := LOCALHOST
export ROS_LOG_DIR := $(CURDIR)/out/log
unexport PYTHONPATH PYTHONHOME
# Inherited from a Python of another environment, it would keep this one from finding its ROS libraries.
unexport _ROS_WHEELS_BOOTSTRAP_COMPLETE
ifdef ROS_DISTRO
unexport LD_LIBRARY_PATH
endif

help:
	@echo 'make demo   the main job, end to end: two simulators, one policy, bags, a video and a plot in out/'
	@echo 'make test   style and tests'
	@echo 'make bench  speeds and ratios, measured here'
	@echo 'make lint   style alone'
	@echo 'make ros    colcon build in ros_ws, for ros2 run and ros2 launch'
	@echo 'make clean  removes what was built (.venv, workspace, caches); results in out/ stay'

demo: $(READY)
	@$(VENV)/bin/hamr demo

bench: $(READY)
	@$(VENV)/bin/hamr bench

test: lint
	@echo '== tests, on two cores'
	@$(VENV)/bin/python -m pytest -q -n 2 --dist loadfile

lint: $(READY)
	@echo '== style'
	@$(VENV)/bin/ruff check .

ros: $(READY)
	@echo '== colcon build in ros_ws'
	@cd ros_ws && $(VENV)/bin/colcon build
	@echo 'Now: source .venv/bin/activate; source ros_ws/install/setup.bash; export AMENT_PREFIX_PATH="$$AMENT_PREFIX_PATH:$(VENV)"'

# Python 3.11 first: every pin was tried on it. venv without ensurepip (Debian without python3-venv) is no use.
$(READY): pyproject.toml constraints.txt
	@python=; for try in python3.11 python3.12 python3.13 python3; do \
	  if $$try -c 'import sys, ensurepip; sys.exit(not (3, 11) <= sys.version_info[:2] < (3, 14))' 2>/dev/null; then python=$$try; break; fi; done; \
	[ -n "$$python" ] || { echo 'No Python 3.11, 3.12 or 3.13 with venv was found; install one (on Debian: python3 and python3-venv), then run make again.' >&2; exit 1; }; \
	echo "== set-up 1/2: .venv with $$($$python --version)"; \
	$$python -m venv --clear $(VENV)
	@echo "== set-up 2/2: $$(grep -c == constraints.txt) pinned packages into .venv, one to two minutes (log: .venv/setup.log)"
	@$(VENV)/bin/python -m pip install --disable-pip-version-check --no-input -e '.[test]' -c constraints.txt 2>&1 | tee $(VENV)/setup.log \
	  | awk '/^ *Downloading|^ *Using cached/ {printf "."; fflush()} /^Installing collected/ {printf " unpacking"; fflush()} END {print ""}' \
	  || { grep -E '^ERROR' $(VENV)/setup.log >&2; echo 'Set-up failed; the whole log is in .venv/setup.log.' >&2; exit 1; }
	@touch $@

clean:
	rm -rf $(VENV) ros_ws/build ros_ws/install ros_ws/log build .pytest_cache .ruff_cache .hypothesis .numba_cache *.egg-info
	find src tests -name __pycache__ -type d -prune -exec rm -rf {} +
