#!/usr/bin/env bash
# Compares the balloon's membrane with FEniCSx (Debian package python3-dolfinx) on the same meshes.
# usage: benchmarks/fenicsx/balloon_membrane.sh BUILD_FOLDER [--markdown FILE]
set -euo pipefail
build=$(realpath "$1")
script=$(realpath "$(dirname "$0")")/balloon_membrane.py
python=${PYTHON:-/usr/bin/python3} # Debian's, which sees Debian's packages
if ! "$python" -c "import dolfinx" 2>/dev/null; then
  echo "no FEniCSx here: apt-get install python3-dolfinx" >&2
  exit 69
fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
failed=0
{
  echo "Differences in parts of the largest displacement."
  echo
  echo "| balloon | vertices | largest displacement mm | at most | bar | |"
  echo "|---|---|---|---|---|---|"
} >"$folder/table.md"
for balloon in "sphere 0" "capsule 16" "capsule 32" "capsule 64"; do
  # shellcheck disable=SC2086
  OMP_NUM_THREADS=${OMP_NUM_THREADS:-2} "$build/benchmarks/balloon_membrane" solve $balloon |
    "$python" "$script" "${balloon% *}" 2>"$folder/log" >>"$folder/table.md" ||
    { tail -3 "$folder/log" >&2; failed=1; }
done
"$build/benchmarks/result_file" "The balloon's membrane against FEniCSx" \
  --command "benchmarks/fenicsx/balloon_membrane.sh BUILD_FOLDER" "${@:2}" <"$folder/table.md"
exit $failed
