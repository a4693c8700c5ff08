#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm batch by several processes: ranks that the environment names, and two under mpirun, write the same files as one process,
# also when one of them is killed, and when a stopped run is started again. A model with random weights.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
"${NQM_BUILD:?}/tests/tiny_model" "$dir/model.safetensors" 20
mkdir "$dir/lists"
# Five pieces of 256 rows; a row without a score.
awk 'BEGIN {print "reference,test,i"; for (i = 0; i < 1200; ++i)
    printf "ggx:kd=.%d;alpha=.%d,%s,%d\n", 1 + int(i / 200), 11 + i % 83, i == 700 ? "nowhere.binary" : "ggx:kd=.2;alpha=.2" i % 7, i}' >"$dir/lists/long.csv"
export OMP_NUM_THREADS=1
# batch ARGUMENTS...: exit code 9, the row without a score.
batch() {
    "$@" "$tool" batch "$dir/lists/long.csv" -k --metrics log_diff --fail-under 5 -m "$dir/model.safetensors" --work "$dir/work" -o "$dir/$name.csv" \
        --junit "$dir/$name.xml" --markdown "$dir/$name.md" >"$dir/out" 2>"$dir/err"
}
# ends CODE ...: compare the files of run $name with those of one process.
ends() {
    [ "$1" = 9 ] || fail "$name: exit code $1: $(cat "$dir/err")"
    for file in csv xml md; do cmp "$dir/alone.$file" "$dir/$name.$file" || fail "$name: another .$file"; done
    [ "$(find "$dir" -name '*.part*' -o -name '*.claim' | wc -l)" = 0 ] || fail "$name: left-over files"
}
rank() (
    export OMPI_COMM_WORLD_RANK="$1" OMPI_COMM_WORLD_SIZE="$2"
    shift 2
    batch "$@"
)
pieces() { find "$dir/work" -name '*.safetensors' 2>/dev/null | wc -l; }

name=alone code=0
"$tool" batch "$dir/lists/long.csv" -k --metrics log_diff --fail-under 5 -m "$dir/model.safetensors" -o "$dir/alone.csv" --junit "$dir/alone.xml" \
    --markdown "$dir/alone.md" 2>"$dir/err" || code=$?
[ "$code" = 9 ] || fail "alone: exit code $code: $(cat "$dir/err")"
[ "$(wc -l <"$dir/alone.csv")" = 1201 ] || fail "1200 rows"

# A worker scores all pieces and writes nothing else; rank 0 only merges them; the same command again does so, too.
name=worker
rank 1 2 || fail "the worker failed: $(cat "$dir/err")"
{ [ "$(pieces)" = 5 ] && [ ! -e "$dir/worker.csv" ] && [ ! -s "$dir/out" ]; } || fail "the worker"
name=first code=0
rank 0 2 || code=$?
ends $code
name=again code=0
batch || code=$?
ends $code

# A damaged or a missing piece is scored again; another option makes other pieces.
piece=$(find "$dir/work" -name '*-2.safetensors')
size=$(wc -c <"$piece")
head -c $((size - 100)) "$piece" >"$dir/piece"
head -c 100 /dev/zero >>"$dir/piece"
mv "$dir/piece" "$piece"
rm "$(find "$dir/work" -name '*-3.safetensors')"
name=damaged code=0
batch || code=$?
ends $code
run 9 batch "$dir/lists/long.csv" -k -m "$dir/model.safetensors" --work "$dir/work" --min-valid 0.5
[ "$(pieces)" = 10 ] || fail "other options share pieces"

# Two processes at once, the second of which is killed.
for killed in no yes; do
    rm -rf "$dir/work"
    name=worker
    rank 1 2 &
    victim=$!
    if [ $killed = yes ]; then
        sleep 0.1
        kill -9 $victim 2>/dev/null || true
    fi
    name=two code=0
    rank 0 2 || code=$?
    wait $victim 2>/dev/null || true
    rm -f "$dir/work"/*.claim # of a killed worker that had just one piece to make
    ends $code
done

# Without --keep-going the first row that fails ends the run; its piece is scored again, when the row may have a score.
run 3 batch "$dir/lists/long.csv" -m "$dir/model.safetensors" --work "$dir/work3" -o "$dir/stop.csv"
grep -q 'row 701: .*nowhere.binary' "$dir/err" || fail "a row that fails: $(cat "$dir/err")"
"$NQM_BUILD/tests/make_brdf_files" "$dir" >/dev/null
cp "$dir/valid.h5" "$dir/lists/nowhere.binary" 2>/dev/null || true
"$tool" batch "$dir/lists/long.csv" -m "$dir/model.safetensors" --work "$dir/work3" -o "$dir/stop.csv" --resume 2>"$dir/err" || true
grep -q 'No such file' "$dir/err" && fail "the old failure: $(cat "$dir/err")"
rm -f "$dir/lists/nowhere.binary"

# Several shells: each writes the output, which is the same; a second one goes on when the first dies.
rm -rf "$dir/work"
name=shells
batch &
other=$!
code=0
batch || code=$?
ends $code
code=0
wait $other || code=$?
ends $code
rm -rf "$dir/work"
name=dead
batch exec &
other=$!
while [ -d /proc/$other ] && [ "$(pieces)" -lt 2 ]; do sleep 0.01; done
(kill -9 $other 2>/dev/null && touch "$dir/died") || true
wait $other 2>/dev/null || true
code=0
batch || code=$?
rm -f "$dir/work"/*.claim
ends $code

# Usage: a folder, and a list that every process can read.
code=0
(export PMI_RANK=0 PMI_SIZE=2 && "$tool" batch "$dir/lists/long.csv" -m "$dir/model.safetensors") >"$dir/out" 2>"$dir/err" || code=$?
{ [ "$code" = 2 ] && grep -q -- --work "$dir/err"; } || fail "two processes without a folder: exit code $code"
code=0
(export SLURM_PROCID=1 SLURM_STEP_NUM_TASKS=2 && "$tool" batch - --work "$dir/work" <"$dir/lists/long.csv") >"$dir/out" 2>"$dir/err" || code=$?
[ "$code" = 2 ] || fail "a list from standard input: exit code $code"
run 3 batch "$dir/lists/long.csv" --work "$dir/nowhere/work"

# mpirun; with Open MPI's --enable-recovery the job outlives a killed rank.
command -v mpirun >/dev/null 2>&1 || skip_rest batch_by_mpirun
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1
rm -rf "$dir/work"
name=mpirun code=0
batch mpirun -n 2 || code=$?
ends $code
mpirun --version 2>&1 | grep -q 'Open MPI' || skip_rest batch_by_mpirun
cat >"$dir/rank.sh" <<'END'
[ "$OMPI_COMM_WORLD_RANK" = 0 ] || (while [ ! -e "$1/work" ]; do sleep 0.01; done && sleep 0.05 && touch "$1/killed" && kill -9 $$) &
shift
exec "$@"
END
rm -rf "$dir/work"
name=recovered code=0
batch mpirun --enable-recovery -n 2 sh "$dir/rank.sh" "$dir" || code=$?
[ -e "$dir/killed" ] || fail "rank 1 was not killed"
rm -f "$dir/work"/*.claim
[ $code = 0 ] || [ $code = 9 ] || fail "the job did not outlive rank 1: exit code $code: $(cat "$dir/err")"
ends 9 # which such a job does not pass on
