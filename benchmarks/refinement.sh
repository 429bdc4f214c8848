#!/usr/bin/env bash
# The layered wall's refinement: the same lesions at 16, 24 and 48 edges around, one after the other.
#
#   benchmarks/refinement.sh BUILD OUT [--edges "16 24 48"] [--jobs N] [--markdown FILE] [--numbers FILE]
#
# BUILD has bin/angio, benchmarks/case_table and refinement_table. OUT gets a case folder CASE-EDGES each; those that
# are done are kept. $ANGIO_DATA: the coronary lumen from X-ray angiography is run, too, if it is
# there. --jobs: so many at once, one thread each if more than 1 (default 1, all cores). --markdown
# gets the cases' table, --numbers that of every number. Exit codes: 0 done, whatever the cases gave;
# 64 usage.
set -euo pipefail

stop() {
  echo "refinement.sh: $1. Usage: benchmarks/refinement.sh BUILD OUT [--edges LIST] [--jobs N] [--markdown FILE] [--numbers FILE]" >&2
  exit 64
}

edges="16 24 48" jobs=1 markdown=() numbers=() folders=()
while [[ $# -gt 0 ]]; do
  case $1 in
    --edges | --jobs | --markdown | --numbers)
      [[ $# -gt 1 ]] || stop "$1 needs a value"
      case $1 in
        --markdown) markdown=(--markdown "$2") ;;
        --numbers) numbers=(--markdown "$2") ;;
        *) printf -v "${1#--}" %s "$2" ;;
      esac
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
  [concentric]="phantom:concentric,stenosis=60,noise=0"
  [unilateral]=phantom:unilateral
  [coronary]=phantom:coronary
)
for lumen in "${ANGIO_DATA:-}"/coronary-lumen-xra/*.stl; do
  [[ ! -e $lumen ]] || inputs[coronary-lumen]=$lumen
done

threads=()
[[ $jobs -eq 1 ]] || threads=(--threads 1)
run_case() { # FOLDER INPUT EDGES
  "$build/bin/angio" run "$2" -o "$1" --until simulation --quiet "${threads[@]}" \
    --set volume.fill=false --set simulation.guard=false --set simulation.write_every=1000 \
    --set mesh.edges_per_circumference="$3" || echo "refinement.sh: ${1##*/}: exit code $?" >&2
}

cases=()
for name in concentric unilateral coronary coronary-lumen; do
  [[ -n ${inputs[$name]:-} ]] || continue
  for around in $edges; do
    folder=$out/$name-$around
    cases+=("$folder")
    [[ ! -e $folder/simulation/simulation.pvd ]] || continue
    while [[ $(jobs -rp | wc -l) -ge $jobs ]]; do wait -n; done
    run_case "$folder" "${inputs[$name]}" "$around" &
  done
done
wait
"$build/benchmarks/case_table" "${cases[@]}" "${markdown[@]}"
"$build/benchmarks/refinement_table" "${cases[@]}" "${numbers[@]}"
