/* SPDX-License-Identifier: MIT
 *
 * Preloaded into the programs of ../amx.sh, for what its emulated processor and its kernel lack: the permission to use
 * tile registers; the instruction STTILECFG, which Bochs 3.0 does not know; and tile registers of each thread, which a
 * real-time priority replaces: no thread takes the place of another while it uses them.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <sched.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <string.h>
#include <sys/syscall.h>
#include <ucontext.h>

typedef void (*handler)(int);

long syscall(long number, ...) {
    enum { ARCH_REQ_XCOMP_PERM = 0x1023 };
    long a[6];
    va_list list;
    va_start(list, number);
    for (int i = 0; i < 6; ++i)
        a[i] = va_arg(list, long);
    va_end(list);
    if (number == SYS_arch_prctl && a[0] == ARCH_REQ_XCOMP_PERM)
        return 0;
    long (*const next)(long, ...) = (long (*)(long, ...))dlsym(RTLD_NEXT, "syscall");
    return next(number, a[0], a[1], a[2], a[3], a[4], a[5]);
}

/* cmocka would handle illegal instructions as faults of a test. */
handler signal(int number, handler to) {
    handler (*const next)(int, handler) = (handler(*)(int, handler))dlsym(RTLD_NEXT, "signal");
    return number == SIGILL ? SIG_DFL : next(number, to);
}

/* STTILECFG with a displacement of 8 bits from the stack pointer, as compilers write it: VEX.128.66.0F38.W0 49 !(11):000:bbb. The
 * kernels store the configuration of their caller, and no caller here has one. */
static void illegal(int number, siginfo_t *info, void *user) {
    static const uint8_t stored[] = {0xc4, 0xe2, 0x79, 0x49, 0x44, 0x24};
    greg_t *const r = ((ucontext_t *)user)->uc_mcontext.gregs;
    const uint8_t *const at = (const uint8_t *)r[REG_RIP];
    (void)info;
    if (memcmp(at, stored, sizeof stored) != 0) {
        sigaction(number, &(struct sigaction){.sa_handler = SIG_DFL}, NULL);
        return;
    }
    memset((char *)r[REG_RSP] + (int8_t)at[sizeof stored], 0, 64);
    r[REG_RIP] += (greg_t)sizeof stored + 1;
}

__attribute__((constructor)) static void begin(void) {
    sigaction(SIGILL, &(struct sigaction){.sa_sigaction = illegal, .sa_flags = SA_SIGINFO}, NULL);
    sched_setscheduler(0, SCHED_FIFO, &(struct sched_param){.sched_priority = 1});
}
