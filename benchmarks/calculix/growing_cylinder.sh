#!/usr/bin/env bash
# A stenosed segment with yielding plaque, blown up by a rigid growing cylinder, here and in CalculiX
# (Debian package calculix-ccx) on the same wedges. Fails above 2 %. CalculiX takes about ten minutes.
# usage: benchmarks/calculix/growing_cylinder.sh BUILD_FOLDER [--markdown FILE]
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/prepare.sh"
failed=0
"$build/benchmarks/growing_cylinder" write segment.inp
ccx segment >ccx.log 2>&1 || { tail ccx.log >&2; exit 1; }
"$build/benchmarks/growing_cylinder" compare segment.dat >table.md || failed=1
"$build/benchmarks/result_file" "A stenosed segment under a growing cylinder against CalculiX" \
  --command "benchmarks/calculix/growing_cylinder.sh BUILD_FOLDER" "${options[@]}" <table.md
exit $failed
