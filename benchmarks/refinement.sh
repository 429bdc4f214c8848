#!/usr/bin/env bash
# The layered wall's refinement: the same lesions at 16, 24 and 48 edges around, one after the other.
#
#   benchmarks/refinement.sh BUILD OUT [--edges "16 24 48"] [--markdown FILE]
#
# BUILD has bin/angio and benchmarks/case_table. OUT gets a case folder CASE-EDGES each; those that
# are done are kept. $ANGIO_DATA: the coronary lumen from X-ray angiography is run, too, if it is
# there. Exit codes: 0 done, whatever the cases gave; 64 usage.
set -euo pipefail

stop() {
  echo "refinement.sh: $1. Usage: benchmarks/refinement.sh BUILD OUT [--edges LIST] [--markdown FILE]" >&2
  exit 64
}

edges="16 24 48" markdown=() folders=()
while [[ $# -gt 0 ]]; do
  case $1 in
    --edges | --markdown)
      [[ $# -gt 1 ]] || stop "$1 needs a value"
      if [[ $1 = --edges ]]; then edges=$2; else markdown=(--markdown "$2"); fi
      shift
      ;;
    -*) stop "unknown option $1" ;;
    *) folders+=("$1") ;;
  esac
  shift
done
[[ ${#folders[@]} -eq 2 ]] || stop "a build and a folder for the results are needed"
readonly build=${folders[0]} out=${folders[1]}
[[ -x $build/bin/angio && -x $build/benchmarks/case_table ]] || stop "$build has no angio or no case_table"
mkdir -p "$out"

declare -A inputs=(
  [concentric]=phantom:concentric,stenosis=60,noise=0
  [unilateral]=phantom:unilateral
  [coronary]=phantom:coronary
)
lumen=$(find -L "${ANGIO_DATA:-/nowhere}/coronary-lumen-xra" -name '*.stl' 2>/dev/null | sort | head -n 1)
[[ -z $lumen ]] || inputs[coronary-lumen]=$lumen

cases=()
for name in concentric unilateral coronary coronary-lumen; do
  [[ -n ${inputs[$name]:-} ]] || continue
  for around in $edges; do
    folder=$out/$name-$around
    cases+=("$folder")
    [[ ! -e $folder/simulation/simulation.pvd ]] || continue
    "$build/bin/angio" run "${inputs[$name]}" -o "$folder" --until simulation --quiet \
      --set volume.fill=false --set simulation.guard=false --set simulation.write_every=1000 \
      --set mesh.edges_per_circumference="$around" || echo "refinement.sh: $name-$around: exit code $?" >&2
  done
done
"$build/benchmarks/case_table" "${cases[@]}" "${markdown[@]}"
