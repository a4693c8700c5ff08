/* SPDX-License-Identifier: MIT
 *
 * A module of the Linux kernel that enables tile registers, for ../amx.sh.
 */
#include <linux/module.h>

static int __init enable(void) {
    const u32 both = 3 << 17; /* configuration and data */
    u32 low, high;
    asm volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    asm volatile("xsetbv" ::"a"(low | both), "d"(high), "c"(0));
    return 0;
}

module_init(enable);
MODULE_LICENSE("Dual MIT/GPL");
