#!/bin/bash
# A sweep on several machines by GNU parallel: parallel.sh plan.toml sweep/ 16 [machines]
#
# `machines` is a file of names for ssh, one per line (`2/name` for two processes on that machine). Without it all processes run on this machine.
# Plan and folder are on a file system that all machines see.
set -euo pipefail
plan=$1 out=$2 shards=$3
where=()
if [ $# -gt 3 ]; then where=(--sshloginfile "$4" --workdir "$PWD"); fi
seq "$shards" | parallel "${where[@]}" --retries 3 "${DSOCS:-dsocs}" sweep "$plan" --out "$out" --threads 1 --shard "{}/$shards"
"${DSOCS:-dsocs}" sweep --status --out "$out"
