#!/usr/bin/env bash
# A stenosed segment with yielding plaque, blown up by a rigid growing cylinder, here and in CalculiX
# (Debian package calculix-ccx) on the same wedges. Fails above 2 %. CalculiX takes about ten minutes.
# usage: benchmarks/calculix/growing_cylinder.sh BUILD_FOLDER [--markdown FILE]
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
"$build/benchmarks/growing_cylinder" write segment.inp
OMP_NUM_THREADS=${OMP_NUM_THREADS:-2} ccx segment >ccx.log 2>&1 || { tail ccx.log >&2; exit 1; }
"$build/benchmarks/growing_cylinder" compare segment.dat >table.md || failed=1
"$build/benchmarks/result_file" "A stenosed segment under a growing cylinder against CalculiX" \
  --command "benchmarks/calculix/growing_cylinder.sh BUILD_FOLDER" "${options[@]}" <table.md
exit $failed
