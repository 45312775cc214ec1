# make demo   the gripper, simulated, controlled, recorded and identified; results in out/demo
# make paper  every table and figure of the paper, recomputed; results in out/paper
# make bench  how fast it is, some 20 minutes; results in out/bench and docs/performance.md
# make test   style, types and all tests
# make chaos  a million hostile messages, hundreds of dead nodes, a bad network, overload; ten minutes
# make fuzz   readers of bags, CSV and models, given thousands of broken ones; four minutes
# make soak   an hour of the plant in lockstep: memory and latency stay where they are
# make clean  removes the environment and everything generated
#
# The first run installs into a virtual environment of its own, .venv. Where ROS 2 is sourced, that
# is used; elsewhere its wheels are installed from the Python package index.

PYTHON ?= python3
ROS := $(shell test -n "$$ROS_DISTRO" && $(PYTHON) -c 'import rclpy' 2>/dev/null && echo "$$ROS_DISTRO")
ifdef ROS
VENV := .venv-$(ROS)
VENV_OPTIONS := --system-site-packages
EXTRAS := test
else
VENV := .venv
EXTRAS := ros,test
endif
BIN := $(VENV)/bin
INSTALLED := $(VENV)/installed

.PHONY: demo paper bench test chaos fuzz soak install clean

demo: install
	$(BIN)/microgripper demo --out out/demo

paper: install
	$(BIN)/microgripper paper --out out/paper

bench: install
	$(BIN)/microgripper bench --out out/bench
	cp out/bench/performance.md out/bench/performance.png docs/

test: install
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/pytest --numprocesses auto --dist worksteal -m 'not ros'
	$(BIN)/pytest -m ros  # by themselves: nodes keep time

chaos: install
	$(BIN)/python test/chaos --keep docs/reliability.md

fuzz: install
	$(BIN)/pytest -m fuzz --hypothesis-profile=chaos

soak: install
	$(BIN)/python test/chaos/soak.py

install: $(INSTALLED)

$(INSTALLED): setup.py
	@$(PYTHON) -c 'import ensurepip' 2>/dev/null || \
	  { echo "$(PYTHON) cannot make virtual environments: apt-get install python3-venv" >&2; exit 1; }
	test -x $(BIN)/python || $(PYTHON) -m venv --clear $(VENV_OPTIONS) $(VENV)
	@echo "Installing, about a minute ..."
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[$(EXTRAS)]'
	@touch $@

clean:
	rm -rf .venv* build install log out *.egg-info
	rm -rf .hypothesis .mypy_cache .pytest_cache .ruff_cache
	find . -name __pycache__ -prune -exec rm -rf {} +
