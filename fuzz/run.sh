#!/usr/bin/env bash
# fuzz/run.sh FOLDER SECONDS: runs each fuzzer of FOLDER (fuzz/build.sh) for so long, one after the other.
# FOLDER/found/TARGET gets the corpus that grows, FOLDER/crashes the inputs that crashed, hung or took gigabytes (a
# fuzzer goes on after them), FOLDER/time.csv the processor's seconds and the executions. Exit code 1 if there are any.
set -euo pipefail
folder=$(realpath "${1:?fuzz/run.sh FOLDER SECONDS}") seconds=${2:?fuzz/run.sh FOLDER SECONDS}
source=$(realpath "$(dirname "${BASH_SOURCE[0]}")")
mkdir -p "$folder/crashes" "$folder/log"
for program in "$folder"/*_fuzzer; do
  name=$(basename "$program" _fuzzer)
  mkdir -p "$folder/found/$name"
  TIMEFORMAT='%U %S'
  # Detecting leaks needs the right to trace; one that matters ends as too much memory.
  used=$( { time ASAN_OPTIONS=detect_leaks=0:allocator_may_return_null=1 nice -n 19 "$program" \
    -fork=1 -ignore_crashes=1 -ignore_timeouts=1 -ignore_ooms=1 -max_total_time="$seconds" -timeout=20 -rss_limit_mb=3000 -max_len=65536 \
    -artifact_prefix="$folder/crashes/$name-" "$folder/found/$name" "$source/corpus/$name" \
    > "$folder/log/$name" 2>&1 || true; } 2>&1 )
  runs=$(grep -ao '^#[0-9]*: cov' "$folder/log/$name" | tail -1 | tr -dc '0-9' || true)
  echo "$name,$(awk -v used="$used" 'BEGIN { split(used, t, " "); print t[1] + t[2] }'),${runs:-0}" >> "$folder/time.csv"
done
awk -F, '{ seconds += $2; runs += $3 } END { printf "%.2f processor hours, %d executions in all\n", seconds / 3600, runs }' \
  "$folder/time.csv"
[[ -z $(ls "$folder/crashes") ]]
