#!/bin/sh
# Make the virtual environment of the project. The Makefile calls this script when necessary.
#
#   sh tools/setup.sh VENV [-r LOCK ...]
#
# A sufficiently new Python makes the environment; pip installs uv in the version of
# requirements-setup.lock; uv installs the packages of requirements.lock and of each further LOCK,
# and then this project. The environment variable PYTHON chooses the Python.
#
# VENV/ready is written last and contains the path of the checkout. An environment without this
# file was interrupted, one with another path was moved; both are made anew.
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
# bare:   new enough, but without ensurepip, which Debian and Ubuntu package separately.
# old:    too old.
# Each candidate is run, since a name on the PATH may be a shim without a Python.
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

# The command that installs Python; $1 is the name of Debian's package.
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

# Three ways to make an environment with uv; the last two are for a Python without ensurepip.
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

uv_install() { "$venv/bin/python" -m uv pip install --python "$venv/bin/python" "$@"; }

install() {
    # Compiled once here instead of by every process that imports the packages first.
    set -- --require-hashes --compile-bytecode -r requirements-setup.lock -r requirements.lock "$@"
    # uv brings its own certificates. A network that inspects TLS is known to the system only.
    uv_install "$@" || {
        echo "fieldrecon: trying again with the certificates of this system" >&2
        export UV_SYSTEM_CERTS=1
        uv_install "$@"
    }
    uv_install --quiet --no-deps --no-build-isolation --reinstall-package fieldrecon \
        --reinstall-package fieldrecon-course --editable . --editable ./src
    # The first import must not make a folder, which make would take for a changed source.
    "$venv/bin/python" -m compileall -q src
}

intact() { [ "$(cat "$ready" 2>/dev/null)" = "$home" ] && new_enough "$venv/bin/python"; }
locks_changed() { [ -n "$(find requirements*.lock pyproject.toml src/pyproject.toml tools/setup.sh -newer "$ready")" ]; }

# One set-up at a time. The lock is a link to the id of the process that holds it: it is made
# atomically, and recognized as stale if the process has ended.
until ln -s $$ "$lock" 2>/dev/null; do
    holder=$(readlink "$lock") || stop "$home cannot be written to."
    kill -0 "$holder" 2>/dev/null || rm -f "$lock"
    sleep 1
done
trap 'rm -f "$lock"' EXIT
trap 'exit 1' HUP INT TERM

# While this process waited, another one may have done the work.
if intact && ! locks_changed && [ $# -eq 0 ]; then
    exit
fi

printf 'fieldrecon: setting up %s (once; later calls start at once)\n' "$venv"
intact || make_environment
rm -f "$ready"
install "$@"
printf '%s' "$home" >"$ready"
