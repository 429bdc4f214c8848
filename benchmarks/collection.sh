#!/usr/bin/env bash
# Runs the program on the whole collection, and writes its table and contact sheets.
#
#   benchmarks/collection.sh FOLDER OUT [--split dev|heldout|all] [--until STAGE] [--jobs N]
#                            [--only CASE,...] [--limit SECONDS] [--again] [--build DIR]
#                            [--markdown FILE]
#
# FOLDER: what datasets/fetch_public_data.sh fetched. OUT gets a case folder a file, logs/, runs.csv,
# collection.csv, collection.md, index.html and sheets/. Cases that ran before are kept (--again runs
# them again), so a call that was cut off goes on. A case that fails stops none of the others.
# --markdown also writes the table to FILE, with commit, machine and command at its head.
# By default: --split dev --jobs 1 --limit 1800 --build build/release. docs/collection.md explains.
# Exit codes: 0 done, whatever the cases gave; 64 usage; 66 no data.
set -uo pipefail

source_folder=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
readonly source_folder
readonly readings=$source_folder/datasets/public_readings.csv
readonly ends=$source_folder/datasets/public_ends.csv
split=dev until='' jobs=1 only='' limit=1800 again='' markdown='' build=$source_folder/build/release
folders=()
command="benchmarks/collection.sh"
for word in "$@"; do
  case $word in /*) word=${word##*/} ;; esac
  command+=" $word"
done
readonly command

stop() {
  echo "collection.sh: $2" >&2
  exit "$1"
}

while [[ $# -gt 0 ]]; do
  case $1 in
    --split | --until | --jobs | --only | --limit | --build | --markdown)
      [[ $# -gt 1 ]] || stop 64 "$1 needs a value"
      printf -v "${1#--}" %s "$2"
      shift
      ;;
    --again) again=yes ;;
    -*) stop 64 "unknown option $1; the head of this file lists them" ;;
    *) folders+=("$1") ;;
  esac
  shift
done
[[ ${#folders[@]} -eq 2 ]] || stop 64 "a folder with the data and one for the results are needed"
case $split in dev | heldout | all) ;; *) stop 64 "no split '$split': dev, heldout or all" ;; esac
readonly from=${folders[0]} out=${folders[1]}
[[ -d $from ]] || stop 66 "no folder $from. Fetch the data with datasets/fetch_public_data.sh"
for program in bin/angio benchmarks/collection_table benchmarks/contact_sheet; do
  [[ -x $build/$program ]] || stop 64 "$build/$program is missing. Build it, or name another --build"
done
mkdir -p "$out/logs" "$out/runs" "$out/sheets" || exit 73

# input_of CASE FILE: where the file lies; a series of DICOM slices is its folder; empty: not here
input_of() {
  local found
  found=$(find -L "$from" -path "*/$1/*" -name "$2" -type f 2>/dev/null | sort | head -n 1)
  [[ -n $found ]] || return 0
  # Raw voxels have no header: the same volume as DICOM lies beside them.
  if [[ $2 == *.raw.gz || $2 == *.raw ]]; then found=$(dirname "$found")/dicom; fi
  if [[ $2 == *.dcm ]]; then found=$(dirname "$found"); fi
  [[ -e $found ]] && printf '%s\n' "$found"
}

# name_of CASE FILE: of the case folder; the file is part of it where a case has several
name_of() {
  if [[ $(grep -c "^$1," "$readings") -gt 1 ]]; then
    local stem=${2%%.*}
    printf '%s_%s\n' "$1" "${stem//[^A-Za-z0-9_-]/_}"
  else
    printf '%s\n' "$1"
  fi
}

# run_case CASE FILE: leaves runs/NAME.csv, one row
run_case() {
  local name input code wall user system TIMEFORMAT='%R %U %S'
  name=$(name_of "$1" "$2")
  [[ -n $again || ! -s $out/runs/$name.csv ]] || return 0
  input=$(input_of "$1" "$2")
  if [[ -z $input ]]; then
    echo "missing  $1/$2" >&2
    return 0
  fi
  local options=(--force)
  [[ -z $until ]] || options+=(--until "$until")
  rm -rf "${out:?}/$name"
  {
    time timeout --kill-after=20 "$limit" "$build/bin/angio" run "$input" -o "$out/$name" \
      "${options[@]}" >"$out/logs/$name.log" 2>&1
    code=$?
  } 2>"$out/runs/$name.time"
  code=${code:-1}
  # The shell tells of a run that was killed before its times.
  read -r wall user system < <(tail -n 1 "$out/runs/$name.time")
  rm -f "$out/runs/$name.time"
  printf '"%s",%s,"%s","%s",%s,%s,%s\n' "$out/$name" "$1" "$2" "$input" "$code" "$wall" \
    "$(awk "BEGIN { print $user + $system }")" >"$out/runs/$name.csv"
  printf '%-8s %s (%.0f s)\n' "exit $code" "$name" "$wall" >&2
}

is_wanted() {
  [[ $split == all || $split == "$2" ]] && [[ -z $only || ,$only, == *",$1,"* ]]
}

wanted=()
running=0
while IFS=, read -r case file row_split _; do
  [[ $case != case ]] && is_wanted "$case" "$row_split" || continue
  wanted+=("$(name_of "$case" "$file")")
  run_case "$case" "$file" </dev/null &
  running=$((running + 1))
  if [[ $running -ge $jobs ]]; then
    wait -n
    running=$((running - 1))
  fi
done <"$readings"
wait
[[ ${#wanted[@]} -gt 0 ]] || stop 64 "no case of that name and split in $readings"

echo folder,case,file,input,exit_code,wall_s,cpu_s >"$out/runs.csv"
case_folders=()
for name in "${wanted[@]}"; do
  [[ -s $out/runs/$name.csv ]] || continue
  cat "$out/runs/$name.csv" >>"$out/runs.csv"
  case_folders+=("$out/$name")
done
[[ ${#case_folders[@]} -gt 0 ]] || stop 66 "none of the files lies in $from. Fetch them with datasets/fetch_public_data.sh"
table_options=()
[[ -z $markdown ]] || table_options=(--markdown "$markdown" --command "$command")
"$build/benchmarks/collection_table" "$out/runs.csv" "$readings" "$ends" -o "$out" \
  "${table_options[@]}" >/dev/null
"$build/benchmarks/contact_sheet" "${case_folders[@]}" -o "$out/sheets" --logs "$out/logs" \
  --table "$out/collection.csv" >/dev/null
printf '%s\n' "$out/collection.md" "$out/sheets/index.html"
