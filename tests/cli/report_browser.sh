#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm report in a headless browser without network: the page shows the JOD, text and pictures are visible and fit the
# width of a desktop and of a phone, a dark screen has a dark page, and each test is printed on one sheet, A4 or Letter.
# Skipped without Chromium or xmllint, and under sanitizers, where the page has the same bytes.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
browser=$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)
[ -z "${NQM_SANITIZE:-}" ] || exit 77
{ [ -n "$browser" ] && command -v xmllint >/dev/null; } || exit 77
page=$dir/page.html
"$tool" report sgd:nickel ward:nickel "perturb:gloss=0.7;of=sgd:nickel" --size 120 -o "$page" || fail "no page"
jod=$(xmllint --xpath 'string(//table[@class="summary"]/tbody/tr[1]/td[2]/strong)' "$page")

# browse OPTION...: open the page with a new profile.
browse() {
    rm -rf "$dir/profile"
    timeout 1800 "$browser" --headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking \
        --disable-component-update --disable-sync --disable-dev-shm-usage --host-resolver-rules='MAP * ~NOTFOUND' \
        --proxy-server=127.0.0.1:9 --hide-scrollbars --user-data-dir="$dir/profile" "$@" "file://$page" 2>"$dir/err"
}

# ---- the document as parsed by the browser, which reports a violated policy
browse --enable-logging=stderr --dump-dom >"$dir/dom.html" || fail "the browser does not open the page"
grep -q "<strong>$jod</strong>" "$dir/dom.html" || fail "no JOD $jod in the browser's document"
# The script has drawn the charts: a scale, four slices and a map for each of the two tests.
[ "$(grep -o '<svg ' "$dir/dom.html" | wc -l) $(grep -o '<canvas ' "$dir/dom.html" | wc -l)" = "10 2" ] || fail "charts"
[ "$(grep -o '<path class="\(ref\|test\)"' "$dir/dom.html" | wc -l)" = 16 ] || fail "curves of both"
! grep -qi 'Content.Security.Policy' "$dir/err" || fail "the page breaks its own policy"

# ---- the screen: the requested size, dark text on white, the colours of pictures and maps
# colours FILE: print the number of distinct colours, the percentage of white pixels, and the number of white columns at
# the right.
colours() { "${NQM_BUILD:?}/tests/png_colours" "$1"; }
for width in 1280 400; do
    browse --window-size=$width,3000 --screenshot="$dir/shot.png" >/dev/null || fail "no picture of the screen"
    [ "$(png_size "$dir/shot.png")" = "$width 3000" ] || fail "size of the picture: $(png_size "$dir/shot.png")"
    # shellcheck disable=SC2046
    set -- $(colours "$dir/shot.png")
    { [ "$1" -gt 1000 ] && [ "$2" -gt 30 ] && [ "$2" -lt 97 ]; } || fail "$width wide: $1 colours, $2 % white"
    [ "$3" -ge 12 ] || fail "$width wide: only $3 pixels are free at the right"
done

# The browser enforces the policy: under a policy that forbids pictures, few colours remain.
cp "$page" "$dir/whole.html"
sed "s/img-src data:/img-src 'none'/" "$dir/whole.html" >"$page"
browse --enable-logging=stderr --window-size=400,3000 --screenshot="$dir/shot.png" >/dev/null || fail "no picture of the screen"
grep -qi 'Content.Security.Policy' "$dir/err" || fail "a broken policy is not told"
# shellcheck disable=SC2046
set -- $(colours "$dir/shot.png")
[ "$1" -lt 500 ] || fail "$1 colours without pictures"
mv "$dir/whole.html" "$page"

# ---- a dark screen: no white at the edge, the same pictures
browse --blink-settings=preferredColorScheme=0 --window-size=1280,3000 --screenshot="$dir/shot.png" >/dev/null || fail "no picture of the screen"
# shellcheck disable=SC2046
set -- $(colours "$dir/shot.png")
{ [ "$1" -gt 1000 ] && [ "$2" -lt 30 ] && [ "$3" = 0 ]; } || fail "dark: $1 colours, $2 % white, $3 white columns"

# ---- printing: one sheet for the summary, one for each of the two tests, one for the guide
mv "$page" "$dir/whole.html"
for size in A4 letter; do
    sed "s/@page{/@page{size:$size;/" "$dir/whole.html" >"$page"
    cmp -s "$page" "$dir/whole.html" && fail "no @page"
    browse --no-pdf-header-footer --print-to-pdf="$dir/page.pdf" >/dev/null || fail "no print"
    sheets=$(grep -ac '/Type */Page\>' "$dir/page.pdf")
    [ "$sheets" = 4 ] || fail "$sheets sheets of $size"
done
