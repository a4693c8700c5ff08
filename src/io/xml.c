/* SPDX-License-Identifier: MIT
 *
 * XML documents as trees of elements, by expat.
 */
#include "io/xml.h"

#include <expat.h>

typedef struct reader {
    XML_Parser parser;
    nqm_xml *xml;
    nqm_xml_element *open; /* the innermost element that is not closed yet */
    size_t depth, max_elements;
    const char *path;
    nqm_status status;
    nqm_error *err;
} reader;

static void give_up(reader *self, nqm_status status) {
    self->status = status;
    XML_StopParser(self->parser, XML_FALSE);
}

static int64_t byte_of(const reader *self) {
    const int64_t byte = (int64_t)XML_GetCurrentByteIndex(self->parser);
    return byte > 0 ? byte : 0; /* -1 before the first event */
}

/* Memory for many elements: blocks of their own would take three times as much. */
typedef struct nqm_xml_block {
    struct nqm_xml_block *next;
    size_t n, n_used; /* bytes after this struct */
} block;

/* n bytes, zeroed; NULL: out of memory. */
static void *take(nqm_xml *xml, size_t n) {
    enum { BLOCK_BYTES = 1 << 16, ALIGNMENT = sizeof(void *) };
    n = nqm_ceil_div(n, ALIGNMENT) * ALIGNMENT;
    if (!xml->blocks || n > xml->blocks->n - xml->blocks->n_used) {
        const size_t n_block = nqm_larger(n, BLOCK_BYTES - sizeof(block));
        block *fresh = nqm_alloc(1, sizeof *fresh + n_block);
        if (!fresh)
            return NULL;
        *fresh = (block){.next = xml->blocks, .n = n_block};
        xml->blocks = fresh;
    }
    void *at = (char *)(xml->blocks + 1) + xml->blocks->n_used;
    xml->blocks->n_used += n;
    return at;
}

/* Allocate an element, its attributes and all their texts as one block. */
static nqm_xml_element *make_element(nqm_xml *xml, const char *name, const char *const *attributes) {
    size_t n = 0, n_text = strlen(name) + 1;
    for (; attributes[2 * n]; ++n)
        n_text += strlen(attributes[2 * n]) + strlen(attributes[2 * n + 1]) + 2;
    nqm_xml_element *element = take(xml, sizeof *element + n * sizeof(nqm_xml_attribute) + n_text);
    if (!element)
        return NULL;
    nqm_xml_attribute *list = (nqm_xml_attribute *)(element + 1);
    char *text = (char *)(list + n);
    element->name = strcpy(text, name);
    element->n_attributes = n;
    element->attributes = list;
    for (size_t i = 0; i < n; ++i) {
        text += strlen(text) + 1;
        list[i].name = strcpy(text, attributes[2 * i]);
        text += strlen(text) + 1;
        list[i].value = strcpy(text, attributes[2 * i + 1]);
    }
    return element;
}

nqm_xml_element *nqm_xml_append(nqm_xml *xml, nqm_xml_element *parent, const char *name, const char *const *attributes,
                                int64_t byte_offset) {
    nqm_xml_element *element = make_element(xml, name, attributes);
    if (!element)
        return NULL;
    ++xml->n_elements;
    element->byte_offset = byte_offset;
    element->parent = parent;
    if (!parent)
        xml->root = element;
    else if (parent->last)
        parent->last->next = element;
    else
        parent->first = element;
    if (parent)
        parent->last = element;
    return element;
}

static void on_start(void *user, const char *name, const char **attributes) {
    reader *self = user;
    if (self->status != NQM_OK)
        return;
    const int64_t byte = byte_of(self);
    if (++self->depth > NQM_XML_MAX_DEPTH)
        give_up(self, nqm_fail(self->err, NQM_ERR_LIMIT, byte, "%s: elements are nested more than %d deep at byte %lld",
                               self->path, NQM_XML_MAX_DEPTH, (long long)byte));
    else if (self->xml->n_elements == self->max_elements)
        give_up(self, nqm_fail(self->err, NQM_ERR_LIMIT, byte,
                               "%s: more than %zu elements at byte %lld, the limit for a file of this size", self->path,
                               self->max_elements, (long long)byte));
    else if (!(self->open = nqm_xml_append(self->xml, self->open, name, (const char *const *)attributes, byte)))
        give_up(self, nqm_fail_nomem(self->err, sizeof *self->open));
}

static void on_end(void *user, const char *name) {
    reader *self = user;
    (void)name;
    if (self->status != NQM_OK)
        return;
    self->open = self->open->parent;
    --self->depth;
}

static void on_doctype(void *user, const char *name, const char *sysid, const char *pubid, int has_internal_subset) {
    reader *self = user;
    (void)name, (void)sysid, (void)pubid, (void)has_internal_subset;
    if (self->status == NQM_OK)
        give_up(self, nqm_fail(self->err, NQM_ERR_FORMAT, byte_of(self),
                               "%s: document type declarations (byte %lld) are not read; remove it", self->path,
                               (long long)byte_of(self)));
}

static nqm_status parse(reader *self, const char *data, size_t n_bytes) {
    enum { CHUNK = 1 << 20 };
    for (size_t at = 0;;) {
        const size_t n = nqm_smaller(CHUNK, n_bytes - at);
        const enum XML_Status done = XML_Parse(self->parser, data + at, (int)n, at + n == n_bytes);
        if (self->status != NQM_OK)
            return self->status;
        if (done != XML_STATUS_OK && XML_GetErrorCode(self->parser) == XML_ERROR_NO_MEMORY)
            return nqm_fail_nomem(self->err, n_bytes);
        if (done != XML_STATUS_OK)
            return nqm_fail(self->err, NQM_ERR_FORMAT, byte_of(self), "%s: not well-formed XML at byte %lld: %s",
                            self->path, (long long)byte_of(self), XML_ErrorString(XML_GetErrorCode(self->parser)));
        at += n;
        if (at == n_bytes)
            return NQM_OK;
    }
}

nqm_status nqm_xml_parse(const void *data, size_t n_bytes, const char *path, nqm_xml *xml_ret, nqm_error *err) {
    *xml_ret = (nqm_xml){0};
    if (n_bytes > NQM_XML_MAX_BYTES)
        return nqm_fail(err, NQM_ERR_LIMIT, 0, "%s: %zu bytes of XML (byte 0); at most %d are read", path, n_bytes,
                        NQM_XML_MAX_BYTES);
    reader self = {.parser = XML_ParserCreate(NULL), .xml = xml_ret, .path = path, .status = NQM_OK, .err = err};
    self.max_elements = NQM_XML_FREE_ELEMENTS + n_bytes / NQM_XML_BYTES_PER_ELEMENT;
    if (!self.parser)
        return nqm_fail_nomem(err, n_bytes);
    XML_SetUserData(self.parser, &self);
    XML_SetElementHandler(self.parser, on_start, on_end);
    XML_SetStartDoctypeDeclHandler(self.parser, on_doctype);
    XML_SetParamEntityParsing(self.parser, XML_PARAM_ENTITY_PARSING_NEVER);
    nqm_status status = parse(&self, data, n_bytes);
    XML_ParserFree(self.parser);
    if (status != NQM_OK)
        nqm_xml_free(xml_ret);
    return status;
}

void nqm_xml_free(nqm_xml *xml) {
    while (xml->blocks) {
        block *next = xml->blocks->next;
        nqm_free(xml->blocks);
        xml->blocks = next;
    }
    xml->root = NULL;
}

const char *nqm_xml_get(const nqm_xml_element *element, const char *attribute) {
    for (size_t i = 0; i < element->n_attributes; ++i)
        if (strcmp(element->attributes[i].name, attribute) == 0)
            return element->attributes[i].value;
    return NULL;
}

static nqm_index_key key_of(const void *value) {
    const nqm_xml_element *e = value;
    return (nqm_index_key){e->parent, nqm_xml_get(e, "name")};
}

/* At most NQM_XML_MAX_DEPTH calls deep. */
static void add_children(const nqm_xml_element *element, nqm_index *names) {
    for (const nqm_xml_element *child = element->first; child; child = child->next) {
        if (nqm_xml_get(child, "name"))
            nqm_index_add(names, child);
        add_children(child, names);
    }
}

nqm_status nqm_xml_names_create(size_t max_n, const nqm_xml *xml, nqm_index *names_ret, nqm_error *err) {
    nqm_status status = nqm_index_create(max_n, key_of, names_ret, err);
    if (status == NQM_OK && xml)
        add_children(xml->root, names_ret);
    return status;
}

const nqm_xml_element *nqm_xml_find(const nqm_index *names, const nqm_xml_element *parent, const char *kind,
                                    const char *name) {
    const nqm_xml_element *found = nqm_index_find(names, (nqm_index_key){parent, name});
    return found && kind && strcmp(found->name, kind) != 0 ? NULL : found;
}
