# shellcheck shell=bash
# How many compilers at once: one a core, each with 1.5 GB of the free memory (Ceres needs it).
build_jobs() {
    local cores memory_kb jobs
    cores=$(nproc)
    memory_kb=$(awk '$1 == "MemAvailable:" { print $2 }' /proc/meminfo)
    jobs=$((memory_kb / 1500000))
    [ "$jobs" -ge 1 ] || jobs=1
    [ "$jobs" -le "$cores" ] || jobs=$cores
    echo "$jobs"
}
