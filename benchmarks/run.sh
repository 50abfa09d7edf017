#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# Builds the benchmarks for this machine's processor and runs them: long, above all caches of the park. Two of them print
# some rows alone: lightmesh-cache-benchmark by numbers of its cases, or `walks`; lightmesh-moving-benchmark by what their
# names begin with, such as Linked.
#
#   benchmarks/run.sh                        all rows; writes build/benchmarks/results/
#   benchmarks/run.sh --benchmark_filter=... options for Google Benchmark; writes nothing
#
# LIGHTMESH_BUILD_DIR: where to build, instead of build/ beside this folder.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(dirname "$here")
build=${LIGHTMESH_BUILD_DIR:-$root/build}/benchmarks
results=$build/results

"$root/cmake/setup-debian.sh" benchmarks
cmake -S "$root" -B "$build" -DCMAKE_BUILD_TYPE=Release -DLIGHTMESH_NATIVE=ON -DLIGHTMESH_BUILD_TESTS=OFF
cmake --build "$build" --target lightmesh-benchmarks lightmesh-mesh-benchmark \
    lightmesh-mesh-benchmark-o2 lightmesh-first-frame-benchmark lightmesh-break-even-benchmark lightmesh-cache-benchmark \
    lightmesh-moving-benchmark lightmesh-random-moves-benchmark lightmesh-render --parallel "$(nproc)"
program=$build/benchmarks/lightmesh-benchmarks

echo
echo "Debian builds its Google Benchmark without optimisation, and says so below: it does no harm, since each"
echo "row takes its own time over one long pass."
if [ $# -gt 0 ]; then
    exec "$program" --benchmark_counters_tabular=true "$@"
fi

report=$build/report.json
"$program" --benchmark_counters_tabular=true --benchmark_enable_random_interleaving=true \
    --benchmark_out="$report" --benchmark_out_format=json

mkdir -p "$results"
# The machine's kind matters, its name and folders do not; nor do means, which a moment of noise spoils.
jq 'del(.context.host_name, .context.executable)
    | .benchmarks |= map(select(.run_type == "iteration" or .aggregate_name == "min" or .aggregate_name == "median"))' \
    "$report" >"$results/benchmarks.json"
jq -r -L "$here" -f "$here/plot.jq" "$results/benchmarks.json" >"$build/times.txt"
machine=$(jq -r '.context | "\(.processor), \(.compiler), Embree \(.Embree)"' "$results/benchmarks.json")
gnuplot -e "data='$build/times.txt'; picture='$results/time-per-point.svg'; machine='$machine'" "$here/plot.gp"
jq -r -L "$here" -f "$here/figures.jq" "$results/benchmarks.json" >"$results/figures.md"

echo
cat "$results/figures.md"
jq -r '.benchmarks[] | select(.error_occurred) | "not timed: \(.run_name): \(.error_message)"' "$results/benchmarks.json"
echo "Written: $results/benchmarks.json, figures.md, time-per-point.svg"

failed=()
# print_table FILE PROGRAM [ARGUMENTS...]: a program's table, here and at the end of a file. The others run even if one
# fails.
print_table() {
    if [ ! -e "$results/$1" ]; then
        echo
    fi
    "$build/benchmarks/$2" "${@:3}" | tee -a "$results/$1" || failed+=("$2")
}
rm -f "$results"/{flat-mesh,first-frame,break-even,visibility-cache,moving}.md
print_table flat-mesh.md lightmesh-mesh-benchmark
# times_of_both: three lines of times built by -O2 alone and for this processor
times_of_both() {
    local o2 native
    for _ in 1 2 3; do
        o2=$("$build/benchmarks/lightmesh-mesh-benchmark-o2" --times) || return
        native=$("$build/benchmarks/lightmesh-mesh-benchmark" --times) || return
        echo "$o2 $native"
    done
}
times_of_both | awk '{ ratio = $1 / $2; if (NR == 1 || ratio < least) { least = ratio; o2 = $1; native = $2 } }
    END { if (NR < 3) exit
          printf "| -O2 alone over built for the processor: Express and Linked, park and rooms, warm, mean of ratios |"
          printf " %.3g | <= 1.1 | %s | %s and %s ns a point |\n", least, least <= 1.1 ? "yes" : "no", o2, native }' |
    tee -a "$results/flat-mesh.md" || failed+=("lightmesh-mesh-benchmark --times")
print_table first-frame.md lightmesh-first-frame-benchmark
print_table break-even.md lightmesh-break-even-benchmark
print_table visibility-cache.md lightmesh-cache-benchmark
print_table moving.md lightmesh-moving-benchmark
print_table moving.md lightmesh-random-moves-benchmark

# Films by four processes of one thread and by one: what is counted is the same on any number of cores.
if command -v mpirun >/dev/null; then
    films=$(mktemp -d)
    trap 'rm -rf "$films"' EXIT
    # counts RANKS NAME OPTIONS...: frames, rays
    counts() {
        mpirun --allow-run-as-root --oversubscribe --bind-to none -n "$1" "$build/examples/lightmesh-render" film "${@:3}" \
            --threads 1 -o "$films/$2-$1" 2>/dev/null |
            sed -n 's/,//g; s/^frames rendered  *//p; s/^rays for shadows  *//p' | xargs
    }
    # compare NAME OPTIONS...: the name, what one rank and four count, and how many files differ
    compare() {
        local one four differing
        one=$(counts 1 "$@") || return
        four=$(counts 4 "$@") || return
        differing=$(diff -rq "$films/$1-1" "$films/$1-4" || [ $? -eq 1 ]) || return
        echo "$1 $one $four $(grep -c . <<<"$differing")"
    }
    {
        compare spheres spheres --frames 16 --fps 8 --width 480 --height 360 &&
            compare rooms rooms --frames 16 --fps 8 --width 480 --height 360 &&
            compare park park -a linked --frames 48 --width 320 --height 240
    } | awk '{ frames = $4 / $2; rays = $5 / $3
        printf "| 4 ranks over 1, rays: a film of %s | %.3g | <= 1.1 | %s |", $1, rays, rays <= 1.1 ? "yes" : "no"
        printf " frames %.3g; %d and %d rays; %d files differ |\n", frames, $5, $3, $6 }' |
        tee -a "$results/moving.md" || failed+=("films by several processes")
fi

if [ ${#failed[@]} -gt 0 ]; then
    printf 'failed: %s\n' "${failed[@]}" >&2
    exit 1
fi
