#!/usr/bin/env bash
# usage: wall_segment.sh BUILD_FOLDER   (needs Debian's calculix-ccx)
# A pressurised, narrowed wall segment here and in CalculiX on the same wedges; fails above 1 %.
set -euo pipefail
program=$(realpath "$1")/benchmarks/wall_segment
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
"$program" write segment.inp
ccx segment >ccx.log 2>&1 || { tail ccx.log; exit 1; }
"$program" compare segment.dat
