# Every target sets up .venv by itself; nothing else is needed but Python 3.11, make and git.
PYTHON ?= $(shell command -v python3.11 || command -v python3)
BIN := .venv/bin
READY := .venv/ready
DEMO_READY := .venv/demo-ready
PIP := $(BIN)/pip --disable-pip-version-check --quiet
COMPILE := uv pip compile pyproject.toml --universal --python-version 3.11 --generate-hashes --no-emit-index-url \
	--custom-compile-command "make lock" --quiet --upgrade
# The packages in .venv that requirements.lock does not name, for example those of an older lock.
UNLOCKED = $(PIP) freeze --exclude-editable | sed 's/[ =].*//' | tr 'A-Z_.' 'a-z--' | \
	grep -vxF "$$(sed -n 's/^\([a-z0-9-]*\)==.*/\1/p' requirements.lock)"
ONLY ?= *
TEST := $(BIN)/pytest --numprocesses 4 --dist worksteal

# Tests start hundreds of processes, each of which would compile all files of ours anew.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo test check fix wheel bench bench-peers bench-notcurses soak tools setup lock clean

demo: $(DEMO_READY)  ## open the console on a simulated robot
	@$(BIN)/rune demo

test: $(READY) tools  ## run the tests
	$(TEST)

check: $(READY) tools  ## everything CI asks for; changes no file
	$(BIN)/ruff format --check
	$(BIN)/ruff check
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(TEST)

fix: $(READY)  ## format, and mend what the linter can
	$(BIN)/ruff format
	$(BIN)/ruff check --fix

wheel: $(READY)  ## build dist/*.whl, to be copied and installed elsewhere
	$(PIP) wheel --no-deps --no-build-isolation -w dist .
	@ls dist

bench: $(READY)  ## every figure, or one script's with ONLY=sim
	@for script in benchmarks/$(ONLY).py; do \
		if [ $$script != benchmarks/figures.py ]; then $(BIN)/python $$script || exit 1; fi; done

bench-peers:  ## what benchmarks compare with, in an environment of its own
	@$(PYTHON) -m venv .venv-bench
	@.venv-bench/bin/pip install --quiet --disable-pip-version-check -r benchmarks/requirements.txt

bench-notcurses:  ## the same of notcurses, built from Debian's source
	@benchmarks/peers/build_notcurses.sh

soak: $(READY) tools  ## the tests that run for minutes
	RUNE_EXTREMES=20000 HYPOTHESIS_PROFILE=thorough $(TEST) tests/hub tests/console --timeout 600
	$(BIN)/pytest -m soak --timeout 1800

tools:  ## virtual joysticks, real ROS 2 and what else the tests use, where that can be installed
	@tests/install_tools.sh

setup: $(READY)

$(DEMO_READY): requirements-demo.lock pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "Rune needs Python 3.11 or newer: make PYTHON=/path/to/python3.11"; exit 2; }
	@echo "setting up .venv (once)"
	@$(PYTHON) -m venv .venv
	@$(PIP) install --require-hashes -r requirements-demo.lock
	@$(PIP) install --no-deps --no-build-isolation -e .
	@touch $@

$(READY): $(DEMO_READY) requirements.lock
	@echo "adding the tools of the tests to .venv (once)"
	@$(PIP) install --require-hashes -r requirements.lock
	@$(UNLOCKED) | xargs -r $(PIP) uninstall --yes
	@touch $@

lock:  ## choose versions anew within the bounds of pyproject.toml; needs uv
	$(COMPILE) --extra console --extra camera --extra record --extra evdev --extra mavlink --extra ros --extra fleet --extra tools --group dev -o requirements.lock
	$(COMPILE) --extra console --extra evdev --group build -c requirements.lock -o requirements-demo.lock
	uv pip compile --group ros2 --python-version 3.11 --python-platform x86_64-manylinux_2_28 --generate-hashes \
		--no-emit-index-url --custom-compile-command "make lock" --quiet --upgrade -o requirements-ros2.lock

clean:
	rm -rf .venv .venv-bench
