# A real Slurm of one node on loopback, for other scripts: they source this file. Needs root, but no systemd.
# After start_slurm, $SLURM_CONF names its configuration.

# Prints why no Slurm can be started here, or nothing.
why_no_slurm() {
  local tool
  for tool in munged slurmctld slurmd sbatch squeue scancel scontrol sinfo; do
    command -v "$tool" >/dev/null || { echo "$tool is missing (slurmctld slurmd slurm-client munge)"; return; }
  done
  [ "$(id -u)" -eq 0 ] || echo "the daemons of Slurm need root"
}

# Prints a port of loopback that nothing listens on.
free_port() {
  local port
  while :; do
    port=$((20000 + RANDOM % 12000))
    (: <"/dev/tcp/127.0.0.1/$port") 2>/dev/null || { echo "$port"; return; }
  done
}

# start_slurm CONFIGURATION FOLDER: fails with the daemons' logs if the node is not idle within 30 s.
start_slurm() {
  local configuration=$1
  slurm_folder=$2
  mkdir -m 755 "$slurm_folder" "$slurm_folder/munge" "$slurm_folder/state" "$slurm_folder/spool"
  head -c 128 /dev/urandom >"$slurm_folder/munge/key"
  chmod 400 "$slurm_folder/munge/key"
  munged --force --key-file="$slurm_folder/munge/key" --socket="$slurm_folder/munge/socket" \
    --pid-file="$slurm_folder/munge/pid" --log-file="$slurm_folder/munge/log" --seed-file="$slurm_folder/munge/seed"
  # Two tests may have a Slurm at once.
  sed -e "s#DIR#$slurm_folder#" -e "s#16817#$(free_port)#" -e "s#16818#$(free_port)#" "$configuration" >"$slurm_folder/slurm.conf"
  export SLURM_CONF=$slurm_folder/slurm.conf
  slurmctld -c
  slurmd -N localhost
  for _ in $(seq 150); do
    [ "$(timeout 5 sinfo --noheader --format=%t 2>/dev/null)" = idle ] && return
    sleep 0.2
  done
  echo "Slurm does not start:"
  cat "$slurm_folder"/*.log
  return 1
}

# wait_for_slurm SECONDS: until no job is left.
wait_for_slurm() {
  local end=$((SECONDS + $1)) queue
  while [ $SECONDS -lt "$end" ]; do
    queue=$(squeue --noheader) && [ -z "$queue" ] && return
    sleep 0.2
  done
  echo "jobs are left after $1 s:"
  squeue
  return 1
}

# end_processes_of FOLDER: kills the processes that have the folder in their arguments. All are stopped first:
# otherwise a process could see the end of its child and record it before it is killed itself.
end_processes_of() {
  local signal each
  for signal in STOP KILL; do
    for each in /proc/[0-9]*; do
      grep -qsF "$1" "$each/cmdline" && [ "${each#/proc/}" != $$ ] && kill -$signal "${each#/proc/}" 2>/dev/null
    done
  done
  return 0
}

# Ends jobs and daemons, also of a Slurm that did not start as a whole.
stop_slurm() {
  [ -n "${slurm_folder:-}" ] || return 0
  timeout 10 scancel --signal=KILL --full --user=root >/dev/null 2>&1 || true
  timeout 10 scontrol shutdown >/dev/null 2>&1 || true
  sleep 1
  local file
  for file in ctld.pid d.pid munge/pid; do
    [ -f "$slurm_folder/$file" ] && kill "$(cat "$slurm_folder/$file")" 2>/dev/null
  done
  end_processes_of "$slurm_folder"
}
