# Every target first makes its prerequisites, including the virtual environment, and only once.
# Compatible with GNU Make 3.81, which macOS ships, and with any POSIX shell.

VENV   := .venv
PYTHON ?=
ready  := $(VENV)/ready
python := $(VENV)/bin/python

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help test test-slow test-all test-browser lint format architecture report docs site check-reproducible bench notebooks check-graders \
  publish bundle grade lab check-tests lock clean distclean FORCE

# The packages are those of the lock files, whatever else this shell can import. Compiled modules are
# kept: tests and report start hundreds of processes, and each would compile them anew.
unexport PYTHONHOME PYTHONPATH PYTHONDONTWRITEBYTECODE

help: ## show this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-19s %s\n", $$1, $$2 }' Makefile


# Set-up. The stamp contains the path of the checkout: a moved or copied checkout is set up anew.

made_for := $(shell cat $(ready) 2>/dev/null)
ifneq ($(made_for),$(CURDIR))
$(ready): FORCE
endif

$(ready): $(python) requirements.lock requirements-setup.lock pyproject.toml src/pyproject.toml tools/setup.sh
	@PYTHON="$(PYTHON)" sh tools/setup.sh "$(VENV)"

# If the interpreter is missing, setup.sh makes the whole environment anew.
$(python): ;

# Packages that only one target needs are added: requirements-lab.lock.
$(VENV)/ready-%: requirements-%.lock | $(ready)
	@PYTHON="$(PYTHON)" sh tools/setup.sh "$(VENV)" -r $<
	@touch $@


# Checks. One BLAS thread per test process, since the processes run in parallel.

one_thread := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 VECLIB_MAXIMUM_THREADS=1
pytest     := $(one_thread) $(python) -m pytest --numprocesses=auto --maxprocesses=4 --dist=worksteal

test: $(ready) ## run the tests except those marked slow
	@$(pytest) -m "not slow"

# Many of them wait for sandboxes, so three processes are better than two on two cores.
test-slow: $(ready) ## run the tests marked slow; TESTS=tests/hostile for those of a folder
	@$(pytest) --numprocesses=3 -m slow $(TESTS)

test-all: $(ready) ## run every test
	@$(pytest)

test-browser: $(VENV)/ready-browser ## test the living figures of the report in Chromium, which must be installed
	@$(one_thread) $(python) -m pytest tests/browser

lint: $(ready) ## check format and style (ruff), types (mypy) and directions of imports (import-linter)
	@$(python) -m ruff format --check
	@$(python) -m ruff check
	@$(python) -m mypy
	@$(VENV)/bin/lint-imports --no-cache


format: $(ready) ## format the code with ruff
	@$(python) -m ruff format

architecture: $(ready) ## draw docs/images/architecture.svg from the imports
	@$(python) tools/architecture.py

# Report. The command compares contents and repeats outdated steps; make only decides whether to
# start it. Folders are among the sources, so that a removed file triggers a build (report/. and
# not report, which is the target). The manifest is written last and dated to the start of the run:
# files edited during the run are newer and trigger the next build.

build    := report/build
manifest := $(build)/manifest.json
outputs  := $(build)/report.html $(build)/report.pdf
missing  := $(filter-out $(wildcard $(outputs)),$(outputs))
sources   = $(shell find src report/. \( -path report/./build -o -name __pycache__ -o -name '*.egg-info' \) -prune -o -print)

report: $(manifest) ## build the report: report/build/report.html and report.pdf

$(manifest): $(ready) $(sources) $(if $(missing),FORCE)
	@mkdir -p $(build) && touch $(build)/.started
	@$(VENV)/bin/fieldrecon report
	@touch -r $(build)/.started $@

check-reproducible: $(manifest) ## compare the report with a build in other surroundings; AGAINST=manifest.json of another machine
	@$(VENV)/bin/fieldrecon report $(if $(AGAINST),--against "$(AGAINST)",--check-reproducible)

# The site of the documentation. `site` also has the chapters of the report, and one search over both.

docs: $(VENV)/ready-docs ## build the documentation with reference and gallery: build/docs/index.html
	@$(one_thread) $(python) docs/site/build.py build/docs

site: $(VENV)/ready-docs $(manifest) ## build the documentation with the report's chapters: build/site/index.html
	@$(one_thread) $(python) docs/site/build.py build/site --report $(build)/pages

# The compared libraries have an environment of their own, which also has the locked packages.
peers := $(VENV)-bench

bench: $(peers)/ready-bench ## measure the speed; the results go to benchmarks/results/
	@$(peers)/bin/python -m benchmarks $(ONLY)

$(peers)/ready-bench: requirements-bench.lock requirements.lock pyproject.toml
	@PYTHON="$(PYTHON)" sh tools/setup.sh "$(peers)" -r $<
	@touch $@

# The tool that makes mutants also has an environment of its own.
mutation := $(VENV)-mutation

check-tests: $(mutation)/ready-mutation ## test the tests with 200 mutants of the library, in half an hour; SEED=1, COUNT=200
	@$(mutation)/bin/python -m tools.mutation $(if $(SEED),--seed $(SEED)) $(if $(COUNT),--count $(COUNT))

$(mutation)/ready-mutation: requirements-mutation.lock requirements.lock pyproject.toml
	@PYTHON="$(PYTHON)" sh tools/setup.sh "$(mutation)" -r $<
	@touch $@


# Course

notebooks: $(ready) ## make exercises/ and the executed solutions from solutions/*.py
	@$(VENV)/bin/fieldrecon course build

check-graders: $(ready) ## test the graders with right answers, misconceptions and mutants; ONLY=02 for one notebook
	@$(VENV)/bin/fieldrecon course check $(if $(ONLY),--only $(ONLY))

publish: $(ready) ## write the solved notebooks as HTML and PDF to dist/solutions/
	@$(VENV)/bin/fieldrecon course publish

bundle: $(ready) ## write dist/student-bundle.zip
	@$(VENV)/bin/fieldrecon course bundle

grade: $(ready) ## grade the submissions of a class: SUBMISSIONS=dir; OUT=graded, CLASS=class, ONLY=02, JOBS=4, DIFF=1
	@$(if $(SUBMISSIONS),,$(error SUBMISSIONS=dir is missing: the folder or zip file to grade))
	@$(VENV)/bin/fieldrecon grade "$(SUBMISSIONS)" $(if $(OUT),--out "$(OUT)") \
	  $(if $(CLASS),--class "$(CLASS)") $(if $(ONLY),--only $(ONLY)) $(if $(JOBS),--jobs $(JOBS)) \
	  $(if $(DIFF),--diff) || test $$? -eq 3

# Other targets

lab: $(VENV)/ready-lab ## open JupyterLab on the exercises
	@mkdir -p exercises
	@$(python) -m jupyterlab exercises

lock: $(ready) ## bring the lock files up to date with pyproject.toml; UPGRADE=--upgrade takes new versions
	@$(compile) requirements-setup.lock --group setup
	@$(compile) requirements.lock pyproject.toml src/pyproject.toml --extra all --group test --group lint --no-emit-package fieldrecon
	@$(compile) requirements-lab.lock pyproject.toml --group lab --constraints requirements.lock
	@$(compile) requirements-browser.lock pyproject.toml --group browser --constraints requirements.lock
	@$(compile) requirements-docs.lock pyproject.toml --group docs --constraints requirements.lock
	@$(compile) requirements-mutation.lock pyproject.toml --group mutation --constraints requirements.lock
	@$(compile) requirements-bench.lock pyproject.toml --group bench --constraints requirements.lock
	@$(compile) benchmarks/graders/nbgrader.lock benchmarks/graders/nbgrader.in
	@$(compile) benchmarks/graders/otter.lock benchmarks/graders/otter.in

compile = $(python) -m uv pip compile --quiet --universal --generate-hashes --no-header \
  --python-version 3.11 $(UPGRADE) --output-file

clean: ## remove build outputs and caches
	rm -rf $(build) build dist .hypothesis .mypy_cache .pytest_cache .ruff_cache
	find . -name '.?*' -prune -o -name __pycache__ -prune -exec rm -rf {} +

distclean: clean ## also remove the virtual environment
	rm -rf src/*.egg-info
	test ! -e $(VENV)/pyvenv.cfg || rm -rf $(VENV)

FORCE:
