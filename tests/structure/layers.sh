#!/bin/sh
# SPDX-License-Identifier: MIT
# The sources obey src/LAYERS: its rooms are the folders of src/ and tools/; a room lists only rooms of lower layers; every
# #include of an internal or public header, and every symbol that an object file takes from another room, belongs to a room that the
# list allows; likewise for the folders of a room. The table of doc/design.md has the same rooms.
set -eu
build=${NQM_BUILD:?}
cd "${NQM_SOURCE:-$(dirname "$0")/../..}"
files=$(find src tools include/nqm -name '*.[ch]' ! -name nqm.h)
# shellcheck disable=SC2086
awk '
    FILENAME == "src/LAYERS" {
        if ($0 ~ /^#/ || NF == 0) next
        if ($1 == "inside") {
            sub(/:$/, "", $2); allowed[$2, $2] = 1; inside[$2] = 1
            for (i = 3; i <= NF; ++i) allowed[$2, $i] = 1
            next
        }
        if ($1 ~ /^</) { owner[substr($1, 2, length($1) - 2)] = $2; next }
        room = $1; layer[room] = $2 + 0; listed[++n] = room
        allowed[room, room] = 1
        for (i = 3; i <= NF; ++i) { allowed[room, $i] = 1; uses[room] = uses[room] " " $i }
        next
    }
    FNR == 1 {
        split(FILENAME, path, "/"); from = path[2]
        folder = path[2] "/" path[3]
        if (path[1] == "include") from = owner[path[2] "/" path[3]]
        else seen[from] = 1
        if (from == "") { printf "%s: src/LAYERS does not say which room implements it\n", FILENAME; bad = 1 }
    }
    /^[ \t]*#[ \t]*include[ \t]*["<]/ {
        split($0, quoted, /["<>]/); name = quoted[2]; m = split(name, part, "/")
        if ($0 ~ /"/) to = m > 1 ? part[1] : from
        else if (name in owner) to = owner[name]
        else next
        ++count
        if (!allowed[from, to]) {
            printf "%s:%d: room %s may not use %s (%s)\n", FILENAME, FNR, from, to, name; bad = 1
        }
        if (folder in inside && $0 ~ /"/ && from == to && m > 2 && !allowed[folder, part[1] "/" part[2]]) {
            printf "%s:%d: the folder %s may not use %s\n", FILENAME, FNR, folder, name; bad = 1
        }
    }
    END {
        for (i = 1; i <= n; ++i) {
            m = split(uses[listed[i]], u, " ")
            for (j = 1; j <= m; ++j) if (!(u[j] in layer) || layer[u[j]] >= layer[listed[i]]) {
                printf "src/LAYERS: %s (layer %d) names %s, which is not on a lower layer\n", listed[i], layer[listed[i]], u[j]; bad = 1
            }
            if (!(listed[i] in seen)) { printf "src/LAYERS: there is no room %s\n", listed[i]; bad = 1 }
        }
        for (s in seen) if (!(s in layer)) { printf "room %s is not in src/LAYERS\n", s; bad = 1 }
        if (count < 400) { printf "only %d includes were found: the test is broken\n", count; bad = 1 }
        exit bad
    }' src/LAYERS $files

# doc/design.md has a table of the same rooms on the same layers, in the same order.
sed -n 's/^\([a-z]*\) *\([0-9]*\):.*/\2 \1/p' src/LAYERS >"$build/layers.txt"
sed -n 's/^| \([0-9]*\) | \([a-z]*\) |.*/\1 \2/p' doc/design.md | diff "$build/layers.txt" - || {
    echo "the table of doc/design.md (>) differs from src/LAYERS (<)"
    exit 1
}

# Only the objects of the present build: an old folder also has those of targets that are gone.
objects=$(grep -o 'CMakeFiles/nqm[^ ]*\.dir/\(src\|tools\)/[^ ]*\.o' "$build/compile_commands.json" | sort -u | sed 's|^CMakeFiles/||')
# shellcheck disable=SC2086
(cd "$build/CMakeFiles" && nm -A $objects) | awk '
    FILENAME != "-" {
        if ($1 == "inside") {
            sub(/:$/, "", $2); allowed[$2, $2] = 1; inside[$2] = 1
            for (i = 3; i <= NF; ++i) allowed[$2, $i] = 1
        } else if ($0 !~ /^[#<]/ && NF) { allowed[$1, $1] = 1; for (i = 3; i <= NF; ++i) allowed[$1, $i] = 1 }
        next
    }
    {
        split($0, halves, ".o:"); path = halves[1]; sub(/.*\.dir\/(src|tools)\//, "", path)
        n_parts = split(path, part, "/"); room = part[1]
        folder = n_parts > 2 ? part[1] "/" part[2] : part[1]
        kind = $(NF - 1); symbol = $NF
        if (symbol !~ /^nqm_/) next
        if (kind == "U") { needed[++n] = symbol; by[n] = room; from[n] = folder; file[n] = path }
        else if (kind ~ /[A-Z]/) { home[symbol] = room; home_folder[symbol] = folder }
    }
    END {
        for (i = 1; i <= n; ++i) if (needed[i] in home) {
            ++count
            if (!allowed[by[i], home[needed[i]]]) {
                printf "%s uses %s of room %s, which %s may not\n", file[i], needed[i], home[needed[i]], by[i]; bad = 1
            }
            if (from[i] in inside && by[i] == home[needed[i]] && !allowed[from[i], home_folder[needed[i]]]) {
                printf "%s uses %s of %s, which %s may not\n", file[i], needed[i], home_folder[needed[i]], from[i]; bad = 1
            }
        }
        if (count < 1000) { printf "only %d uses were found: the test is broken\n", count; bad = 1 }
        exit bad
    }' src/LAYERS -
