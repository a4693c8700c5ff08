/* SPDX-License-Identifier: MIT
 *
 * The configuration of expat for WebAssembly.
 */
#define BYTEORDER         1234
#define XML_CONTEXT_BYTES 1024
#define XML_DTD           1
#define XML_NS            1
#define XML_POOR_ENTROPY  1 /* documents come from the user of the page: nobody floods its hash tables */
