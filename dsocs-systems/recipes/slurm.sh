#!/bin/bash
# A sweep as an array of SLURM: sbatch slurm.sh plan.toml sweep/
#
# The folder is on a file system that all nodes see. A task computes what is missing of its share; a task that was killed is started
# again alone (sbatch --array=2 slurm.sh …) and then computes all that is missing. `dsocs sweep --status --out sweep/` says what that is.
#SBATCH --job-name=sweep
#SBATCH --array=1-4
#SBATCH --cpus-per-task=1
#SBATCH --output=sweep-%A-%a.log
set -euo pipefail
exec "${DSOCS:-dsocs}" sweep "$1" --out "$2"
