/* SPDX-License-Identifier: MIT
 *
 * OpenEXR without threads.
 */
