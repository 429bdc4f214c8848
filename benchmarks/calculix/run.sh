#!/usr/bin/env bash
# Compares the balloon's membrane with CalculiX (Debian package calculix-ccx) on the same mesh.
# usage: benchmarks/calculix/run.sh BUILD_FOLDER [C3D6|C3D15]
set -euo pipefail
program=$(realpath "$1")/benchmarks/calculix_membrane
element=${2:-C3D15}
if ! command -v ccx >/dev/null; then
  echo "no ccx here: apt-get install calculix-ccx" >&2
  exit 69
fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"$program" write membrane.inp "$element"
OMP_NUM_THREADS=${OMP_NUM_THREADS:-2} ccx membrane >ccx.log 2>&1 || { tail -5 ccx.log >&2; exit 1; }
"$program" compare membrane.dat
