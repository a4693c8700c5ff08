#!/bin/sh
# SPDX-License-Identifier: MIT
# Every #include "module/..." under src/ must be allowed by src/LAYERS, modules of LAYERS and folders of src/ must be the same,
# a module may only name modules of lower layers, and the tool may include public headers and its own only.
set -eu
cd "${NQM_SOURCE:-$(dirname "$0")/../..}"
awk '
    FILENAME == "src/LAYERS" {
        if ($0 ~ /^#/ || NF == 0) next
        module = $1; layer[module] = $2 + 0; listed[++n] = module
        allowed[module, module] = 1
        for (i = 3; i <= NF; ++i) { allowed[module, $i] = 1; uses[module] = uses[module] " " $i }
        next
    }
    /^[ \t]*#[ \t]*include[ \t]*"/ {
        split(FILENAME, path, "/"); from = path[2]
        split($0, quoted, "\""); m = split(quoted[2], part, "/")
        to = m > 1 ? part[1] : from
        seen[from] = 1; ++count
        if (to != "generated" && !allowed[from, to]) {
            printf "%s:%d: module %s may not include %s\n", FILENAME, FNR, from, quoted[2]; bad = 1
        }
    }
    END {
        for (i = 1; i <= n; ++i) {
            m = split(uses[listed[i]], u, " ")
            for (j = 1; j <= m; ++j) if (!(u[j] in layer) || layer[u[j]] >= layer[listed[i]]) {
                printf "src/LAYERS: %s (layer %d) names %s, which is not below it\n", listed[i], layer[listed[i]], u[j]; bad = 1
            }
        }
        for (s in seen) if (!(s in layer)) { printf "src/%s is not in src/LAYERS\n", s; bad = 1 }
        if (count < 50) { printf "only %d includes were read: the test looks at nothing\n", count; bad = 1 }
        exit bad
    }' src/LAYERS src/*/*.[ch]
if grep -nE '#[ \t]*include[ \t]*"' tools/nqm/*.[ch] | grep -vE '"[a-z_]+\.h"'; then
    echo "tools/nqm may include public headers and its own only"
    exit 1
fi
