#!/usr/bin/env bash
# Writes constraints.txt anew: every version that a fresh environment gets today, without any constraint.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
fresh=$(mktemp -d)
trap 'rm -rf "$fresh"' EXIT
"${PYTHON:-python3.11}" -m venv "$fresh"
"$fresh/bin/python" -m pip install -qq --disable-pip-version-check -e 'packages/tierod[docs]' -e 'packages/tierod-lab[dev]'
{
    echo "# Written by scripts/constraints.sh: the versions that the tests have passed with."
    "$fresh/bin/python" -m pip freeze --exclude-editable --disable-pip-version-check | grep -E '^[A-Za-z0-9._-]+==[^ ]+$'
} >constraints.new
mv constraints.new constraints.txt
