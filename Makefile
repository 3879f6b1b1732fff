# All the commands of the project; `make` alone lists them.
SHELL  := bash
PYTHON ?= python3

VENV  := .venv
READY := $(VENV)/.installed
CORE  := $(wildcard core/*/*.c core/*/*.h) core/binding.py core/source_hash.py firmware/pil_wire.h

C_WARNINGS := -std=c99 -ffp-contract=off -fno-math-errno -fno-trapping-math -Wall -Wextra \
              -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Werror -fsyntax-only -Icore -Icore/drive -Ibuild/generated

.PHONY: help install demo test test-lowest check core bench bench-peers mutants lock sbom reference docs docs-test playground audit clean venv extension c-warnings c-lint force

help: ## List the commands
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-11s %s\n", $$1, $$2}' $(firstword $(MAKEFILE_LIST))

install: ## Build a fresh .venv with everything in it
	@rm -f $(READY) $(VENV)/pyvenv.cfg
	@$(MAKE) --no-print-directory $(READY)

demo: $(READY) ## Train, evaluate and export on the paper's motor
	$(VENV)/bin/sensorless demo

test: $(READY) ## Run the tests, two at a time
	$(VENV)/bin/pytest -n 2

check: $(READY) c-warnings c-lint ## Lint, format, types, and C warnings as errors
	$(VENV)/bin/ruff check
	$(VENV)/bin/ruff format --check
	$(VENV)/bin/mypy

core: $(READY) ## Rebuild the compiled core in place, in .venv

bench: $(READY) ## Measure speed, write build/bench.json
	$(VENV)/bin/python -m benchmarks.bench

bench-peers: $(READY) ## Measure speed beside other simulators
	$(VENV)/bin/python benchmarks/peers.py

lock: $(READY) ## Write constraints.txt, the versions installed here
	@{ sed '/^[^#]/,$$d' constraints.txt; $(VENV)/bin/python -m pip freeze --exclude-editable \
	  --exclude sensorless | sed 's/+[a-z0-9.]*$$//' | tr A-Z_ a-z- | LC_ALL=C sort; } > constraints.new
	@mv constraints.new constraints.txt

sbom: $(READY) ## Write build/sbom.json, what is installed, as CycloneDX
	@$(PYTHON) -m venv build/tools && build/tools/bin/pip install -q 'cyclonedx-bom>=7,<8'
	@build/tools/bin/cyclonedx-py environment --pyproject pyproject.toml --output-reproducible \
	  -o build/sbom.json $(VENV)/bin/python && echo "wrote build/sbom.json"

test-lowest: $(READY) ## Run tests on the lowest versions that pyproject.toml allows
	@$(VENV)/bin/python studies/lowest_versions.py

reference: $(READY) ## Rebuild results/reference (about 15 minutes with -j2)
	@$(MAKE) --no-print-directory -f results/reference.mk

docs: $(READY) ## Build the documentation site, build/site/index.html
	@NO_MKDOCS_2_WARNING=1 $(VENV)/bin/python -m mkdocs build --strict --quiet
	@echo "==> build/site/index.html"

docs-test: $(READY) ## Run what the documentation shows, small
	$(VENV)/bin/pytest tests/docs/run_*.py

playground: $(READY) ## Build the page build/playground/playground.html
	$(VENV)/bin/python -m web.build

audit: docs playground ## Check every page in a browser: contrast, names, width, paint, console
	$(VENV)/bin/python -m web.audit build/site/[!4]*.html build/site/*/*.html build/playground/playground.html

mutants: $(READY) ## Which small mistakes in core/drive do the checks notice (20 minutes)
	$(VENV)/bin/python -m tests.mutants.run

clean: ## Remove build outputs, keep the libraries in .venv
	rm -rf build dist *.egg-info core/*/*.o sensorless/_core* $(READY)
	rm -rf .mypy_cache .pytest_cache .ruff_cache
	find . -path ./$(VENV) -prune -o -name __pycache__ -exec rm -rf {} +

# Time stamp of the installation: a change of the project file reinstalls, one of the core compiles.
$(READY): pyproject.toml setup.py $(CORE) $(if $(filter core,$(MAKECMDGOALS)),force)
	@$(MAKE) --no-print-directory $(if $(filter pyproject.toml setup.py,$?),venv,extension)
	@touch $@

# The mark .installing outlives an interrupted run, whose half-unpacked libraries are not trusted.
# A .venv without pyvenv.cfg is the system's own Python by another name: never install into that.
venv:
	@$(PYTHON) -c 'import ensurepip, os, sys, sysconfig as s; sys.exit(sys.version_info < (3, 10) \
	  or not os.path.exists(os.path.join(s.get_path("include"), "Python.h")))' 2>/dev/null || { \
	  echo "error: $(PYTHON) must be Python 3.10 or newer with venv and C headers" \
	       "(Debian: apt-get install python3-venv python3-dev)" >&2; exit 1; }
	@rm -f $(READY) sensorless/_core*.so
	@if [ -e $(VENV)/.installing ] || ! $(VENV)/bin/python -c \
	  'import pip, sys; sys.exit(sys.prefix == sys.base_prefix)' 2>/dev/null; then \
	  echo "==> creating $(VENV)"; rm -f $(VENV)/pyvenv.cfg; rm -rf $(VENV); \
	  mkdir $(VENV); touch $(VENV)/.installing; $(PYTHON) -m venv $(VENV); fi
	@echo "==> installing into $(VENV) (minutes the first time, log in $(VENV)/install.log)"
	@touch $(VENV)/.installing
	@set -o pipefail; trap 'exit 130' INT TERM; \
	$(VENV)/bin/python -m pip --require-virtualenv install --no-compile --progress-bar off \
	  $(if $(LOCKED),-c constraints.txt) -e '.[plot,tune,fuzzy,scale,dev,docs]' 2>&1 | tee $(VENV)/install.log \
	| while read -r step name _; do name=$${name##*/}; name=$${name%%-[0-9]*}; \
	    case "$$step $$name" in \
	    Collecting*|Processing*) printf ' %s' "$${name%%[!a-zA-Z0-9_.-]*}";; \
	    "Installing collected") printf '\n==> unpacking, compiling\n';; esac; done \
	|| { rm -f $(VENV)/.installing; tail -n 40 $(VENV)/install.log >&2; exit 1; }
	@rm $(VENV)/.installing

extension:
	@echo "==> compiling the core"
	@rm -f sensorless/_core*.so
	@$(VENV)/bin/python setup.py -q build_ext --inplace --force

# Each header also on its own, so that it includes what it uses.
c-warnings: $(READY)
	@echo "==> C warnings"
	@failed=0; for cc in gcc clang; do \
	  if ! command -v $$cc >/dev/null; then echo "$$cc: not found"; [ $$cc = clang ] || exit 1; continue; fi; \
	  for file in core/*/*.c; do $$cc $(C_WARNINGS) $$file || failed=1; done; \
	  for file in core/drive/*.h core/sim/*.h firmware/pil_wire.h; do \
	    printf '#include "%s"\ntypedef int not_empty;\n' $$file | $$cc $(C_WARNINGS) -I. -x c - || failed=1; done; \
	done; exit $$failed

# Where they are installed; in CI (CI=true) they have to be.
c-lint:
	@echo "==> C format and lint"
	@for tool in clang-format cppcheck; do command -v $$tool >/dev/null || { \
	  echo "$$tool: not found"; [ "$$CI" != true ] || exit 1; }; done
	@! command -v clang-format >/dev/null || clang-format --dry-run --Werror core/*/*.[ch] firmware/*.[ch] firmware/*/*.c web/*.c
	@! command -v cppcheck >/dev/null || cppcheck --quiet --std=c99 --error-exitcode=1 \
	  --enable=warning,portability,performance -Icore -Icore/drive -Ibuild/generated core firmware
	@! command -v cppcheck >/dev/null || cppcheck --quiet --std=c99 --error-exitcode=1 \
	  --enable=style -Icore/drive core/drive # what ships
