#!/bin/sh
# SPDX-License-Identifier: MIT
# kill.sh [N [SEED]]: kill verbs that write files at N random moments (default 9). After one to three kills the command runs to its
# end, resumed where the verb can: its folder then has the files and bytes of an undisturbed run, and no other file.
# `./dev test all` does this with 210 kills. Prints the kills of each verb.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
wanted=${1:-9} seed=${2:-1}
[ -n "${1:-}" ] || [ -z "${NQM_SANITIZE:-}" ] || wanted=5 # sanitizers make each round ten times slower
OMP_NUM_THREADS=1
export OMP_NUM_THREADS
cd "$dir"

"${NQM_BUILD:?}/tests/tiny_model" model.safetensors 20
"$NQM_BUILD/tests/tiny_dataset" toy.safetensors 1 48
"$tool" train toy.safetensors -o trained.safetensors --hidden 8 --batch 64 --lr-first 0.001 --epochs 2 >/dev/null 2>&1
"$tool" directions -n 40 -o directions.csv 2>err
awk 'BEGIN {print "reference,test"; for (i = 1; i <= 400; i++) printf "sgd:nickel,ggx:kd=0.1;alpha=%g\n", .1 + i / 1000}' >list.csv
cat >pairs.csv <<'END'
reference,test,split
ggx:kd=0.2;alpha=0.3,fit:model=ward;of=ggx:kd=0.2;alpha=0.3,validation
ggx:kd=0.2;alpha=0.3,perturb:gloss=0.7;of=fit:model=ward;of=ggx:kd=0.2;alpha=0.3,validation
ggx:kd=0.4;alpha=0.5,fit:model=ward;of=ggx:kd=0.4;alpha=0.5,train
ggx:kd=0.4;alpha=0.5,between:t=0.5;with=(sgd:nickel);of=ggx:kd=0.4;alpha=0.5,train
sgd:nickel,fit:model=ward;of=sgd:nickel,train
sgd:nickel,perturb:scale=2;of=sgd:nickel,train
sgd:nickel,ggx:kd=0.4;alpha=0.5,train
END

# run_verb VERB: run the verb with outputs in the working folder, a subfolder of $dir. `exec`: the process to kill is nqm itself.
run_verb() {
    case $1 in
    batch) set -- batch ../list.csv -m ../model.safetensors -o scores.csv --resume ;;
    dataset) set -- dataset ../pairs.csv --directions ../directions.csv -o corpus.safetensors --work groups \
        --points 20 --shape sphere --light sun ;;
    train)
        set -- train ../toy.safetensors -o trained.safetensors --hidden 16 --batch 64 --lr-first 0.001 --epochs 6 --log log.csv \
            --checkpoint checkpoint
        [ ! -e checkpoint ] || set -- "$@" --resume
        ;;
    fit) set -- fit 'ward:kd=0.3,0.2,0.1;ks=0.05;alpha=0.1' --model nbrdf --samples 200 -o fit.safetensors ;;
    report) set -- report -m ../model.safetensors --size 8 sgd:nickel ward:nickel -o page.html ;;
    calibrate) set -- calibrate ../trained.safetensors ../toy.safetensors -o calibrated.safetensors ;;
    esac
    exec "$tool" "$@" >"$dir/out" 2>"$dir/err"
}

# undisturbed VERB: make the folder VERB.expected; its duration in ms in ms.
undisturbed() {
    mkdir "$1.expected"
    start=$(date +%s%N)
    (cd "$1.expected" && run_verb "$1") || fail "$1: exit code $?"
    ms=$((($(date +%s%N) - start) / 1000000))
}

# kill_at VERB FRACTION: start the verb, and kill it after a fraction of its duration; 1 if it ended before.
kill_at() {
    (cd "$1" && run_verb "$1") &
    pid=$!
    sleep "$(awk -v ms="$ms" -v f="$2" 'BEGIN {print ms * f / 1000}')"
    kill -KILL $pid 2>/dev/null || true
    got=0
    wait $pid 2>/dev/null || got=$?
    case $got in
    137) ;;
    0) return 1 ;;
    *) fail "$1: exit code $got before it was killed" ;;
    esac
}

# finish VERB ROUND: run to the end and compare.
finish() {
    (cd "$1" && run_verb "$1") || fail "$1, round $2: exit code $? after kills"
    diff -r "$1.expected" "$1" >difference || fail "$1, round $2: $(cat difference)"
    rm -r "$1"
}

# kills VERB N: kill it N times, in rounds of one to three kills.
kills() {
    undisturbed "$1"
    killed=0 round=0 tries=0
    while [ $killed -lt "$2" ] && [ $tries -lt $((10 * $2)) ]; do
        round=$((round + 1))
        mkdir "$1"
        fractions=$(awk -v s="$seed$round" 'BEGIN {srand(s); n = 1 + int(3 * rand()); while (n--) print rand()}')
        for fraction in $fractions; do
            tries=$((tries + 1))
            if kill_at "$1" "$fraction"; then killed=$((killed + 1)); fi
        done
        finish "$1" $round
    done
    echo "$1: $killed kills in $round rounds, $ms ms undisturbed"
    [ $killed -ge "$2" ] || fail "$1: only $killed of $2 kills"
}

for verb in batch dataset train fit report calibrate; do kills $verb $(((wanted + 5) / 6)); done
