#!/usr/bin/env bash
# Fetch axe-core from npm into .venv, where the tests of the page find it; it is not part of the project.
set -euo pipefail
cd "$(dirname "$0")/.."
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
(cd "$folder" && npm pack --silent axe-core@4 && tar xzf axe-core-*.tgz package/axe.min.js)
mv "$folder/package/axe.min.js" .venv/axe.min.js
echo "axe-core is in .venv/axe.min.js; 'make test' uses it"
