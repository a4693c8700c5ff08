/* SPDX-License-Identifier: MIT
 *
 * No Imath: OpenEXRCore has its own conversions of half.
 */
#define IMATH_VERSION_MAJOR 0
#define IMATH_VERSION_MINOR 0
