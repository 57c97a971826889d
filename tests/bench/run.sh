#!/bin/sh
# Builds the benchmarks, runs them, writes their CSV files and what they ran on to tests/bench/results/, and draws
# tests/bench/charts/. Nothing else should run meanwhile.
#   --quick           three to four minutes: the eel, fewer figures and repetitions; otherwise about 50 minutes
#   --results DIR     where CSV files and machine.txt go, --charts DIR where the SVG files go
#   DQA_TEST_DATA     folder of Orca.stl and GreatWhiteShark.stl; default ../shared/data if there, left out otherwise
set -eu
cd "$(dirname "$0")/../.."
quick=
results=tests/bench/results
charts=tests/bench/charts
while [ $# -gt 0 ]; do
    case $1 in
        --quick) quick=--quick ;;
        --results) results=$2; shift ;;
        --charts) charts=$2; shift ;;
        *) echo "run.sh: unknown option $1; the first lines list them" >&2; exit 2 ;;
    esac
    shift
done
if [ -z "${DQA_TEST_DATA:-}" ] && [ -d ../shared/data ]; then
    DQA_TEST_DATA=$(cd ../shared/data && pwd)
fi
export DQA_TEST_DATA="${DQA_TEST_DATA:-}"
export OPENBLAS_NUM_THREADS=1

tests/setup.sh
cmake --preset default >/dev/null
build=build/default
programs="bench_step bench_parts bench_rollout bench_barycenter stability_map"
# shellcheck disable=SC2086  # the list is meant to be split
cmake --build --preset default --target $programs

mkdir -p "$results"
rm -f "$results"/*.csv "$results/machine.txt"
{
    date -u +%Y-%m-%d
    echo "processor: $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1)"
    echo "cores: $(nproc)"
    echo "memory: $(sed -n 's/^MemTotal: *//p' /proc/meminfo)"
    echo "compiler: $("${CXX:-c++}" --version | head -n 1)"
    echo "version: $(git describe --always --dirty 2>/dev/null || echo unknown)"
    echo "command: tests/bench/run.sh $quick"
} >"$results/machine.txt"
cat "$results/machine.txt"

threads=1
[ "$(nproc)" -ge 2 ] && threads=1,2
[ "$(nproc)" -ge 4 ] && threads=1,2,4
bench() {
    program=$1
    shift
    echo "run: $program $*"
    "$build/tests/$program" "$@"
}
if [ -n "$quick" ]; then
    bench bench_step --quick --threads "$threads" --csv "$results/step.csv"
    bench bench_step --quick --reference --sweep tolerance --threshold 0.02,0 --repeat 1 --methods newton_pcg,projective \
        --csv "$results/step_tolerance.csv"
    bench bench_step --quick --methods newton_pcg --sweep threshold --csv "$results/step_threshold.csv"
    bench bench_step --quick --sweep adjoint --csv "$results/step_adjoint.csv"
    bench bench_step --quick --sweep quadrature --steps 5 --grid 24x8x8 --csv "$results/step_quadrature.csv"
    bench bench_step --quick --sweep model --steps 20 --csv "$results/step_model.csv"
    bench bench_parts --quick --scenes eel --threads "$threads" --csv "$results/parts.csv"
    bench bench_step --quick --scaling --threads "$threads" --csv "$results/step_scaling.csv"
    bench bench_rollout --quick --seconds 1 --csv "$results/rollout.csv"
else
    # Real animals where their meshes are there, shipped ones otherwise.
    animals=shipped
    if [ -r "$DQA_TEST_DATA/Orca.stl" ] && [ -r "$DQA_TEST_DATA/GreatWhiteShark.stl" ]; then animals=orca_shark; fi
    bench bench_step --threads "$threads" --reference --scenes eel --csv "$results/step_eel.csv"
    bench bench_step --threads "$threads" --scenes "$animals" --csv "$results/step_$animals.csv"
    bench bench_step --scenes "$animals" --methods newton_pcg --threshold 0.02 --precision double \
        --csv "$results/step_precision.csv"
    bench bench_step --scenes three --methods newton_pcg --repeat 3 --csv "$results/step_three.csv"
    bench bench_step --scenes "eel,$animals" --methods newton_pcg --threshold 0.02 --repeat 1 --discretisation \
        --integrators euler,bdf2 --csv "$results/step_discretisation.csv"
    bench bench_step --scenes eel --reference --sweep tolerance --budget 4 --csv "$results/step_tolerance_eel.csv"
    bench bench_step --scenes "$animals" --sweep tolerance --threshold 0.02 --methods newton_pcg,projective --repeat 3 \
        --csv "$results/step_tolerance_$animals.csv"
    bench bench_step --scenes "eel,$animals" --methods newton_pcg --sweep threshold --csv "$results/step_threshold.csv"
    bench bench_step --scenes "eel,$animals" --sweep adjoint --csv "$results/step_adjoint.csv"
    bench bench_step --scenes eel --sweep quadrature --steps 20 --repeat 3 --csv "$results/step_quadrature.csv"
    bench bench_step --scenes "eel,$animals,three" --sweep model --steps 20 --repeat 3 --csv "$results/step_model.csv"
    bench bench_parts --scenes "eel,$animals,three" --threads "$threads" --csv "$results/parts.csv"
    bench bench_step --scaling --scenes "$animals" --threads "$threads" --repeat 15 \
        --csv "$results/step_scaling.csv"
    bench bench_rollout --scenes eel --reference --threads "$threads" --csv "$results/rollout_eel.csv"
    bench bench_rollout --scenes "$animals" --rates 15,30,60 --threads "$threads" --repeat 1 \
        --csv "$results/rollout_$animals.csv"
fi
bench bench_barycenter $quick --data "$DQA_TEST_DATA" --csv "$results/barycenter.csv"
cmake --build --preset default --target codesign
echo "run: bench_schedule.py $quick"
python3 -B tests/bench/bench_schedule.py $quick --csv "$results/schedule.csv" "$build/examples/codesign"
# It fails where an answer is wrong in silence; the charts are drawn all the same.
stable=0
bench stability_map $quick --threads "$(nproc)" --failures --csv "$results/stability_map.csv" || stable=$?
python3 -B tests/bench/charts.py --results "$results" --charts "$charts"
exit "$stable"
