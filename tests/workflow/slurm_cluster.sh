#!/usr/bin/env bash
# A Slurm of this machine alone, for tests: a controller and two nodes on loopback. Needs Debian's slurm-wlm.
# Nothing of it outlives `stop`, and all its files lie in FOLDER.
#
#   slurm_cluster.sh start FOLDER        then: export SLURM_CONF=FOLDER/slurm.conf
#   slurm_cluster.sh kill-node FOLDER N  kills node N (1 or 2) and all that runs on it, as a power cut would
#   slurm_cluster.sh start-node FOLDER N
#   slurm_cluster.sh stop FOLDER
set -euo pipefail

usage() { sed -n '2,9s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2; exit 64; }
[[ $# -ge 2 ]] || usage
command=$1
mkdir -p "$2"
folder=$(realpath "$2")
export SLURM_CONF=$folder/slurm.conf
readonly kNodes=2 kPorts=17710

write_configuration() {
  local host cpus memory node
  host=$(hostname -s)
  cpus=$(nproc)
  memory=$(awk '/MemTotal/ { print int($2 / 1024 / 2) }' /proc/meminfo)
  mkdir -p "$folder"/{state,spool,log}
  cat > "$SLURM_CONF" <<EOF
ClusterName=angio_test
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$kPorts
# Nobody but this machine can reach it: no keys are needed.
AuthType=auth/none
CredType=cred/none
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool/%n
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd-%n.pid
SlurmctldLogFile=$folder/log/slurmctld
SlurmdLogFile=$folder/log/slurmd-%n
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
SlurmdParameters=config_overrides
SchedulerParameters=sched_interval=2,batch_sched_delay=1,requeue_setup_env_fail
JobRequeue=1
ReturnToService=2
SlurmdTimeout=8
KillWait=2
MinJobAge=3600
EOF
  for node in $(seq $kNodes); do
    echo "NodeName=n$node NodeHostname=$host NodeAddr=127.0.0.1 Port=$((kPorts + node)) CPUs=$cpus RealMemory=$memory"
  done >> "$SLURM_CONF"
  echo "PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP OverSubscribe=NO" >> "$SLURM_CONF"
}

start_node() {
  mkdir -p "$folder/spool/n$1"
  /usr/sbin/slurmd -N "n$1"
}

# The processes of a daemon's pid file, and those that it has started.
tree_of() {
  local child
  echo "$1"
  for child in $(pgrep -P "$1" || true); do tree_of "$child"; done
}

kill_node() {
  local name=n$1 job id ids
  ids=$(cat "$folder/slurmd-$name.pid")
  for job in $(squeue -h -t running -w "$name" -o %A); do
    for id in $(pgrep -f "^slurmstepd: \\[$job\\."); do ids+=" $(tree_of "$id" | tr '\n' ' ')"; done
  done
  kill -KILL $ids 2>/dev/null || true
  rm -f "$folder/slurmd-$name.pid"
}

case $command in
  start)
    write_configuration
    /usr/sbin/slurmctld -c
    for node in $(seq $kNodes); do start_node "$node"; done
    for _ in $(seq 60); do
      [[ $(sinfo -h -t idle -o %D 2>/dev/null) == "$kNodes" ]] && exit 0
      sleep 0.5
    done
    echo "slurm_cluster.sh: the nodes did not come up (see $folder/log)" >&2
    exit 1 ;;
  kill-node) kill_node "$3" ;;
  start-node) start_node "$3" ;;
  stop)
    scancel --user "$(id -un)" 2>/dev/null || true
    sleep 1
    for pid in "$folder"/*.pid; do [[ -f $pid ]] && kill "$(cat "$pid")" 2>/dev/null || true; done ;;
  *) usage ;;
esac
