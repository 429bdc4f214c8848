#!/usr/bin/env bash
# A cohort on a real Slurm of this machine: a node is killed in the middle of it, Snakemake in the middle of
# another, and both must be complete afterwards and equal to `angio batch`'s.
#
#   slurm_trial.sh ANGIO FOLDER [CASES, 20] [UNTIL, centerline]
#
# Needs Debian's slurm-wlm and snakemake; exit code 77 (skipped) without them.
set -euo pipefail
[[ $# -ge 2 ]] || { sed -n '2,8s/^# \{0,1\}//p' "$0" >&2; exit 64; }
here=$(realpath "$(dirname "${BASH_SOURCE[0]}")")
program=$(realpath "$1")
cases=${3:-20} until=${4:-centerline}
command -v slurmctld >/dev/null && command -v snakemake >/dev/null || { echo "no slurm-wlm or snakemake"; exit 77; }
mkdir -p "$2"
folder=$(realpath "$2")
cd "$folder"

write_manifest() {
  local kinds=(straight concentric unilateral bilateral tandem) case
  echo "case,input,preset"
  for case in $(seq "$cases"); do
    echo "case$case,\"phantom:${kinds[case % 5]},length=20,spacing=0.4,stenosis=$((30 + case * 2)),seed=$case\",draft"
  done
}

run_snakemake() {  # OUTPUT
  snakemake -s "$here/../../workflow/Snakefile" --profile "$here/../../workflow/profiles/slurm" \
    --configfile asked.yaml --latency-wait 5 --max-status-checks-per-second 2 \
    --config manifest=cohort.csv output="$1" program="$program" until="$until" > "$1.log" 2>&1
}

done_in() { find "$1/logs" -maxdepth 1 -name '*.done' 2>/dev/null | wc -l; }

wait_for_done() {  # OUTPUT COUNT
  until [[ $(done_in "$1") -ge $2 ]]; do sleep 0.2; done
}

write_manifest > cohort.csv
echo "resources:
  case: {threads: 1, memory_mib: 1500, minutes: 30, gpus: 0}" > asked.yaml
"$here/slurm_cluster.sh" start "$folder/cluster"
export SLURM_CONF=$folder/cluster/slurm.conf
trap '"$here/slurm_cluster.sh" stop "$folder/cluster"' EXIT

echo "a node is killed"
start=$SECONDS
run_snakemake node & runner=$!
wait_for_done node $((cases / 3))
until squeue -h -t running -w n2 -o %A | grep -q .; do sleep 0.2; done
"$here/slurm_cluster.sh" kill-node "$folder/cluster" 2
echo "  node n2 killed after $(done_in node) of $cases cases, $((SECONDS - start)) s"
sleep 12
"$here/slurm_cluster.sh" start-node "$folder/cluster" 2
wait $runner
echo "  complete after $((SECONDS - start)) s, $(done_in node) of $cases done"

echo "Snakemake is killed, and started again by the same command"
run_snakemake killed & runner=$!
wait_for_done killed $((cases / 3))
kill -KILL $(pgrep -P $runner) $runner 2>/dev/null || true
wait $runner 2>/dev/null || true
echo "  killed after $(done_in killed) of $cases cases"
run_snakemake killed
echo "  $(done_in killed) of $cases done"

echo "an array of jobs, without Snakemake"
array=$(THREADS=1 MEMORY_MIB=1500 PROGRAM=$program "$here/../../workflow/slurm_array.sh" cohort.csv array --until "$until")
while squeue -h -j "$array" 2>/dev/null | grep -q .; do sleep 0.5; done
"$program" batch cohort.csv -o array --summary-only --quiet || [[ $? -eq 2 ]]

echo "angio batch, alone"
"$program" batch cohort.csv -o alone -j 2 --until "$until" --quiet > /dev/null || [[ $? -eq 2 ]]
status=0
for other in node killed array; do
  echo -n "$other against alone: "
  "$here/compare_batches.py" alone "$other" || status=1
done
exit $status
