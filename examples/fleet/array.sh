#!/usr/bin/env bash
#SBATCH --array=0-49
#SBATCH --cpus-per-task=1
#SBATCH --time=01:00:00
#
# Traces a fleet's logs as an array of Slurm, with the command line alone:
#
#     sbatch array.sh MODEL LOGS ANSWERS
#
# Task k of n takes the logs k, k + n, k + 2 n … that have no answer yet, or an old one. The answers
# are those of `fleet.py`. Tasks that were killed are begun again by the same command.
set -euo pipefail

model=$1 logs=$2 answers=$3
export RAYON_NUM_THREADS=${SLURM_CPUS_PER_TASK:-1}

# A model with a fault is no fault of the logs: it ends the task here.
dynamics check "$model" >/dev/null
mkdir -p "$answers"

is_done() {
    [[ -e $1 && ! $1 -ot $log && ! $1 -ot $model ]]
}

failed=0 number=0
for log in "$logs"/*.csv; do
    if ((number++ % SLURM_ARRAY_TASK_COUNT != SLURM_ARRAY_TASK_ID)); then
        continue
    fi
    name=$(basename "$log" .csv)
    answer=$answers/$name
    if is_done "$answer.json" || is_done "$answer.error"; then
        continue
    fi
    part=$answers/.$name.$$
    code=0
    dynamics trace "$model" "$log" --json >"$part.json" 2>"$part.error" || code=$?
    case $code in
        0) mv "$part.json" "$answer.json" && rm -f "$part.error" "$answer.error" ;;
        # The log cannot be used: that is its answer.
        2) mv "$part.error" "$answer.error" && rm -f "$part.json" "$answer.json" ;;
        *) cat "$part.error" >&2 && rm -f "$part".* && failed=1 ;;
    esac
done
exit $failed
