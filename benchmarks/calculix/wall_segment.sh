#!/usr/bin/env bash
# A pressurised, narrowed wall segment here and in CalculiX (Debian package calculix-ccx) on the same
# wedges. Fails above 1 %.
# usage: benchmarks/calculix/wall_segment.sh BUILD_FOLDER [--markdown FILE]
set -euo pipefail
build=$(realpath "$1")
options=("${@:2}")
[[ ${options[0]:-} != --markdown ]] || options[1]=$(realpath -m "${options[1]}")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
failed=0
"$build/benchmarks/wall_segment" write segment.inp
ccx segment >ccx.log 2>&1 || { tail ccx.log; exit 1; }
"$build/benchmarks/wall_segment" compare segment.dat >table.md || failed=1
"$build/benchmarks/result_file" "The layered wall against CalculiX" \
  --command "benchmarks/calculix/wall_segment.sh BUILD_FOLDER" "${options[@]}" <table.md
exit $failed
