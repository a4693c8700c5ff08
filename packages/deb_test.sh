#!/bin/sh
# SPDX-License-Identifier: MIT
# Install the packages of build/deb in a bare Debian 12 (debootstrap; a folder that is removed afterwards) and use them as a new user
# would. Prints what is typed and answered. Needs root and a mirror.
# usage: packages/deb_test.sh    (after ./dev deb, from the folder of ./dev; NQM_MIRROR: another mirror)
# shellcheck disable=SC2016 # the shell in the root expands what is quoted here
set -eu
root=$(mktemp -d)
chmod 755 "$root" # other users of the root enter it too
trap 'umount "$root/proc" 2>/dev/null || true; rm -rf "$root"' EXIT
debootstrap --variant=minbase bookworm "$root" ${NQM_MIRROR:+"$NQM_MIRROR"} >build/deb/debootstrap.log 2>&1 || {
    tail build/deb/debootstrap.log
    exit 1
}
mount -t proc proc "$root/proc" 2>/dev/null || echo "without /proc"
# A minimal root leaves out manual pages; a usual installation does not.
rm -f "$root/etc/dpkg/dpkg.cfg.d/docker"
mkdir "$root/packages"
cp build/deb/*.deb "$root/packages"
failed=0

# inside COMMAND: run a command of a new user, show it and what it prints.
inside() {
    printf '\n# %s\n' "$1"
    chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root TERM=dumb LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive \
        MANWIDTH=100 bash -c "$1" 2>&1 || {
        echo "exit code $?"
        failed=1
    }
}
inside 'apt-get update -qq; apt-get install -y -qq --no-install-recommends man-db bash-completion gcc libc6-dev pkg-config >/dev/null 2>&1 && echo "a Debian $(cat /etc/debian_version)"'
inside 'cd /packages && apt-get install -y ./*.deb | tail -n 4'
inside 'nqm score sgd:nickel ward:nickel'
inside 'man nqm-score | col -b | head -n 20'
inside 'man nqm | col -b | sed -n 1,12p'
inside 'source /usr/share/bash-completion/bash_completion; source /usr/share/bash-completion/completions/nqm; COMP_WORDS=(nqm sc) COMP_CWORD=1; _nqm; echo "nqm sc<TAB>: ${COMPREPLY[*]}"; COMP_WORDS=(nqm score --invalid "") COMP_CWORD=3; _nqm; echo "nqm score --invalid <TAB>: ${COMPREPLY[*]}"'
inside 'cd /usr/share/doc/nqm/examples && cc score_files.c $(pkg-config --cflags --libs nqm) -o /tmp/score_files && /tmp/score_files sgd:nickel ward:nickel'
inside "python3 - <<'END'
import math
import nqm
def lambert(wi, wo):
    return 0.5 / math.pi + 0 * wi  # (n, 3)
print(nqm.__version__, nqm.score('sgd:nickel', lambert))
print(nqm.score('sgd:nickel', 'ward:nickel'))
END"
inside 'cat > /tmp/gold.gltf <<END
{"asset": {"version": "2.0"}, "materials": [{"name": "gold", "pbrMetallicRoughness":
  {"baseColorFactor": [1, 0.766, 0.336, 1], "metallicFactor": 1, "roughnessFactor": 0.3}}]}
END
nqm translate /tmp/gold.gltf --to openpbr -o /tmp/gold.mtlx && cat /tmp/gold.mtlx'
inside 'nqm doctor'
inside 'apt-get remove -y -qq nqm libnqm0 libnqm-dev python3-nqm >/dev/null 2>&1 && ! command -v nqm && echo "removed"'
[ $failed = 0 ] || echo "a command failed"
exit $failed
