# shellcheck shell=sh
# SPDX-License-Identifier: MIT
# What the command-line tests share: the tool under test, a folder that goes away with the test, and the way to fail.
# Source it first: . "${NQM_SOURCE:?}/tests/support/cli.sh"
set -eu
# shellcheck disable=SC2034 # the tests that source this use it
tool=${NQM_TOOL:?}
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT

# fail MESSAGE: end the test; what the tool said last, if the test kept it in err, says why.
fail() {
    echo "$1"
    [ ! -f "$dir/err" ] || cat "$dir/err"
    exit 1
}
