#!/bin/sh
# SPDX-License-Identifier: MIT
# Limits of the machine: a full disk, a folder that cannot be written, limits on file size, memory, open files and the stack, closed
# standard streams, and two processes on one output. Each run succeeds with the usual bytes or ends with a documented exit code
# and a message, and leaves no unfinished file.
# shellcheck disable=SC3045 # dash and bash have these limits
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
OMP_NUM_THREADS=1
export OMP_NUM_THREADS
mkdir "$dir/small"
cd "$dir"
"${NQM_BUILD:?}/tests/tiny_model" model.safetensors 20
"$NQM_BUILD/tests/tiny_dataset" toy.safetensors 1 24
awk 'BEGIN {print "reference,test"; for (i = 1; i <= 300; i++) printf "sgd:nickel,ggx:kd=0.1;alpha=%g\n", .1 + i / 1000}' >list.csv

# write_all FOLDER: every verb that writes a file of more than 1 KB writes it to FOLDER; each must exit with $code.
write_all() {
    run "$code" directions -n 4000 -o "$1/directions.csv"
    run "$code" batch list.csv -m model.safetensors -o "$1/scores.csv"
    run "$code" train toy.safetensors -o "$1/trained.safetensors" --hidden 8 --batch 64 --epochs 1
    run "$code" fit sgd:nickel --model nbrdf --samples 200 -o "$1/fit.safetensors"
    run "$code" report -m model.safetensors --size 8 sgd:nickel ward:nickel -o "$1/page.html"
}
# empty: nothing is left in the folder `small`.
empty() { [ -z "$(ls -A small)" ] || fail "left in $1: $(ls -A small)"; }

# ---- a limit on the size of files; a full disk; a folder that cannot be written
code=0
write_all small
rm small/*
(
    code=3
    ulimit -f 1
    write_all small
) || fail "ulimit -f"
empty "ulimit -f"
# shellcheck disable=SC2016 # expanded by the inner shell
run_mounted() { unshare -m sh -c 'mount -t tmpfs -o "$1" none small && shift && exec "$@"' - "$@"; }
if run_mounted size=16k true 2>/dev/null; then
    got=0
    # shellcheck disable=SC2016 # expanded by the inner shell
    run_mounted size=16k sh -c '
        for command in "directions -n 4000 -o small/d.csv" \
            "report -m model.safetensors --size 8 sgd:nickel ward:nickel -o small/page.html"; do
            got=0
            "$1" $command >out 2>err || got=$?
            [ $got = 3 ] && grep -q "small/.*: cannot write" err || exit 1
            [ -z "$(ls -A small)" ] || exit 1
        done' - "$tool" || got=$?
    [ $got = 0 ] || fail "a full disk: $(cat out)"
    # shellcheck disable=SC2016
    run_mounted ro sh -c 'got=0; "$1" directions -n 40 -o small/d.csv 2>err || got=$?; [ $got = 3 ] && grep -q "Read-only" err' - "$tool" ||
        fail "a read-only file system"
else
    echo "not tested: a full disk and a read-only file system, which need root"
fi
if [ "$(id -u)" != 0 ]; then
    chmod 555 small
    refuses 3 'Permission denied' directions -n 40 -o small/d.csv
    chmod 755 small
fi

# ---- standard streams that are closed: messages are not written into files, and results are not lost silently
"$tool" batch list.csv -m model.safetensors -o expected.csv 2>err
echo sgd:nickel,late.bsdf >>list.csv
got=0
"$tool" batch list.csv -m model.safetensors -o scores.csv 2>&- || got=$?
[ $got = 3 ] || fail "exit code $got, not 3, with standard error closed"
if grep -rq 'rows are in' scores.csv*; then fail "a message in a file"; fi
got=0
"$tool" score -m model.safetensors sgd:nickel ward:nickel >&- 2>err || got=$?
{ [ $got = 3 ] && grep -q 'standard output' err; } || fail "exit code $got with standard output closed"
"$tool" directions -n 40 -o small/d.csv <&- >&- 2>&- || fail "all streams closed"
rm small/d.csv

# ---- limits on the stack, on open files and on memory
(
    ulimit -s 128
    run 7 score -m model.safetensors sgd:nickel ward:nickel
    says 'the stack is limited to 128 KB'
) || fail "ulimit -s 128"
(ulimit -n 6 && exec "$tool" score -m model.safetensors sgd:nickel ward:nickel -q) >out 2>err || fail "ulimit -n"
if [ -z "${NQM_SANITIZE:-}" ]; then
    (
        ulimit -s 1024
        run 0 score sgd:nickel ward:nickel -q
    ) || fail "ulimit -s 1024"
    # 127: the system's loader has no room for a library
    for kb in 50000 56000 65000 90000 150000; do
        got=0
        (ulimit -v $kb && OMP_NUM_THREADS=4 exec "$tool" render ggx:alpha=.3 --size 200 -o small/r.png) >out 2>err || got=$?
        case $got in
        0 | 127) ;;
        7) grep -q 'out of memory\|a thread cannot be created' err || fail "ulimit -v $kb: no message" ;;
        *) fail "ulimit -v $kb: exit code $got" ;;
        esac
        rm -f small/r.png
        empty "ulimit -v $kb"
    done
fi

# ---- two processes on one output: each succeeds
sed -i '$d' list.csv
for round in 1 2; do
    rm -rf scores.csv*
    "$tool" batch list.csv -m model.safetensors -o scores.csv 2>err &
    pid=$!
    "$tool" batch list.csv -m model.safetensors -o scores.csv 2>err2 || fail "a batch beside another: $(cat err2)"
    wait $pid || fail "a batch beside another"
    cmp scores.csv expected.csv || fail "two batches, round $round"
    verb="directions -n 4000"
    # shellcheck disable=SC2086
    {
        "$tool" $verb -o small/expected 2>err
        "$tool" $verb -o small/x 2>err &
        "$tool" $verb -o small/x 2>err || fail "$verb, beside another"
    }
    wait $! || fail "$verb, beside another"
    cmp small/x small/expected || fail "$verb, beside another"
    rm small/x small/expected
    empty "two processes"
done
for file in ./*.part* ./*.pieces; do
    [ ! -e "$file" ] || fail "left-over: $file"
done
