#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm help: what is made from the option tables (man pages, Markdown, completions), and what near names do not hinder; refusals.txt
# has the misspelt ones.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
verbs=$("$tool" --help | sed -n 's/^  \([a-z]*\)  .*/\1/p')
cd "$dir"

# Every verb has a page with its options, its usage and its examples, in each form; every option that names an output has the check of
# its ending.
mkdir help man
for verb in $verbs; do
    "$tool" "$verb" --help >"help/$verb"
    "$tool" help "$verb" | cmp -s - "help/$verb" || fail "help $verb differs from $verb --help"
    "$tool" help "$verb" --format man >"man/$verb"
done
awk '
    FNR == 1 {split(FILENAME, part, "/"); verb = part[2]; table = 0}
    /^options:/ {table = 1}
    /^example:/ {table = 0}
    part[1] == "help" && table && length > 110 {print verb " --help has a long line: " $0}
    part[1] == "help" && table && match($0, /--[a-z0-9-]+/) {option[verb " " substr($0, RSTART, RLENGTH)]}
    part[1] == "help" && /--(output|report|pairs|map|grid|junit|markdown|log) (FILE|CSV)( |$)/ && !/extension selects/ {
        print verb ": an output of any name: " $0}
    part[1] == "man" && /^[.\047][^A-Z\\bnf]/ {print "nqm-" verb ".1 has text that begins like a command: " $0}
    part[1] == "man" {gsub(/\\-/, "-"); page[verb] = page[verb] "\n" $0}
    END {
        for (key in option) {
            split(key, word, " ")
            n++
            if (!index(page[word[1]], word[2])) print "nqm-" word[1] ".1 lacks " word[2]}
        for (verb in page) if (!index(page[verb], "\nnqm-" verb " - ")) print "nqm-" verb ".1 has no name"
        if (n < 200) print "only " n " options"
    }' help/* man/* >faults
[ ! -s faults ] || fail "$(cat faults)"
"$tool" help --format man >page
text=$(cat page)
for verb in $verbs; do
    case $text in *nqm?-"$verb"*) ;; *) fail "nqm.1 lacks $verb" ;; esac
done
if command -v man >/dev/null && man --warnings -l page >out 2>err; then
    [ ! -s err ] || fail "man warns of nqm.1"
fi

# The page of the reference is up to date.
run 0 help --format markdown
diff "$NQM_SOURCE/doc/reference-cli.md" out >err || fail "doc/reference-cli.md is old: run ./dev pages"

# bash: completes verbs, options, words of an option and of the first argument, and leaves files to the shell.
"$tool" help --format bash >completion
touch lambda-nothing
cat >complete.bash <<'END'
source completion || exit 1
nqm() { "$NQM_BUILD/nqm" "$@"; }
# completes EXPECTED WORD...: the last word is being typed.
completes() {
    local expected=$1
    shift
    COMP_WORDS=(nqm "$@") COMP_CWORD=$# COMPREPLY=()
    _nqm
    [ "${COMPREPLY[*]}" = "$expected" ] || { echo "bash completes nqm $* to '${COMPREPLY[*]}', not '$expected'" >err; exit 1; }
}
completes "score" sc
completes "--min-valid" score a b --min-v
completes "drop" score --invalid d
completes "bf16" train --precision = bf
completes "make" transport ma
completes "man markdown" help --format ma
completes "" score nickel.bin
completes "default" score --model de
completes "transport transport-paper" score -m tr
completes "open-pbr openpbr" translate --to op
completes "sgd:nickel" score sgd:nick
completes "nickel" score sgd : nick
completes "nickel" score ref = sgd : nick
completes "lambda-nothing" score lambda-no
END
if command -v bash >/dev/null; then
    bash complete.bash || fail "completion of bash"
fi
for shell in zsh fish; do
    run 0 help --format $shell
    text=$(cat out)
    for verb in $verbs; do
        case $text in *"$verb"*) ;; *) fail "$shell: no $verb" ;; esac
    done
    if command -v $shell >/dev/null; then
        $shell -n out 2>err || fail "$shell cannot read its completion"
    fi
done

# What is near a name, and right.
run 0 score --version
grep -q "^nqm [0-9]" out || fail "score --version"
run 0 info list sgd:nick
[ "$(cat out)" = sgd:nickel ] || fail "presets with a word"
run 3 info ward.binary
says "ward.binary: No such file or directory"
grep -q 'did you mean' err && fail "a hint for a file's name: $(cat err)"
for wrong in 'ggx;alpha=.1' 'ggx=alpha=.1' 'ggx,alpha=.1' 'ggx alpha=.1'; do
    run 2 score sgd:nickel "$wrong" -q
    grep -q "follows the model: 'ggx:alpha=.1'" err || fail "$wrong is read as a name"
done
run 0 rank sgd:nickel ggx=ward:nickel -q -m transport
run 0 directions -o set-1.2 # a number is not an ending
run 0 convert lambert:kd=.2 -o x.npy
grep -q 'nodes of a .npy array' out || fail "the format of a .npy name"
