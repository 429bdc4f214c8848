#!/usr/bin/env bash
# Compares the balloon's membrane with CalculiX (Debian package calculix-ccx) on a sphere, the same mesh,
# and on a capsule, meshes against a finer one of revolution. Fails above 1 %.
# usage: benchmarks/calculix/balloon_membrane.sh BUILD_FOLDER [--markdown FILE]
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/prepare.sh"
failed=0
for shape in sphere capsule; do
  "$build/benchmarks/balloon_membrane" write $shape $shape.inp
  ccx $shape >ccx.log 2>&1 || { tail -5 ccx.log >&2; exit 1; }
  "$build/benchmarks/balloon_membrane" compare $shape $shape.dat >>table.md || failed=1
done
"$build/benchmarks/result_file" "The balloon's membrane against CalculiX" \
  --command "benchmarks/calculix/balloon_membrane.sh BUILD_FOLDER" "${options[@]}" <table.md
exit $failed
