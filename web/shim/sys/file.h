/* SPDX-License-Identifier: MIT
 *
 * flock() is in wasi.h.
 */
