#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm dataset by several processes with one folder of work files and mpirun's environment variables: a rank above 0
# computes units of work and writes no dataset; that of a killed process is computed by the others; an interrupted or killed run goes
# on within a unit with the same command. The file is the same every time.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
python3 - >"$dir/pairs.csv" <<'END'
print("reference,test,name")
for name, brdf in (("a", "ggx:kd=0.2;alpha=0.3"), ("b", "ggx:kd=0.2;alpha=0.2")):
    print(f"{brdf},fit:model=ward;of={brdf},{name}")
    for i in range(9):
        print(f"{brdf},perturb:scale={2 + i};of=fit:model=ward;of={brdf},{name}")
        print(f"{brdf},perturb:gloss={2 + i};of={brdf},{name}")
    print(f"{brdf},fit:model=cook-torrance;of={brdf},{name}")
    print(f"{brdf},sgd:brass,{name}")
    print(f"{brdf},fit:model=blinn-phong;of={brdf},{name}")
END
"$tool" directions -n 40 -o "$dir/directions.csv" 2>"$dir/err"
export OMP_NUM_THREADS=1
make() {
    "$tool" dataset "$dir/pairs.csv" --directions "$dir/directions.csv" --light studio --points 50 "$@"
}
# rank R N ARGUMENTS...: run `make` as rank R of N.
rank() (
    export OMPI_COMM_WORLD_RANK="$1" OMPI_COMM_WORLD_SIZE="$2"
    shift 2
    make "$@"
)
count() { find "$1" -name "$2" 2>/dev/null | wc -l; }
# wait_for FOLDER PATTERN: wait until a matching file exists, for at most a minute.
wait_for() {
    tries=0
    until [ "$(count "$1" "$2")" -gt 0 ]; do
        tries=$((tries + 1))
        [ $tries -lt 1200 ] || fail "no $2 in $1 after a minute"
        sleep 0.05
    done
}

make -o "$dir/alone.safetensors" >/dev/null 2>"$dir/err"

# A worker computes both units and writes no dataset; rank 0 only merges them.
rank 1 2 --work "$dir/work" -o "$dir/worker.safetensors" >"$dir/out" 2>"$dir/err" || fail "the worker failed"
[ ! -s "$dir/out" ] || fail "the worker talks: $(cat "$dir/out")"
[ "$(count "$dir/work" '*.safetensors')" = 2 ] || fail "the worker has not made two units"
[ "$(count "$dir/work" '*.claim')" = 0 ] || fail "a claim is left"
[ ! -f "$dir/worker.safetensors" ] || fail "the worker has written a dataset"
rank 0 2 --work "$dir/work" -o "$dir/first.safetensors" >"$dir/out" 2>"$dir/err" || fail "the first rank failed"
grep -q '44 pairs of 2 references' "$dir/out" || fail "summary: $(cat "$dir/out")"
cmp "$dir/alone.safetensors" "$dir/first.safetensors" || fail "another file from the worker's units"
cmp "$dir/alone.safetensors.json" "$dir/first.safetensors.json" || fail "another manifest"

# Two processes at once: the second finds the first unit claimed, and each waits for the other's. One process is
# killed while it has a claim. On a busy machine the signal can arrive between two units; then the test is repeated.
claims=0 blows=0
while [ "$claims" = 0 ]; do
    blows=$((blows + 1))
    [ $blows -le 10 ] || fail "ten killed processes, and none left a claim"
    rm -rf "$dir/work"
    "$tool" dataset "$dir/pairs.csv" --directions "$dir/directions.csv" --light studio --points 50 \
        --work "$dir/work" -o "$dir/killed.safetensors" >/dev/null 2>&1 &
    victim=$!
    wait_for "$dir/work" '*.claim'
    kill -9 $victim
    wait $victim 2>/dev/null || true
    claims=$(count "$dir/work" '*.claim')
done
make --work "$dir/work" -o "$dir/survivor.safetensors" >/dev/null 2>"$dir/err" || fail "after a killed process"
cmp "$dir/alone.safetensors" "$dir/survivor.safetensors" || fail "another file after a killed process"

rm -rf "$dir/work"
rank 1 2 --work "$dir/work" -o "$dir/x" >/dev/null 2>&1 &
other=$!
rank 0 2 --work "$dir/work" -o "$dir/both.safetensors" >/dev/null 2>"$dir/err" || fail "two at once"
wait $other || fail "the second of two"
cmp "$dir/alone.safetensors" "$dir/both.safetensors" || fail "another file from two at once"

# Interrupted and killed within a unit: the same command goes on from its finished rows, and the file is the same.
for signal in TERM KILL; do
    rm -rf "$dir/work"
    "$tool" dataset "$dir/pairs.csv" --directions "$dir/directions.csv" --light studio --points 50 \
        --work "$dir/work" -o "$dir/again.safetensors" >/dev/null 2>"$dir/err" &
    victim=$!
    wait_for "$dir/work" '*.safetensors.progress'
    kill -$signal $victim
    code=0
    wait $victim 2>/dev/null || code=$?
    case $signal-$code in TERM-130 | TERM-0 | KILL-137 | KILL-0) ;; *) fail "exit code $code after SIG$signal" ;; esac
    make --work "$dir/work" -o "$dir/again.safetensors" --log >/dev/null 2>"$dir/err" || fail "going on"
    cmp "$dir/alone.safetensors" "$dir/again.safetensors" || fail "another file after SIG$signal"
    [ "$(count "$dir/work" '*')" = 3 ] || fail "files are left: $(ls "$dir/work")" # the folder and two units
done
if head -1 "$dir/err" | grep -q ' left'; then fail "an estimate without a basis: $(cat "$dir/err")"; fi

code=0
rank 0 2 -o "$dir/x" >/dev/null 2>"$dir/err" || code=$?
[ "$code" = 2 ] || fail "two processes without a folder: exit code $code"
grep -q -- "--work" "$dir/err" || fail "two processes without a folder: exit code $code"
