#!/bin/sh
# SPDX-License-Identifier: MIT
# What the command line refuses: each line of refusals.txt, with nothing on standard output and no file left or changed.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
mkdir "$dir/work"
cd "$dir/work"

material() {
    cat >"$1" <<END
{"asset": {"version": "2.0"}, "materials": [{"name": "glass", $3 "pbrMetallicRoughness": {"metallicFactor": 0},
"extensions": {"KHR_materials_transmission": {"transmissionFactor": $2}}}]}
END
}
material half.gltf 0.5 ''
material glow.gltf 1 '"emissiveFactor": [1, 0, 0],'
echo '{"asset": {"version": "2.0"}, "materials": [{"name": "brass"}, {"name": "wood"}]}' >two.gltf
echo '{"asset": {"version": "2.0"}, "materials": [{"name": "a"}, {"name": "b"}, {"name": "a"}]}' >twins.gltf
python3 "$NQM_SOURCE/examples/maps.py" . 4
"$tool" directions -n 20 -o directions.csv 2>"$dir/err"
printf 'theta_h,theta_d,phi_d\n10,20,30\n89,80,0\n' >horizon.csv
printf 'reference,test,score\nsgd:nickel,ward:nickel,1\n' >opinions.csv
printf 'reference,test\nsgd:nickel,ward:nickel\n' >pairs.csv
printf 'reference,test,split\na,b,tset\n' >split.csv
printf 'DeltaE,score\n1,2\n2,3\n3,4\n4,5\n' >column.csv
printf 'DeltaE,JOD\n1,9\n2,x\n3,4\n4,5\n' >number.csv
printf 'DeltaE,JOD\n1,9\n' >short.csv
printf 'r,g,b\n1,2,3\n' >values.csv
printf 'DDS \174\0\0\0' >a.dds
echo nonsense >bad.bsdf
: >empty.csv
mkdir folder empty
ln -s folder other
ln -s nowhere.csv dangling.csv
ln -s /dev/null nothing.gltf
contents() { { find . && find . -type f -exec cksum {} +; } | sort; }
contents >"$dir/before"

n=0
while IFS='|' read -r code words arguments; do
    case $code in '#'* | '') continue ;; esac
    words=${words# } code=${code% } got=0
    words=${words% }
    eval "set -- $arguments"
    "$tool" "$@" >"$dir/out" 2>"$dir/err" || got=$?
    [ "$got" = "$code" ] || fail "exit code $got, not $code:$arguments"
    message=
    while IFS= read -r line; do message="$message$line "; done <"$dir/err"
    rest=$message
    while :; do # the words between stars, in their order
        part=${words%%\**}
        case $rest in *"$part"*) rest=${rest#*"$part"} ;; *) fail "no '$part' in the message:$arguments" ;; esac
        case $words in *\**) words=${words#*\*} ;; *) break ;; esac
    done
    [ ! -s "$dir/out" ] || fail "results on failure:$arguments"
    n=$((n + 1))
done <"$NQM_SOURCE/tests/cli/refusals.txt"
[ $n -gt 190 ] || fail "only $n lines"
contents | diff "$dir/before" - || fail "files are left, or changed"
export NQM_KERNELS=abacus
refuses 2 "abacus.*scalar" score sgd:nickel sgd:nickel
