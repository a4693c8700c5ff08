/* SPDX-License-Identifier: MIT
 *
 * What jansson may use of WebAssembly's C library.
 */
#define HAVE_STDINT_H    1
#define HAVE_SYS_TYPES_H 1
#define HAVE_LOCALE_H    1
#define HAVE_UNISTD_H    1
