#!/usr/bin/env bash
# status.sh JOB: running, success or failed, in Snakemake's words. A job that Slurm has put back into its queue
# is running; one that nobody knows any more, or that cannot be asked for now, may be.
state=$(scontrol -o show job "${1%%;*}" 2>/dev/null | grep -o 'JobState=[A-Z_]*' | cut -d= -f2)
[[ -n $state ]] || state=$(sacct -nXPj "${1%%;*}" -o State 2>/dev/null | head -1 | cut -d' ' -f1)
case ${state:-UNKNOWN} in
  COMPLETED) echo success ;;
  PENDING|RUNNING|CONFIGURING|COMPLETING|SUSPENDED|REQUEUED|REQUEUE_HOLD|RESIZING|UNKNOWN) echo running ;;
  *) echo failed ;;
esac
