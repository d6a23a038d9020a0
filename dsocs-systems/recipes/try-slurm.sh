#!/bin/bash
# Tests slurm.sh on a SLURM of one node, which it installs and starts itself (Debian, as root, without systemd). It runs an array of four tasks; one
# is killed and started again. Then no part may be missing, and every table must equal that of a single process.
#
# DSOCS=/path/to/dsocs try-slurm.sh          also with Dask, if its second word is `dask` (pip install distributed dask-jobqueue)
set -euo pipefail
recipes=$(cd "$(dirname "$0")" && pwd)
: "${DSOCS:?the program}"
export DSOCS
work=$(mktemp -d)
host=$(hostname -s)
started=()
finish() {
    for process in "${started[@]}"; do kill "$process" 2>/dev/null || true; done
    rm -rf "$work"
}
trap finish EXIT

if ! command -v slurmctld >/dev/null || ! command -v munged >/dev/null; then
    apt-get update -qq
    DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends slurmctld slurmd slurm-client munge >/dev/null
fi

# munge: a key, and its service
mkdir -p "$work/munge" && chmod 755 "$work" "$work/munge"
dd if=/dev/urandom of="$work/munge/key" bs=1024 count=1 status=none
chmod 600 "$work/munge/key"
munged --foreground --force --key-file="$work/munge/key" --socket="$work/munge/socket" --pid-file="$work/munge/pid" \
    --log-file="$work/munge/log" --seed-file="$work/munge/seed" &
started+=($!)

# slurm: one node that runs four tasks at a time
mkdir -p "$work/slurm/state" "$work/slurm/spool"
cat >"$work/slurm/slurm.conf" <<END
ClusterName=try
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$work/munge/socket
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=2
KillWait=2
ReturnToService=2
SlurmctldPort=16817
SlurmdPort=16818
StateSaveLocation=$work/slurm/state
SlurmdSpoolDir=$work/slurm/spool
SlurmctldPidFile=$work/slurm/slurmctld.pid
SlurmdPidFile=$work/slurm/slurmd.pid
SlurmctldLogFile=$work/slurm/slurmctld.log
SlurmdLogFile=$work/slurm/slurmd.log
SlurmdParameters=config_overrides
NodeName=$host NodeAddr=127.0.0.1 CPUs=4 RealMemory=4000 State=UNKNOWN
PartitionName=all Nodes=$host Default=YES MaxTime=INFINITE State=UP
END
export SLURM_CONF=$work/slurm/slurm.conf
until [ -S "$work/munge/socket" ]; do sleep 0.1; done
slurmctld -D -f "$SLURM_CONF" &
started+=($!)
slurmd -D -f "$SLURM_CONF" -N "$host" &
started+=($!)
for _ in $(seq 60); do
    if sinfo -h -o %t 2>/dev/null | grep -q idle; then break; fi
    sleep 0.5
done
sinfo

cat >"$work/plan.toml" <<END
system = "pendulum"
step = 0.01
until = 400
part = 4
[vary]
theta = { from = -1, to = 1, count = 64 }
v_psi = [0.25, 0.5, 0.75]
END
cd "$work"
"$DSOCS" sweep plan.toml --out alone --threads 2

waited() { while squeue -h | grep -q .; do sleep 0.5; done; }
compared() { diff -r alone/points "$1/points" && echo "$1: the same bytes"; }

job=$(sbatch --parsable "$recipes/slurm.sh" plan.toml array)
echo "array $job"
# when its first part is there, the second task is killed
until [ -n "$(ls array/points/*.parquet 2>/dev/null)" ]; do sleep 0.1; done
scancel --signal=KILL --full "${job}_2"
waited
if "$DSOCS" sweep --status --out array; then
    echo "the task was done before it was killed: nothing is tried" && exit 1
fi
sbatch --array=2 "$recipes/slurm.sh" plan.toml array
waited
"$DSOCS" sweep --status --out array
cat sweep-*.log
compared array

if [ "${1:-}" = dask ]; then
    python3 "$recipes/dask_slurm.py" plan.toml dask --shards 8 --workers 3 &
    dask=$!
    until [ -n "$(ls dask/points/*.parquet 2>/dev/null)" ]; do sleep 0.2; done
    # a worker is killed with all that it runs
    worker=$(squeue -h -t running -o %i | head -1)
    echo "worker $worker is killed"
    scancel --signal=KILL --full "$worker"
    wait "$dask"
    compared dask
fi
echo "slurm: passed"
