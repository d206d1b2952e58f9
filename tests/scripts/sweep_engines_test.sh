#!/usr/bin/env bash
# Computes a sweep by an engine that is disturbed, and compares it with the same sweep undisturbed: no run is lost, none
# is done twice, and the summary has the same bytes apart from times.
# usage: sweep_engines_test.sh WEFT ENGINE [long [RUNS]]    exit code 77 where the programs of the engine are missing
#   ENGINE  local: killed three times at random moments, with all its runs
#           slurm: a real Slurm of one node, submitted anew because the time of its jobs is short
#           mpirun, parallel: by the lines of docs/guide.md, killed once
#   long    RUNS (200) drapes of 33 x 33 vertices on two cores, some minutes, with figures: how busy the workers were,
#           and times.
#           Otherwise a dozen of small sheets, some seconds.
set -euo pipefail
weft=$(readlink -f "$1") engine=$2 size=${3:-short}
here=$(dirname "$(readlink -f "$0")")
source "$here/slurm_loopback.sh"

skip() { echo "skipped: $*"; exit 77; }
fail() { echo "FAILED: $*"; exit 1; }
case $engine in
  local) ;;
  slurm) why=$(why_no_slurm); [ -z "$why" ] || skip "$why" ;;
  mpirun) command -v mpirun >/dev/null || skip "mpirun is missing (openmpi-bin)" ;;
  parallel) command -v parallel >/dev/null || skip "parallel is missing (parallel)" ;;
  *) echo "unknown engine $engine" >&2; exit 2 ;;
esac
[ "$(nproc)" -ge 2 ] || skip "there is one core, and two runs are to go at a time"
work=$(mktemp -d)
chmod 755 "$work"
stop() {
  stop_slurm
  end_processes_of "$work"
  rm -rf "$work"
}
trap stop EXIT
trap 'exit 1' TERM INT
cd "$work"
mkdir bin
ln -s "$weft" bin/weft
export PATH=$work/bin:$PATH
# OpenMPI asks root whether it is meant.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
RANDOM=20240301

if [ "$size" = long ]; then
  runs=${4:-200}
  cat >base.toml <<'CASE'
# A sheet drapes over a ball until its corners fold.
[time]
duration = 0.25
[contact]
range = 3e-3
friction = 0.3
[output]
checkpoint_every = 0.05
[material.cotton]
density = 0.2
membrane_stiffness = 500
bending_stiffness = 1e-4
stiffness_damping = 1e-3
bending_damping = 1e-3
[[body]]
name = "sheet"
position = [0.02, 0.01, 0.155]
thickness = 2e-3
shape = { type = "rectangle", size = [0.8, 0.8], resolution = [33, 33] }
[[obstacle]]
name = "ball"
thickness = 2e-3
shape = { type = "sphere", radius = 0.15, resolution = [17] }
CASE
  cat >sweep.toml <<SWEEP
case = "base.toml"
[factors]
"contact.friction" = { uniform = [0.1, 0.5] }
"material.cotton.density" = { log_uniform = [0.1, 0.4] }
"material.cotton.bending_stiffness" = { log_uniform = [2e-5, 2e-4] }
"material.cotton.membrane_stiffness" = { log_uniform = [200, 1000] }
[sample]
method = "sobol"
runs = $runs
seed = 1
[outputs]
stretch = "max(largest_stretch)"
lowest = "min(position('sheet', 0, 0).z)"
SWEEP
else
  runs=12
  cat >base.toml <<'CASE'
[time]
duration = 1
[output]
checkpoint_every = 0.1
[material.cotton]
density = 0.2
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [9, 9] }
[[body.pin]]
corners = ["first_first"]
CASE
  cat >sweep.toml <<'SWEEP'
case = "base.toml"
[factors]
"material.cotton.density" = { range = [0.1, 0.4], count = 6 }
"material.cotton.membrane_stiffness" = { list = [200, 500] }
[outputs]
stretch = "max(largest_stretch)"
corner = "min(position('sheet', 8, 8).z)"
SWEEP
fi

# The summary without times, memory and version, its last fields.
lasting() { sed 's/\(,[^,]*\)\{4\}$//' "$1/summary.csv"; }
# The results so far, by the digest of their bytes.
results() { (cd "$1/runs" 2>/dev/null && sha256sum -- */result.json 2>/dev/null) || true; }
count_results() { results "$1" | wc -l; }
seconds_since() { awk "BEGIN { printf \"%.1f\", $(date +%s.%N) - $1 }"; }
# busy FOLDER SECONDS: the share of two cores' time that the runs took, %.
busy() {
  sed -n 's/^  "wall_s": \([0-9.e+-]*\).*/\1/p' "$1"/runs/*/result.json | awk "{ sum += \$1 } END { printf \"%.0f\", 50 * sum / $2 }"
}
# kill_later COUNT PROCESS: kills everything of this sweep at a random moment after COUNT runs are done, and waits until
# it is gone.
kill_later() {
  while [ "$(count_results disturbed)" -lt "$1" ] && kill -0 "$2" 2>/dev/null; do sleep 0.05; done
  sleep "$(awk "BEGIN { printf \"%.2f\", $whole_seconds / $runs * 2 * $RANDOM / 32768 }")"
  end_processes_of "$work/disturbed"
  # A process that began meanwhile shows once the one that started it has gone.
  wait "$2" 2>/dev/null || true
  end_processes_of "$work/disturbed"
}

echo "undisturbed, local engine, 2 runs at a time:"
start=$(date +%s.%N)
weft sweep sweep.toml -o whole -j 2 >whole.txt 2>whole.log || { cat whole.log; fail "the undisturbed sweep"; }
whole_seconds=$(seconds_since "$start")
cat whole.txt

# Prints the line of the guide that matches, for the folder of this sweep.
guide_line() { grep -m 1 "$1" "$here/../../docs/guide.md" | sed "s#results#$work/disturbed#g"; }
# Computes the sweep in `disturbed`, or what is left of it, in the way of this engine.
work() {
  case $engine in
    local) exec weft sweep sweep.toml -o "$work/disturbed" -j 2 ;;
    mpirun)
      eval "$(guide_line '^weft sweep plan sweep.toml -o results$')"
      eval "$(guide_line '^mpirun -n 2 ')" ;;
    parallel)
      eval "$(guide_line '^weft sweep plan sweep.toml -o results$')"
      eval "$(guide_line '^seq 0 1 | parallel ')" ;;
  esac
}

# Runs until all are done, and counts the calls; is_cut tells whether a call ended with runs left.
submit_until_done() {
  while [ "$(count_results disturbed)" -lt $runs ]; do
    calls=$((calls + 1))
    [ $calls -le 20 ] || fail "no end after $calls submissions"
    weft sweep sweep.toml -o disturbed --engine slurm --tasks 2 "${limit[@]}"
    if weft sweep sweep.toml -o disturbed --engine slurm 2>refused.txt; then
      fail "a second submission over live jobs was accepted"
    fi
    grep -q "has not ended" refused.txt || { cat refused.txt; fail "another refusal"; }
    wait_for_slurm 300 || fail "jobs do not end"
    grep -h "remaining\|error\|runs:" disturbed/slurm/*.log || true
    results disturbed >>seen.txt
    echo "submission $calls: $(count_results disturbed) of $runs done"
  done
  cat disturbed/slurm/*.log >lines.txt
  [ $calls -lt 2 ] || is_cut=yes
}
kill_and_finish() {
  local kills=1
  [ "$engine" = local ] && kills=3
  while [ $calls -lt $kills ]; do
    calls=$((calls + 1))
    (work) >call.txt 2>call.log &
    kill_later $((calls * runs / (kills + 1))) $!
    cat call.txt call.log >>lines.txt
    results disturbed >>seen.txt
    local done_runs
    done_runs=$(count_results disturbed)
    echo "call $calls: killed with $done_runs of $runs done"
    [ "$done_runs" -eq $runs ] || is_cut=yes
  done
  (work) >call.txt 2>call.log || { cat call.log; fail "the last call"; }
  cat call.txt call.log >>lines.txt
}

if [ "$engine" = slurm ]; then
  start_slurm "$here/slurm_loopback.conf" "$work/slurm" || fail "no Slurm"
  # Workers keep two seconds for stopping.
  limit=(--wall-time "$(awk "BEGIN { print 2 + 0.5 * $whole_seconds }")")
  if [ "$size" = long ]; then [ $runs -lt 100 ] && limit=(--sbatch=--time=1) || limit=(--sbatch=--time=2); fi
fi
# On a machine whose speed varies, all runs may be done before the first kill or the end of the time. Then it begins
# anew.
is_cut=no
for attempt in 1 2 3; do
  [ $attempt -eq 1 ] || echo "nothing was cut off: attempt $attempt"
  rm -rf disturbed
  calls=0
  : >lines.txt >seen.txt
  start=$(date +%s.%N)
  if [ "$engine" = slurm ]; then submit_until_done; else kill_and_finish; fi
  [ $is_cut = no ] || break
done
[ $is_cut = yes ] || fail "no call was cut off"
seconds=$(seconds_since "$start")
weft sweep status disturbed
[ "$(count_results disturbed)" -eq $runs ] || fail "runs are lost"
results disturbed >last.txt
# A run that was done twice would have another result.
sort -u seen.txt | while read -r digest file; do
  grep -q "^$digest  $file$" last.txt || { echo "$file was done twice"; exit 1; }
done || fail "a run was done twice"
done_twice=$(sed -n 's/^\[[0-9/]*\] \([0-9a-f]*\) .* done in .*/\1/p' lines.txt | sort | uniq -d)
[ -z "$done_twice" ] || fail "done twice: $done_twice"
diff <(lasting whole) <(lasting disturbed) || fail "the summaries differ"
[ "$engine" = slurm ] && cut="$calls submissions" || cut="$calls calls killed, one to the end"
echo "$engine: $cut, ${seconds} s; undisturbed ${whole_seconds} s, busy $(busy whole "$whole_seconds") % of two cores"
if [ "$size" = long ] && [ "$engine" != local ] && [ "$engine" != slurm ]; then
  rm -rf disturbed
  start=$(date +%s.%N)
  (work) >call.txt 2>call.log || { cat call.log; fail "the undisturbed call"; }
  seconds=$(seconds_since "$start")
  diff <(lasting whole) <(lasting disturbed) || fail "the summaries differ"
  echo "$engine, undisturbed: ${seconds} s, busy $(busy disturbed "$seconds") % of two cores"
fi
echo "1 passed, 0 failed"
