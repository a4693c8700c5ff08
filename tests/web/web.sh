#!/bin/sh
# SPDX-License-Identifier: MIT
# The module in node and the page in a headless browser, as `./dev web` has built them. Skipped where it has not run, and without node; without
# Chromium only the module is tested.
set -eu
built=${NQM_SOURCE:?}/build-web
{ [ -f "$built/nqm.html" ] && command -v node >/dev/null; } || exit 77
for file in "$NQM_SOURCE"/web/*.js "$NQM_SOURCE"/web/page.* "$NQM_SOURCE"/web/src/*.c; do
    [ -z "$(find "$file" -newer "$built/nqm.html")" ] || {
        echo "$file is newer than $built/nqm.html: run ./dev web"
        exit 77
    }
done
[ "$(wc -c <"$built/nqm.html")" -le 6000000 ]
node "$NQM_SOURCE/tests/web/module.mjs" "$built/npm" "${NQM_TOOL:?}"
browser=$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)
[ -z "$browser" ] || node "$NQM_SOURCE/tests/web/page.mjs" "$built/nqm.html" "$NQM_TOOL" "$browser"
