#!/usr/bin/env bash
# Makes .venv in the project's root ready: finds a Python, creates the environment, installs tierod.
# setup.sh use: what a user needs; setup.sh dev: also what tests, benchmarks and checks need.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

fits() {
    "$1" -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1
}

find_python() {
    for candidate in ${PYTHON:-} python3.11 python3.12 python3.13 python3.14 python3 python; do
        if fits "$candidate"; then
            echo "$candidate"
            return
        fi
    done
    echo "tierod needs Python 3.11 or later, and none was found on the path." >&2
    echo "Install one, or name it: make PYTHON=/path/to/python3.11 ..." >&2
    return 1
}

whole() {
    fits .venv/bin/python && .venv/bin/python -m pip --version >/dev/null 2>&1 && grep -qF "$PWD/.venv" .venv/bin/activate
}

if ! whole; then
    python=$(find_python)
    echo "Setting up .venv with $("$python" --version) ..." >&2
    rm -rf .venv
    if ! "$python" -m venv .venv; then
        rm -rf .venv
        echo "'$python -m venv' failed; on Debian and Ubuntu: apt-get install python3-venv" >&2
        exit 1
    fi
fi
echo "Installing tierod and what it needs into .venv ..." >&2
case ${1:-dev} in
    use)
        extras=mdf,can,hdf5,live,web
        command -v cc >/dev/null || extras+=,compiler
        packages=(-e "packages/tierod[$extras]" -e packages/tierod-lab) ;;
    dev) packages=(-e packages/tierod -e 'packages/tierod-lab[dev]') ;;
    *) echo "setup.sh: '$1' is neither use nor dev" >&2; exit 2 ;;
esac
.venv/bin/python -m pip install -qq --disable-pip-version-check -c constraints.txt "${packages[@]}"
