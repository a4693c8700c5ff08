/* SPDX-License-Identifier: MIT
 *
 * OpenEXRCore as a part of the page: nothing is exported.
 */
#define OPENEXR_EXPORT
#define OPENEXR_VERSION_MAJOR 3
#define OPENEXR_VERSION_MINOR 1
#define OPENEXR_VERSION_PATCH 0
#define OPENEXR_VERSION_EXTRA ""
