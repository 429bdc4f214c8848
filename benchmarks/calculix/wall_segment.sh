#!/usr/bin/env bash
# A pressurised, narrowed wall segment here and in CalculiX (Debian package calculix-ccx) on the same
# wedges. Fails above 1 %.
# usage: benchmarks/calculix/wall_segment.sh BUILD_FOLDER [--markdown FILE]
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/prepare.sh"
failed=0
"$build/benchmarks/wall_segment" write segment.inp
ccx segment >ccx.log 2>&1 || { tail ccx.log >&2; exit 1; }
"$build/benchmarks/wall_segment" compare segment.dat >table.md || failed=1
"$build/benchmarks/result_file" "The layered wall against CalculiX" \
  --command "benchmarks/calculix/wall_segment.sh BUILD_FOLDER" "${options[@]}" <table.md
exit $failed
