#!/usr/bin/env bash
# Compares the balloon's membrane with CalculiX (Debian package calculix-ccx) on a sphere, the same mesh,
# and on a capsule, meshes against a finer one of revolution.
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
failed=0
for shape in sphere capsule; do
  "$program" write $shape $shape.inp
  OMP_NUM_THREADS=${OMP_NUM_THREADS:-2} ccx $shape >ccx.log 2>&1 || { tail -5 ccx.log >&2; exit 1; }
  "$program" compare $shape $shape.dat || failed=1
done
exit $failed
