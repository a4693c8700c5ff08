#!/bin/sh
# SPDX-License-Identifier: MIT
# Install the wheel of build/wheel in a bare Debian 12 and a bare Debian 13 (debootstrap; folders that are removed afterwards), which have
# only Python, pip and NumPy, and use it as a new user would. Prints what is typed and answered. Needs root and a mirror.
# shellcheck disable=SC2016 # the shell in the root expands what is quoted here
# usage: packages/wheel_test.sh [RELEASE...]   (after ./dev wheel, from the folder of ./dev; NQM_MIRROR: another mirror)
set -eu
[ $# -gt 0 ] || set -- bookworm trixie
root=$(mktemp -d) failed=0
trap 'umount "$root"/*/proc 2>/dev/null || true; rm -rf "$root"' EXIT
chmod 755 "$root"

# inside COMMAND: run a command of a new user, show it and what it prints.
inside() {
    printf '\n# %s\n' "$1"
    chroot "$root/$release" /usr/bin/env -i PATH=/home/venv/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/home LC_ALL=C.UTF-8 \
        DEBIAN_FRONTEND=noninteractive bash -c "cd /home && $1" 2>&1 || {
        echo "exit code $?"
        failed=1
    }
}
for release in "$@"; do
    debootstrap --variant=minbase "$release" "$root/$release" ${NQM_MIRROR:+"$NQM_MIRROR"} >build/wheel/debootstrap.log 2>&1 || {
        tail build/wheel/debootstrap.log
        exit 1
    }
    mount -t proc proc "$root/$release/proc" 2>/dev/null || echo "without /proc"
    cp build/wheel/*.whl python/notebook.py python/tutorial.ipynb "$root/$release/home"
    inside 'apt-get update -qq; apt-get install -y -qq --no-install-recommends python3-venv python3-numpy >/dev/null 2>&1; echo "a Debian $(cat /etc/debian_version), $(python3 --version), packages of development: $(dpkg -l "*-dev" 2>/dev/null | grep -c ^ii)"'
    inside 'python3 -m venv --system-site-packages venv && time pip install -q --no-index ./nqm-*.whl && ls -l venv/bin/nqm'
    inside 'time nqm score sgd:nickel ward:nickel'
    inside 'nqm --help | head -n 5'
    inside 'nqm fit sgd:nickel --model ggx'
    inside 'nqm label sgd:nickel ward:nickel'
    inside 'nqm render sgd:brass -o brass.png && ls -l brass.png'
    inside 'nqm info --models; nqm doctor'
    inside "python3 - <<'END'
import math
import nqm
def lambert(wi, wo):
    return 0.5 / math.pi + 0 * wi  # (n, 3)
print(nqm.__version__, nqm.score('sgd:nickel', lambert))
print(nqm.score('sgd:nickel', 'ward:nickel'), nqm.label('sgd:nickel', 'ward:nickel').jod)
END"
    inside 'python3 notebook.py tutorial.ipynb && echo "the notebook prints what it stores"'
    inside 'pip uninstall -q -y nqm && ! command -v nqm && echo "removed"'
done
[ $failed = 0 ] || echo "a command failed"
exit $failed
