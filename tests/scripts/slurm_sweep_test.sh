#!/usr/bin/env bash
# Submits a sweep to a real Slurm of one node on loopback, and compares its summary with that of the local engine.
# usage: slurm_sweep_test.sh WEFT CONFIGURATION    exit code 77 where the packages of Slurm are missing
set -euo pipefail
weft=$1 configuration=$2
for tool in munged slurmctld slurmd sbatch squeue scontrol; do
  command -v "$tool" >/dev/null || { echo "skipped: $tool is missing (slurmctld slurmd slurm-client munge)"; exit 77; }
done
[ "$(id -u)" -eq 0 ] || { echo "skipped: the daemons need root"; exit 77; }
work=$(mktemp -d)
chmod 755 "$work"
stop() {
  SLURM_CONF=$work/slurm.conf scontrol shutdown >/dev/null 2>&1 || true
  sleep 1
  [ -f "$work/munge/pid" ] && kill "$(cat "$work/munge/pid")" 2>/dev/null || true
  rm -rf "$work"
}
trap stop EXIT
mkdir -m 755 "$work/munge" "$work/state" "$work/spool"
head -c 128 /dev/urandom >"$work/munge/key"
chmod 400 "$work/munge/key"
munged --force --key-file="$work/munge/key" --socket="$work/munge/socket" --pid-file="$work/munge/pid" \
  --log-file="$work/munge/log" --seed-file="$work/munge/seed"
sed "s#DIR#$work#" "$configuration" >"$work/slurm.conf"
export SLURM_CONF=$work/slurm.conf
slurmctld -c
slurmd -N localhost
for _ in $(seq 100); do
  [ "$(sinfo --noheader --format=%t 2>/dev/null)" = idle ] && break
  sleep 0.2
done
cd "$work"
cat >base.toml <<'CASE'
[time]
duration = 0.2
[material.cotton]
density = 0.2
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [4, 4] }
[[body.pin]]
corners = ["first_first"]
CASE
cat >sweep.toml <<'SWEEP'
case = "base.toml"
[factors]
"material.cotton.density" = { range = [0.1, 0.4], count = 6 }
SWEEP
"$weft" sweep sweep.toml -o local --quiet >/dev/null
"$weft" sweep sweep.toml -o queued --engine slurm --tasks 3
if "$weft" sweep sweep.toml -o queued --engine slurm 2>refused.txt; then
  echo "a second submission over live jobs was accepted"
  exit 1
fi
grep -q "has not ended" refused.txt || { cat refused.txt; exit 1; }
for _ in $(seq 300); do
  [ -z "$(squeue --noheader)" ] && break
  sleep 0.2
done
"$weft" sweep status queued | tee status.txt
grep -q "6 runs: 6 done" status.txt || { cat queued/slurm/*.log; exit 1; }
# Times and memory are the last fields but one.
lasting() { sed 's/\(,[^,]*\)\{4\}$//' "$1/summary.csv"; }
diff <(lasting local) <(lasting queued)
echo "1 passed, 0 failed"
