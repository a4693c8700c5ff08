#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm batch: order and columns of the rows, the formats of lists and results, rows that fail, and resumed runs, whose
# file must equal that of an uninterrupted run byte for byte. Uses a model with random weights.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
"${NQM_BUILD:?}/tests/tiny_model" "$dir/model.safetensors" 20
"$NQM_BUILD/tests/make_brdf_files" "$dir" >/dev/null

# batch CODE ARGUMENTS...: run with the model; standard output goes to out, standard error to err.
batch() {
    code=$1
    shift
    run "$code" batch --model "$dir/model.safetensors" "$@"
}
# says PATTERN: standard error must match PATTERN.
says() { grep -q -- "$1" "$dir/err" || fail "no message '$1'"; }

# ---- order, columns, names with commas, quotes and UTF-8; the same scores as nqm score
mkdir "$dir/sub"
cp "$dir/valid.h5" "$dir/sub/m.h5"
mv "$dir/valid.h5" "$dir/caf\"é, 1.h5"
cat >"$dir/pairs.csv" <<END
Note,Reference,test,JOD
"b, ""c""",sgd:nickel,ward:nickel,7.5
é,sgd:nickel,"perturb:tint=1.2,1,1;of=sgd:nickel",
,lambert:kd=.4,"$dir/caf""é, 1.h5",1
"# last",ward:nickel,ward:nickel," x "
END
batch 0 "$dir/pairs.csv" --metrics rmse,log_diff
head -n 1 "$dir/out" | grep -qx 'Note,Reference,test,JOD,jod,jod_low,jod_high,delta_e_itp,identical,n_valid,novelty,verdict,rmse,log_diff,warnings,error' || fail "header"
[ "$(wc -l <"$dir/out")" = 5 ] || fail "a row a pair"
sed -n 2p "$dir/out" | grep -q '^"b, ""c""",sgd:nickel,ward:nickel,7.5,[0-9]' || fail "first row"
sed -n 3p "$dir/out" | grep -q '^é,sgd:nickel,"perturb:tint=1.2,1,1;of=sgd:nickel",,[0-9]' || fail "second row"
sed -n 4p "$dir/out" | grep -q '^,lambert:kd=.4,".*/caf""é, 1.h5",1,[0-9]' || fail "third row"
sed -n 5p "$dir/out" | grep -q '^"# last",ward:nickel,ward:nickel," x ",.*,1,20,[^,]*,identical,0,0,,$' || fail "an identical pair"
"$tool" score --model "$dir/model.safetensors" sgd:nickel ward:nickel -q >"$dir/score"
jod=$(sed -n 2p "$dir/out" | sed 's/.*,7.5,\([^,]*\),.*/\1/')
awk -v a="$jod" -v b="$(cat "$dir/score")" 'BEGIN {exit !(a - b < 1e-4 && b - a < 1e-4)}' || fail "another score than nqm score: $jod"
cp "$dir/out" "$dir/first"
batch 0 - --metrics rmse,log_diff <"$dir/pairs.csv"
cmp -s "$dir/first" "$dir/out" || fail "standard input gives another result"
batch 0 "$dir/pairs.csv" --metrics rmse,log_diff -o "$dir/all.csv"
cmp -s "$dir/first" "$dir/all.csv" || fail "a file gives another result"
[ "$(find "$dir" -name 'all.csv*' | wc -l)" = 1 ] || fail "left-over files"
batch 0 "$dir/pairs.csv" -o /dev/null
[ -c /dev/null ] || fail "a device was replaced"

# ---- JSON Lines and JSON
cat >"$dir/pairs.jsonl" <<'END'
{"reference": "sgd:nickel", "test": "ward:nickel", "human": {"jod": 8.5, "n": 12}, "name": "caf\u00e9, \"x\""}

{"test": "sgd:nickel", "reference": "sgd:nickel", "weight": 0.1}
END
batch 0 "$dir/pairs.jsonl" -o "$dir/out.jsonl" --metrics mae
sed -n 1p "$dir/out.jsonl" | grep -q '^{"reference":"sgd:nickel","test":"ward:nickel","human":{"jod":8.5,"n":12},"name":"café, \\"x\\"","jod":[0-9].*"verdict":"[a-z ]*","metrics":{"mae":[0-9.]*},"warnings":\[\]}$' || fail "JSON Lines: $(cat "$dir/out.jsonl")"
sed -n 2p "$dir/out.jsonl" | grep -q '^{"test":"sgd:nickel","reference":"sgd:nickel","weight":0.1,"jod":.*"identical":true,"n_valid":20,"novelty":[^,]*,"verdict":"identical","metrics":{"mae":0.0},"warnings":\[\]}$' || fail "JSON Lines: $(cat "$dir/out.jsonl")"
batch 0 "$dir/pairs.jsonl"
sed -n 1p "$dir/out" | grep -q '^reference,test,human,name,weight,jod,' || fail "CSV of JSON Lines: header"
sed -n 3p "$dir/out" | grep -q '^sgd:nickel,sgd:nickel,,,0.1,' || fail "CSV of JSON Lines: row"
batch 0 "$dir/pairs.csv" --json
{ head -n 1 "$dir/out" | grep -q '^{"schema":1,"tool":{"name":"nqm",.*"model":{"id":"tiny","sha256":"[0-9a-f]*","parameters":[0-9]*},"results":\[$' &&
    [ "$(tail -n 1 "$dir/out")" = ']}' ] && [ "$(grep -c '},$' "$dir/out")" = 3 ]; } || fail "JSON: $(cat "$dir/out")"

# ---- relative paths, warnings
printf 'reference,test\nm.h5,perturb:scale=1.1;of=m.h5\n' >"$dir/relative.csv"
(cd "$dir" && batch 0 relative.csv --root sub -o relative-out.csv) || fail "--root"
sed -n 2p "$dir/relative-out.csv" | grep -q '^m.h5,perturb:scale=1.1;of=m.h5,[0-9]' || fail "--root: $(cat "$dir/relative-out.csv")"
# Without --root they start at the folder of the list, and at the working folder for standard input.
cp "$dir/relative.csv" "$dir/sub/relative.csv"
batch 0 "$dir/sub/relative.csv"
cmp "$dir/out" "$dir/relative-out.csv" || fail "the folder of the list"
(cd "$dir/sub" && batch 0 - <relative.csv) || fail "the working folder"
mkfifo "$dir/sub/pipe" # as <(COMMAND) makes it: also there paths are relative to the working folder
(cd "$dir/sub" && cat relative.csv >pipe & cd "$dir/sub" && batch 0 "$dir/sub/pipe") || fail "a pipe"
(cd "$dir/sub" && batch 0 relative.csv) || fail "a list in the working folder"
batch 3 "$dir/relative.csv"
# Semicolons and tabs.
printf 'reference;test;note\nsgd:nickel;"perturb:tint=1.2,1,1;of=sgd:nickel";a,b\n' >"$dir/semicolon.csv"
batch 0 "$dir/semicolon.csv"
sed -n 2p "$dir/out" | grep -q '^sgd:nickel,"perturb:tint=1.2,1,1;of=sgd:nickel","a,b",[0-9]' || fail "semicolons: $(cat "$dir/out")"
printf 'note\treference\ttest\n\tsgd:nickel\tward:nickel\n' >"$dir/tab.tsv"
batch 0 "$dir/tab.tsv"
sed -n 2p "$dir/out" | grep -q '^,sgd:nickel,ward:nickel,[0-9]' || fail "tabs: $(cat "$dir/out")"
# What spreadsheets and other programs write: UTF-16, a JSON array.
printf '\377\376r\0e\0' >"$dir/utf16.csv"
batch 4 "$dir/utf16.csv"
says 'UTF-16 (byte 0); save it as UTF-8'
printf '[{"reference": "sgd:nickel", "test": "ward:nickel"}]\n' >"$dir/array.json"
batch 4 "$dir/array.json"
says 'a list has one on each line'
batch 3 "$dir/relative.csv" --root "$dir/nowhere" -o "$dir/x.csv"
[ "$(find "$dir" -name 'x.csv*' | wc -l)" = 0 ] || fail "files without a run"
printf 'reference,test\n%s,ward:nickel\n' "$dir/valid.binary" >"$dir/holes.csv"
batch 0 "$dir/holes.csv" --min-valid 0
grep -q 'reference: no value at .* directions, left out' "$dir/out" || fail "warnings: $(cat "$dir/out")"
batch 5 "$dir/holes.csv" --min-valid 1
says 'both have a value at only'

# ---- rows that fail
cat >"$dir/faulty.csv" <<END
reference,test
sgd:nickel,ward:nickel
sgd:nickel,$dir/nowhere.binary
sgd:nickel,lambert:nonsense=1
ward:nickel,sgd:nickel
END
batch 3 "$dir/faulty.csv"
says 'row 2: .*nowhere.binary'
[ "$(wc -l <"$dir/out")" = 2 ] || fail "the rows before the first fault"
batch 9 "$dir/faulty.csv" --keep-going
says '2 of 4 rows'
sed -n 3p "$dir/out" | grep -q 'nowhere.binary,,,,,,,,,,.*nowhere.binary: No such file' || fail "an error column: $(cat "$dir/out")"
sed -n 5p "$dir/out" | grep -q '^ward:nickel,sgd:nickel,[0-9]' || fail "the row behind the faults"
batch 9 "$dir/faulty.csv" --keep-going --jsonl
sed -n 3p "$dir/out" | grep -q '"jod":null,.*"identical":null,"n_valid":null,.*"error":".*nonsense' || fail "errors in JSON Lines"
batch 3 "$dir/faulty.csv" --json
[ "$(tail -n 1 "$dir/out")" = ']}' ] || fail "a document that ends early must end"

# ---- stopped by an error and resumed: the same file as in one run; a list of six pieces with a fault in the third
awk 'BEGIN {print "reference,test,i"; for (i = 0; i < 1500; ++i)
    printf "ggx:kd=.%d;alpha=.%d,%s,%d\n", 1 + int(i / 40), 11 + i % 83, i == 700 ? "nowhere.binary" : "ggx:kd=.2;alpha=.2" i % 7, i}' >"$dir/long.csv"
parts=$dir/parts.csv
batch 9 "$dir/long.csv" -k -o "$dir/long-whole.csv"
[ "$(wc -l <"$dir/long-whole.csv")" = 1501 ] || fail "1500 rows"
batch 3 "$dir/long.csv" -o "$parts"
says '512 of 1500 rows are in .*/parts.csv.pieces; --resume continues with them'
[ "$(find "$dir" -name 'parts.csv*' | wc -l)$(ls "$parts.pieces" | wc -l)" = 12 ] || fail "not two pieces only"
batch 3 "$dir/long.csv" -o "$parts" --resume
cp -r "$parts.pieces" "$dir/kept"
again() { cp "$dir"/kept/* "$parts.pieces"; }
# resumed ARGUMENTS...: a run to the end, which writes the whole list and leaves nothing else.
resumed() {
    batch 9 "$dir/long.csv" -k -o "$parts" "$@"
    cmp "$dir/long-whole.csv" "$parts" || fail "another file: $*"
    [ "$(find "$dir" -name 'parts.csv*' | wc -l)" = 1 ] || fail "left-over files: $*"
    mkdir "$parts.pieces"
    again
}
resumed --resume
resumed
# Missing and damaged pieces are scored again; those that are there are used (they are exchanged here, to see that).
first=$(basename "$parts.pieces"/*-0.safetensors) second=$(basename "$parts.pieces"/*-1.safetensors)
rm "$parts.pieces/$first"
resumed --resume
head -c 5000 "$dir/kept/$first" >"$parts.pieces/$first"
sed 's/ggx:/GGX:/' "$dir/kept/$second" | head -c 100000 >"$parts.pieces/$second"
resumed --resume
printf X | dd of="$parts.pieces/$second" bs=1 seek=40000 conv=notrunc 2>"$dir/err"
resumed --resume
cp "$dir/kept/$first" "$parts.pieces/$second"
resumed
cp "$dir/kept/$first" "$parts.pieces/$second"
batch 9 "$dir/long.csv" -k -o "$parts" --resume
[ "$(sed -n '2,257s/.*,\([0-9.]*,.*\)/\1/p' "$parts")" = "$(sed -n '258,513s/.*,\([0-9.]*,.*\)/\1/p' "$parts")" ] || fail "pieces are not used"
# Pieces of another list, model, folder and of other options are refused by name, and kept; what only prints them may differ.
mkdir "$parts.pieces"
again
sed 's/nowhere/anywhere/' "$dir/long.csv" >"$dir/other.csv"
"$NQM_BUILD/tests/tiny_model" "$dir/model21.safetensors" 21
refused() {
    other=$1
    shift
    batch 5 "$@" -k -o "$parts" --resume
    says "parts.csv.pieces was begun with another $other.*: --resume needs the same"
}
refused list "$dir/other.csv"
refused list "$dir/pairs.csv"
refused --metrics "$dir/long.csv" --metrics all
refused --invalid "$dir/long.csv" --invalid zero
refused --root "$dir/long.csv" --root "$dir/sub"
refused model "$dir/long.csv" --model "$dir/model21.safetensors"
diff -r "$dir/kept" "$parts.pieces" || fail "a refused run changed the pieces"
batch 9 "$dir/long.csv" -k -o "$parts" --resume --fail-under 5 --sort worst
batch 9 "$dir/long.csv" -k --fail-under 5 --sort worst
cmp "$dir/out" "$parts" || fail "resumed with a gate"
# What the folder holds beside pieces remains; a file of its name is refused.
mkdir "$parts.pieces"
echo mine >"$parts.pieces/note"
batch 9 "$dir/long.csv" -k -o "$parts"
[ "$(ls "$parts.pieces")" = note ] || fail "in the folder: $(ls "$parts.pieces")"
rm -r "$parts.pieces"
touch "$parts.pieces"
batch 3 "$dir/long.csv" -k -o "$parts"
says 'parts.csv.pieces: cannot create the folder'
rm "$parts.pieces"
batch 3 "$dir/long.csv" --json
[ "$(tail -n 1 "$dir/out")" = ']}' ] || fail "a document of several pieces that ends early must end"

# ---- killed after some pieces, and again: the same bytes. Ctrl-C: 130, and the pieces are kept
pieces() { find "$parts.pieces" -name '*.safetensors' 2>/dev/null | wc -l; }
# stopped SIGNAL N CODE: a run that is sent the signal when it has N pieces, and ends with CODE, or before it.
stopped() {
    "$tool" batch --model "$dir/model.safetensors" "$dir/long.csv" -k -o "$parts" --resume 2>"$dir/err" &
    while [ -d /proc/$! ] && [ "$(pieces)" -lt "$2" ]; do sleep 0.01; done
    kill "-$1" $! 2>/dev/null || true
    got=0
    wait $! 2>/dev/null || got=$?
    [ $got = "$3" ] || [ $got = 9 ] || fail "exit code $got after $1"
    [ ! -e "$parts" ] || cmp "$dir/long-whole.csv" "$parts" || fail "an unfinished file after $1"
}
rm "$parts"
for n in 1 2 4; do stopped KILL $n 137; done
stopped INT 5 130
batch 9 "$dir/long.csv" -k -o "$parts" --resume
cmp "$dir/long-whole.csv" "$parts" || fail "killed and resumed: another file"
[ "$(find "$dir" -name 'parts.csv*' | wc -l)" = 1 ] || fail "killed and resumed: left-over files"

# ---- the number of threads and the size of the cache
OMP_NUM_THREADS=2 batch 9 "$dir/long.csv" -k --cache 0
cmp "$dir/long-whole.csv" "$dir/out" || fail "two threads, no cache: another result"

# ---- usage
batch 2
batch 2 "$dir/pairs.csv" --json --jsonl
batch 2 "$dir/pairs.csv" --resume
batch 2 "$dir/pairs.csv" --invalid maybe
batch 2 "$dir/pairs.csv" --metrics nonsense
batch 3 "$dir/nowhere.csv"
batch 3 "$dir/pairs.csv" -o "$dir/nowhere/x.csv"
printf 'reference\nx\n' >"$dir/bad.csv"
batch 4 "$dir/bad.csv"
says "'test'"
printf 'ref,test\nx,y\n' >"$dir/bad.csv"
batch 4 "$dir/bad.csv"
says "no column 'reference': a list begins with the line reference,test"
printf 'reference,test,jod\n' >"$dir/bad.csv"
batch 4 "$dir/bad.csv"
says "'jod'"
printf 'reference,test\n' >"$dir/none.csv"
batch 0 "$dir/none.csv" -o "$dir/none-out.csv"
[ "$(cat "$dir/none-out.csv")" = 'reference,test,jod,jod_low,jod_high,delta_e_itp,identical,n_valid,novelty,verdict,warnings,error' ] || fail "an empty list"
batch 0 "$dir/none.csv" --json
if [ -c /dev/full ]; then
    got=0
    "$tool" batch --model "$dir/model.safetensors" "$dir/pairs.csv" >/dev/full 2>"$dir/err" || got=$?
    [ "$got" = 3 ] || fail "a full disk: exit code $got"
    batch 3 "$dir/pairs.csv" -o /dev/full
    says '/dev/full: cannot write'
fi
# A run that waits for its list ends when it is interrupted.
mkfifo "$dir/waiting"
"$tool" batch - <"$dir/waiting" 2>"$dir/err" &
waiting=$!
exec 3>"$dir/waiting"
seq 50000 >&3 # more than a pipe holds: some of it is read when this ends
kill -TERM "$waiting"
got=0
wait "$waiting" || got=$?
exec 3>&-
[ "$got" = 130 ] || fail "interrupted while waiting: exit code $got: $(cat "$dir/err")"
