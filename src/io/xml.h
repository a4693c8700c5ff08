/* SPDX-License-Identifier: MIT
 *
 * xml.h - the elements and attributes of an XML document, read by expat. Character data, comments and processing instructions
 * are skipped. A document type declaration is refused, so that there are no entities; nothing is ever fetched.
 */
#ifndef NQM_SRC_IO_XML_H
#define NQM_SRC_IO_XML_H

#include "base/base.h"

typedef struct nqm_xml_attribute {
    const char *name, *value;
} nqm_xml_attribute;

/** An element; names keep their prefix ("xi:include"). All pointers are valid until the document is freed. */
typedef struct nqm_xml_element {
    const char *name;
    int64_t byte_offset; /**< of its '<' */
    size_t n_attributes;
    const nqm_xml_attribute *attributes;
    struct nqm_xml_element *parent, *first, *next; /**< first child, next sibling; NULL: none */

    struct nqm_xml_element *last; /* child */
} nqm_xml_element;

typedef struct nqm_xml {
    nqm_xml_element *root;
    size_t n_elements;
    struct nqm_xml_block *blocks; /* memory of all elements */
} nqm_xml;

enum { NQM_XML_MAX_DEPTH = 64, NQM_XML_MAX_BYTES = 64 << 20 };
/** More elements than this and one for every 20 bytes are refused, so that memory is at most ten times the file, or 12 MB. */
enum { NQM_XML_FREE_ELEMENTS = 1 << 16, NQM_XML_BYTES_PER_ELEMENT = 20 };

/** Parse a document. NQM_ERR_FORMAT: not well-formed, or with a document type; NQM_ERR_LIMIT: more than
 *  NQM_XML_MAX_BYTES, too many elements, or elements nested more deeply than NQM_XML_MAX_DEPTH. `path` is for messages.
 *  On failure *xml_ret is empty. */
NQM_MUST_CHECK nqm_status nqm_xml_parse(const void *data, size_t n_bytes, const char *path, nqm_xml *xml_ret,
                                        nqm_error *err);
void nqm_xml_free(nqm_xml *xml);
/** Append an element (parent NULL: the root), for documents that are built in memory. attributes: names
 *  and values, then NULL; texts are copied. NULL: out of memory. */
nqm_xml_element *nqm_xml_append(nqm_xml *xml, nqm_xml_element *parent, const char *name, const char *const *attributes,
                                int64_t byte_offset);
/** The value of an attribute; NULL: the element does not have it. */
const char *nqm_xml_get(const nqm_xml_element *element, const char *attribute);
/** A table with room for max_n elements, and all of a document (NULL: none) that have an attribute `name`; they must outlive it. */
NQM_MUST_CHECK nqm_status nqm_xml_names_create(size_t max_n, const nqm_xml *xml, nqm_index *names_ret, nqm_error *err);
/** The first child of this name, in constant time; NULL: none, or it is no element <kind> (NULL: any). */
const nqm_xml_element *nqm_xml_find(const nqm_index *names, const nqm_xml_element *parent, const char *kind,
                                    const char *name);

#endif
