#!/bin/sh
# Make the virtual environment in which everything runs; make calls this when it is needed.
#
#   sh tools/setup.sh VENV [-r LOCK ...]
#
# A Python that is new enough makes the environment; pip brings uv, at the version that
# requirements-setup.lock pins; uv installs what requirements.lock names (and each further LOCK)
# and then this project. PYTHON=... in the environment chooses the Python.
#
# VENV/ready is written last and holds the place the environment was made for: an environment
# without it was interrupted, one with another place in it was moved, and both are made anew.
set -eu
cd "$(dirname "$0")/.."
home=$(pwd -P)
venv=$1
shift
ready=$venv/ready
lock=$venv.lock

stop() {
    printf 'fieldrecon: %s\n' "$1" >&2
    exit 1
}

version() { "$1" -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null; }
new_enough() { "$1" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; }
has_ensurepip() { "$1" -c 'import ensurepip, venv' 2>/dev/null; }
has_pip() { "$1" -m pip --python "$(command -v "$1")" --version >/dev/null 2>&1; }

# python: can make a complete environment.
# bare:   new enough, but without ensurepip, which Debian and Ubuntu package apart.
# old:    too old.
# Each is run before it is believed, since a name on the PATH may be a shim with nothing behind.
find_python() {
    python='' bare='' old=''
    if [ -n "${PYTHON:-}" ]; then
        set -- "$PYTHON"
    else
        set -- python3.14 python3.13 python3.12 python3.11 python3 python
    fi
    for candidate; do
        if ! version "$candidate" >/dev/null; then
            continue
        elif ! new_enough "$candidate"; then
            old=${old:-$candidate}
        elif ! has_ensurepip "$candidate"; then
            bare=${bare:-$candidate}
        else
            python=$candidate
            break
        fi
    done
}

# The line to type; $1 names Debian's package.
how_to_install() {
    if command -v brew >/dev/null; then
        echo "brew install python@3.13"
    elif command -v apt-get >/dev/null; then
        echo "sudo apt-get install $1 $1-venv"
    elif command -v dnf >/dev/null; then
        echo "sudo dnf install python3.12"
    else
        echo "make PYTHON=/path/to/python3.11 (see https://www.python.org/downloads)"
    fi
}

remove_environment() {
    if [ "$venv" != .venv ] && [ -e "$venv" ] && [ ! -e "$venv/pyvenv.cfg" ]; then
        stop "VENV=$venv exists and is not a virtual environment; name another folder."
    fi
    rm -rf "$venv"
}

bring_uv() { "$@" install --quiet --require-hashes -r requirements-setup.lock; }

# Three ways to an environment with uv in it, the last two for a Python without ensurepip.
make_environment() {
    remove_environment
    find_python
    if [ -n "$python" ]; then
        "$python" -m venv "$venv"
        bring_uv "$venv/bin/python" -m pip
    elif [ -n "$bare" ] && uv --version >/dev/null 2>&1; then
        uv venv --quiet --no-python-downloads --python "$bare" "$venv"
        VIRTUAL_ENV=$venv bring_uv uv pip
    elif [ -n "$bare" ] && has_pip "$bare"; then
        "$bare" -m venv --without-pip "$venv"
        bring_uv "$bare" -m pip --python "$venv/bin/python"
    else
        stop "$(what_is_missing)"
    fi
}

what_is_missing() {
    if [ -n "$bare" ]; then
        echo "$bare cannot make a virtual environment, because it lacks ensurepip;" \
            "type: $(how_to_install "python$(version "$bare")")"
    elif [ -n "$old" ]; then
        echo "Python 3.11 or newer is needed and $old is $(version "$old");" \
            "type: $(how_to_install python3.11)"
    elif [ -n "${PYTHON:-}" ]; then
        echo "PYTHON=$PYTHON does not run; type: make PYTHON=/path/to/python3.11"
    else
        echo "Python 3.11 or newer is needed and none is on the PATH;" \
            "type: $(how_to_install python3)"
    fi
}

install() {
    # Compiled here, once, and not by every process that finds them uncompiled.
    "$venv/bin/python" -m uv pip install --python "$venv/bin/python" --require-hashes \
        --compile-bytecode -r requirements-setup.lock -r requirements.lock "$@"
    "$venv/bin/python" -m uv pip install --python "$venv/bin/python" --quiet \
        --no-deps --no-build-isolation --reinstall-package fieldrecon \
        --reinstall-package fieldrecon-course --editable . --editable ./src
    # So that the first import makes no folder: make takes a newer folder for a changed source.
    "$venv/bin/python" -m compileall -q src
}

intact() { [ "$(cat "$ready" 2>/dev/null)" = "$home" ] && new_enough "$venv/bin/python"; }
locks_changed() { [ -n "$(find requirements*.lock pyproject.toml src/pyproject.toml tools/setup.sh -newer "$ready")" ]; }

# One set-up at a time. The lock is a link to the number of the process that holds it: made in one
# step, and recognised when its process has died.
until ln -s $$ "$lock" 2>/dev/null; do
    holder=$(readlink "$lock") || stop "$home cannot be written to."
    kill -0 "$holder" 2>/dev/null || rm -f "$lock"
    sleep 1
done
trap 'rm -f "$lock"' EXIT
trap 'exit 1' HUP INT TERM

# While this one waited, another may have done the work.
if intact && ! locks_changed && [ $# -eq 0 ]; then
    exit
fi

printf 'fieldrecon: setting up %s (once; later calls start at once)\n' "$venv"
intact || make_environment
rm -f "$ready"
install "$@"
printf '%s' "$home" >"$ready"
