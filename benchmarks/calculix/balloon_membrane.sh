#!/usr/bin/env bash
# Compares the balloon's membrane with CalculiX (Debian package calculix-ccx) on the same mesh.
# usage: benchmarks/calculix/balloon_membrane.sh BUILD_FOLDER
set -euo pipefail
program=$(realpath "$1")/benchmarks/balloon_membrane
if ! command -v ccx >/dev/null; then
  echo "no ccx here: apt-get install calculix-ccx" >&2
  exit 69
fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"$program" write membrane.inp
OMP_NUM_THREADS=${OMP_NUM_THREADS:-2} ccx membrane >ccx.log 2>&1 || { tail -5 ccx.log >&2; exit 1; }
"$program" compare membrane.dat
