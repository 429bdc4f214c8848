#!/usr/bin/env bash
# A cohort as one array of Slurm jobs, without Snakemake.
#
#   workflow/slurm_array.sh COHORT.csv DIR [OPTIONS of `angio batch`]
#
# Environment: CASES_PER_JOB (1), JOBS_AT_A_TIME (50), THREADS (4), MEMORY_MIB (8000), MINUTES (240),
# PROGRAM (angio), ANGIO_SBATCH (further options of sbatch). Prints the number of the array. When it has ended:
# `angio batch COHORT.csv -o DIR --summary-only`. The same command goes on.
set -euo pipefail

if [[ -z ${SLURM_ARRAY_TASK_ID:-} ]]; then
  [[ $# -ge 2 ]] || { sed -n '2,9s/^# \{0,1\}//p' "$0" >&2; exit 64; }
  rows=$(sed -e '1s/^\xEF\xBB\xBF//' -e '/^#/d' -e '/^[;, \t\r]*$/d' "$1" | wc -l)
  jobs=$(( (rows - 1 + ${CASES_PER_JOB:-1} - 1) / ${CASES_PER_JOB:-1} ))
  mkdir -p "$2/logs/jobs"
  exec sbatch --parsable --requeue --job-name=angio --array="1-$jobs%${JOBS_AT_A_TIME:-50}" \
    --cpus-per-task="${THREADS:-4}" --mem="${MEMORY_MIB:-8000}" --time="${MINUTES:-240}" \
    --output="$2/logs/jobs/array-%a.txt" --export=ALL,ANGIO_ARRAY_JOBS="$jobs" ${ANGIO_SBATCH:-} \
    "$0" "$(realpath "$1")" "$(realpath "$2")" "${@:3}"
fi

manifest=$1 folder=$2
shift 2
status=0
"${PROGRAM:-angio}" batch "$manifest" -o "$folder" --shard "$SLURM_ARRAY_TASK_ID/$ANGIO_ARRAY_JOBS" --resume \
  --engine --quiet -j 1 --threads "${SLURM_CPUS_PER_TASK:-1}" "$@" || status=$?
# The machine's fault, not the data's: once more, up to three times.
if [[ $status -eq 75 && ${SLURM_RESTART_COUNT:-0} -lt 3 ]]; then
  scontrol requeue "${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID"
fi
exit $status
