#!/usr/bin/env bash
# Compares the balloon's membrane with FEniCSx (Debian package python3-dolfinx) on the same meshes.
# usage: benchmarks/fenicsx/balloon_membrane.sh BUILD_FOLDER
set -euo pipefail
program=$(realpath "$1")/benchmarks/balloon_membrane
script=$(realpath "$(dirname "$0")")/balloon_membrane.py
python=${PYTHON:-/usr/bin/python3} # Debian's, which sees Debian's packages
if ! "$python" -c "import dolfinx" 2>/dev/null; then
  echo "no FEniCSx here: apt-get install python3-dolfinx" >&2
  exit 69
fi
log=$(mktemp)
trap 'rm -f "$log"' EXIT
failed=0
for balloon in "sphere 0" "capsule 16" "capsule 32" "capsule 64"; do
  # shellcheck disable=SC2086
  OMP_NUM_THREADS=${OMP_NUM_THREADS:-2} "$program" solve $balloon |
    "$python" "$script" "${balloon% *}" 2>"$log" || { tail -3 "$log" >&2; failed=1; }
done
exit $failed
