#!/bin/sh
# Puts a working environment into .venv: the locked packages and the project, editable.
# `bootstrap.sh` installs what hannes needs; `bootstrap.sh test` what its tests need too.
# Safe to repeat: it does nothing when .venv is up to date, and starts afresh after a killed install.
set -eu
cd "$(dirname "$0")/.."

core=requirements.lock
whole=requirements-test.lock   # all of the core at the same versions, and more
lock=$core
if [ "${1:-}" = test ]; then lock=$whole; fi

venv=.venv
packages=$venv/.packages   # written last: what the packages in .venv were installed from
project=$venv/.project     # likewise for the project's own metadata
running=$venv/.pip         # the process id of the last install

fail() {
    echo "hannes: $*" >&2
    exit 1
}

# Python 3.15 is not in reach of the locked compiler (numba) yet.
version_fits='import sys; sys.exit(not (3, 11) <= sys.version_info[:2] < (3, 15))'

# An active environment, .venv among them, cannot make a new one in its own place: its base can.
base='import sys; print(getattr(sys, "_base_executable", sys.executable))'

# Prints an interpreter that really runs (a name on PATH may be a shim of a version not installed).
find_python() {
    bare=
    for name in ${PYTHON:+"$PYTHON"} python3.14 python3.13 python3.12 python3.11 python3 python; do
        "$name" -c "$version_fits" </dev/null >/dev/null 2>&1 || continue
        found=$("$name" -c "$base")
        if "$found" -c 'import ensurepip, venv' >/dev/null 2>&1; then
            echo "$found"
            return
        fi
        bare=${bare:-$found}
    done
    if [ -n "$bare" ]; then
        fail "$bare has no venv module; install it (Debian, Ubuntu: apt install python3-venv)"
    fi
    fail "no Python 3.11 to 3.14 found; install one, or name it: make PYTHON=/path/to/python3"
}

# Runs the environment's pip; its own words go to a log, the user gets one line. Python compiles what
# it imports when it does: half the time of an install would go into files that nothing imports.
pip_install() {
    PIP_USER=0 PIP_DISABLE_PIP_VERSION_CHECK=1 \
        sh -c 'echo $$ >"$1"; shift; exec "$@"' sh "$running" \
        "$venv/bin/python" -m pip install --quiet --progress-bar off --no-compile "$@" \
        >"$venv/install.log" 2>&1 && rm -f "$running" && return
    fail "packages could not be installed; is a package index in reach?" \
        "What pip said is in $venv/install.log"
}

# A killed bootstrap can leave its pip at work, and a second one may run beside this: let it end.
wait_for_running() {
    seconds=0
    while [ -f "$running" ] && kill -0 "$(cat "$running")" 2>/dev/null && [ $seconds -lt 180 ]; do
        sleep 1
        seconds=$((seconds + 1))
    done
}

fresh_environment() {
    python=$(find_python)
    rm -f "$packages" "$project"
    "$python" -m venv --clear "$venv" >/dev/null 2>&1 ||
        fail "$python could not create $venv; is the folder writable and the disk not full?"
}

# What tests need goes on top of a whole core; anything else starts afresh.
install_packages() {
    echo "hannes: installing packages into $venv (a minute or two)" >&2
    if ! holds "$core"; then fresh_environment; fi
    rm -f "$packages"
    pip_install -r "$lock"
    packages_of "$lock" >"$packages.new"
    mv "$packages.new" "$packages"
}

install_project() {
    pip_install --no-deps --no-build-isolation -e .
    project_wanted >"$project.new"
    mv "$project.new" "$project"
}

# A checkout that was moved needs a new environment too: its scripts name the old folder.
packages_of() {
    pwd
    cat "$1"
}

project_wanted() {
    cat pyproject.toml hannes/core/version.py
}

same() {
    [ -f "$2" ] && [ "$1" = "$(cat "$2")" ]
}

holds() {
    same "$(packages_of "$1")" "$packages" && "$venv/bin/python" -c '' >/dev/null 2>&1
}

ready() {
    holds "$lock" || holds "$whole"
}

# Spelt with `if`: after `||` the shell would not stop at the first failure (set -e).
if ! ready; then wait_for_running; fi
if ! ready; then install_packages; fi
if ! same "$(project_wanted)" "$project"; then install_project; fi
