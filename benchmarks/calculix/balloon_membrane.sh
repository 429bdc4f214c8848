#!/usr/bin/env bash
# Compares the balloon's membrane with CalculiX (Debian package calculix-ccx) on a sphere, the same mesh,
# and on a capsule, meshes against a finer one of revolution. Fails above 1 %.
# usage: benchmarks/calculix/balloon_membrane.sh BUILD_FOLDER [--markdown FILE]
set -euo pipefail
build=$(realpath "$1")
options=("${@:2}")
[[ ${options[0]:-} != --markdown ]] || options[1]=$(realpath -m "${options[1]}")
if ! command -v ccx >/dev/null; then
  echo "no ccx here: apt-get install calculix-ccx" >&2
  exit 69
fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
failed=0
for shape in sphere capsule; do
  "$build/benchmarks/balloon_membrane" write $shape $shape.inp
  OMP_NUM_THREADS=${OMP_NUM_THREADS:-2} ccx $shape >ccx.log 2>&1 || { tail -5 ccx.log >&2; exit 1; }
  "$build/benchmarks/balloon_membrane" compare $shape $shape.dat >>table.md || failed=1
done
"$build/benchmarks/result_file" "The balloon's membrane against CalculiX" \
  --command "benchmarks/calculix/balloon_membrane.sh BUILD_FOLDER" "${options[@]}" <table.md
exit $failed
