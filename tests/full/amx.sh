#!/bin/sh
# SPDX-License-Identifier: MIT
# The kernels for tile registers (AMX) by the instructions themselves, on an emulated processor: Bochs as a Sapphire Rapids starts Debian's
# Linux and runs tests of these kernels, scores and a training. Bochs 3.0 has no "extended feature disable", without which Linux
# enables no tile registers; a module of the kernel (amx/tiles.c) enables them, and amx/preload.c answers for what is then missing. So
# the permission that nqm asks of Linux is not tested. This Bochs multiplies signed bytes as unsigned ones: the tests of bytes below 0
# have to fail.
# Bochs and Linux are those of a Debian 13 in build-amx/root (1 GB, removed by nobody); nothing is installed. Uses the regular build.
# usage: amx.sh [BUILD]    (NQM_MIRROR: another mirror of Debian)
set -eu
cd "$(dirname "$0")/../.."
build=${1:-build} out=$PWD/build-amx
root=$out/root guest=$out/guest
if [ "$(id -u)" != 0 ] || ! command -v debootstrap >/dev/null; then
    echo "needs root and debootstrap"
    exit 77
fi
mkdir -p "$out"

# inside COMMAND...: run it in the Debian 13.
inside() { chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin TERM=xterm DEBIAN_FRONTEND=noninteractive "$@"; }
fetch() {
    rm -rf "$root"
    debootstrap --variant=minbase trixie "$root" ${NQM_MIRROR:+"$NQM_MIRROR"} &&
        inside apt-get install -y --no-install-recommends bochs bochs-term linux-image-cloud-amd64 linux-headers-cloud-amd64 make isolinux \
            syslinux-common xorriso busybox-static && touch "$root/complete"
}
[ -f "$root/complete" ] || fetch >"$out/fetch.log" 2>&1 || {
    echo "cannot make a Debian 13: $(tail -n 1 "$out/fetch.log")"
    exit 77
}
programs="tests/test_kernel_amx tests/tiny_dataset nqm"
# shellcheck disable=SC2086 # a list of names
cmake --build "$build" --target test_kernel_amx tiny_dataset nqm_tool >"$out/build.log" || {
    tail -n 40 "$out/build.log"
    exit 1
}

# The guest's files: programs and their libraries, and a first process that runs them.
rm -rf "$guest" "$root/run-amx"
mkdir -p "$guest/bin" "$guest/lib64" "$guest/lib/x86_64-linux-gnu" "$guest/proc" "$guest/dev" "$guest/tmp" "$root/run-amx/iso"
cp tests/full/amx/tiles.c "$root/run-amx"
echo 'obj-m := tiles.o' >"$root/run-amx/Makefile"
inside sh -c 'make -s -C /lib/modules/*/build M=/run-amx modules' >"$out/module.log" 2>&1
cp "$root/run-amx/tiles.ko" "$guest"
gcc -Wall -Wextra -shared -fPIC -O1 tests/full/amx/preload.c -o "$guest/preload.so"
cp "$root/usr/bin/busybox" "$guest/bin"
for name in $programs; do
    cp "$build/$name" "$guest/bin"
    ldd "$build/$name" | awk '/=> \//{print $3}' >>"$out/libraries"
done
sort -u "$out/libraries" | while read -r library; do cp -L "$library" "$guest/lib/x86_64-linux-gnu"; done
rm "$out/libraries"
cp -L /lib64/ld-linux-x86-64.so.2 "$guest/lib64"
cp tests/full/amx/init "$guest/init"
(cd "$guest" && find . | "$root/usr/bin/busybox" cpio -o -H newc 2>/dev/null | gzip -1) >"$root/run-amx/iso/guest.gz"
cp "$root"/boot/vmlinuz-* "$root/run-amx/iso/linux"
cp "$root/usr/lib/ISOLINUX/isolinux.bin" "$root/usr/lib/syslinux/modules/bios/ldlinux.c32" "$root/run-amx/iso"
# Without ACPI, which Bochs 3.0 and this Linux do not agree on; a processor that the kernel takes for one without tile registers.
cat >"$root/run-amx/iso/isolinux.cfg" <<'TEXT'
default linux
label linux
 kernel /linux
 append initrd=/guest.gz console=ttyS0 quiet mitigations=off acpi=off reboot=t panic=1 clearcpuid=amx_tile
TEXT
inside xorriso -as mkisofs -quiet -o /run-amx/guest.iso -b isolinux.bin -c boot.cat -no-emul-boot -boot-load-size 4 -boot-info-table \
    /run-amx/iso 2>"$out/iso.log"
cat >"$root/run-amx/bochsrc" <<'TEXT'
megs: 1024
cpu: model=sapphire_rapids, ips=50000000, reset_on_triple_fault=0
romimage: file=/usr/share/bochs/BIOS-bochs-latest
vgaromimage: file=/usr/share/bochs/VGABIOS-lgpl-latest
ata0-master: type=cdrom, path=/run-amx/guest.iso, status=inserted
boot: cdrom
com1: enabled=1, mode=file, dev=/run-amx/printed
display_library: term
log: /run-amx/log
panic: action=fatal
TEXT

# Bochs draws its screen on a terminal; without the real folders it waits a millisecond at each step. Restarting ends it.
trap 'umount "$root/dev/pts" "$root/dev" "$root/proc"' EXIT
mount -t proc proc "$root/proc"
mount --bind /dev "$root/dev"
mount --bind /dev/pts "$root/dev/pts"
timeout 3600 script -qfc "chroot '$root' /usr/bin/env TERM=xterm bochs -q -f /run-amx/bochsrc" "$out/screen" >/dev/null 2>&1 </dev/null || true
tr -d '\r' <"$root/run-amx/printed" >"$out/printed"
failed=$(grep '^\[  FAILED  \] [a-z]' "$out/printed" | grep -v ' int8_[a-z_]*_of_the_processor$' | sort -u || true)
n=$(grep -c '^\[       OK \] [a-z0-9_]*_of_the_processor$' "$out/printed" || true)
if [ -n "$failed" ] || [ "$n" != 6 ] || ! grep -q '^end$' "$out/printed"; then
    cat "$out/printed"
    exit 1
fi
scores=$(sed -n 's/^score //p' "$out/printed" | tr '\n' ' ')
losses=$(sed -n 's/^loss //p' "$out/printed" | tr '\n' ' ')
# Sums round in another order. (Both scores are wrong by the same: this Bochs rounds floats to bfloat16 in another way than processors.)
echo "$scores $losses" | awk '{exit !(NF == 4 && ($1 - $2) ^ 2 < 0.003 ^ 2 && ($3 - $4) ^ 2 < (0.02 * $4) ^ 2)}' || {
    echo "scores $scores, losses $losses"
    exit 1
}
echo "$n tests by tile registers; scores $scores; losses of a training $losses"
