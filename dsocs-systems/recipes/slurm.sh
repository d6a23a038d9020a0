#!/bin/bash
# A sweep as an array of SLURM: sbatch slurm.sh plan.toml sweep/
#
# The folder is on a file system that all nodes see. A task computes the missing parts of its share. If a task was killed, start it again as an
# array of one (sbatch --array=2 slurm.sh …): it then computes all missing parts. `dsocs sweep --status --out sweep/` says which are missing.
#SBATCH --job-name=sweep
#SBATCH --array=1-4
#SBATCH --cpus-per-task=1
#SBATCH --output=sweep-%A-%a.log
set -euo pipefail
exec "${DSOCS:-dsocs}" sweep "$1" --out "$2"
