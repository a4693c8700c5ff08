#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm dataset under mpirun: two ranks, one rank and a single process write the same file; with Open MPI's
# --enable-recovery, a killed rank loses only the unit that it was working on.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
command -v mpirun >/dev/null 2>&1 || exit 77
python3 - >"$dir/pairs.csv" <<'END'
print("reference,test,name,split")
for name, brdf, split in (("a", "ggx:kd=0.2;alpha=0.3", "train"), ("b", "ggx:kd=0.2;alpha=0.2", "validation"),
                          ("c", "ggx:kd=0.1;alpha=0.1", "train")):
    print(f"{brdf},fit:model=ward;of={brdf},{name},{split}")
    for i in range(20):
        print(f"{brdf},perturb:gloss={1.1 + i / 10};of=fit:model=ward;of={brdf},{name},{split}")
END
"$tool" directions -n 40 -o "$dir/directions.csv" 2>"$dir/err"
# Open MPI: allow root, and more ranks than processors.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1 OMP_NUM_THREADS=1
# Each rank writes its process id to a file for this test.
cat >"$dir/rank.sh" <<'END'
echo $$ >"$1.$OMPI_COMM_WORLD_RANK"
shift
exec "$@"
END
make() {
    "$@" "$tool" dataset "$dir/pairs.csv" --directions "$dir/directions.csv" \
        --light studio --points 50 --work "$dir/work" -o "$dir/$name.safetensors" >"$dir/out" 2>"$dir/err"
}
name=alone
make || fail "alone"
for n in 1 2; do
    rm -rf "$dir/work"
    name=ranks$n
    make mpirun -n $n || fail "mpirun -n $n"
    cmp "$dir/alone.safetensors" "$dir/$name.safetensors" || fail "another file from $n ranks"
    cmp "$dir/alone.safetensors.json" "$dir/$name.safetensors.json" || fail "another manifest from $n ranks"
done

mpirun --version 2>&1 | grep -q 'Open MPI' || skip_rest dataset_by_mpirun
rm -rf "$dir/work"
name=recovered
make mpirun --enable-recovery -n 2 sh "$dir/rank.sh" "$dir/pid" &
job=$!
tries=0
until [ "$(find "$dir/work" -name '*.claim' 2>/dev/null | wc -l)" = 2 ]; do
    tries=$((tries + 1))
    [ $tries -lt 1200 ] || fail "two ranks have not begun after a minute"
    sleep 0.05
done
kill -9 "$(cat "$dir/pid.1")"
wait $job || fail "the job did not outlive rank 1"
cmp "$dir/alone.safetensors" "$dir/recovered.safetensors" || fail "another file after rank 1 was killed"
