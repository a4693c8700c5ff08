/* SPDX-License-Identifier: MIT
 *
 * XML documents: the tree, and what is refused.
 */
#include "io/xml.h"
#include "support/check.h"

static nqm_status parse(const char *text, nqm_xml *xml, nqm_error *err) {
    return nqm_xml_parse(text, strlen(text), "test", xml, err);
}

TEST(the_tree) {
    nqm_xml xml;
    assert_int_equal(
        parse("<?xml version='1.0'?>\n<a x='1' y=\"&lt;2&#65;\"><b/>text<!-- no --><c><d/></c></a>", &xml, NULL),
        NQM_OK);
    const nqm_xml_element *a = xml.root, *b = a->first, *c = b->next;
    assert_string_equal(a->name, "a");
    assert_int_equal(a->byte_offset, 22);
    assert_int_equal(a->n_attributes, 2);
    assert_string_equal(nqm_xml_get(a, "x"), "1");
    assert_string_equal(nqm_xml_get(a, "y"), "<2A");
    assert_null(nqm_xml_get(a, "z"));
    assert_string_equal(b->name, "b");
    assert_null(b->first);
    assert_string_equal(c->first->name, "d");
    assert_ptr_equal(c->first->parent, c);
    assert_null(c->next);
    nqm_xml_free(&xml);
    assert_null(xml.root);
}

static void assert_refused(const char *text, nqm_status status, int64_t byte) {
    nqm_xml xml;
    nqm_error err = {0};
    assert_int_equal(parse(text, &xml, &err), status);
    assert_null(xml.root);
    assert_null(xml.blocks);
    assert_int_equal(err.byte_offset, byte);
    assert_non_null(strstr(err.message, "test: "));
}

TEST(what_is_refused) {
    assert_refused("", NQM_ERR_FORMAT, 0);
    assert_refused("<a>", NQM_ERR_FORMAT, 3);
    assert_refused("<a></b>", NQM_ERR_FORMAT, 5);
    assert_refused("<a x=1/>", NQM_ERR_FORMAT, 5);
    assert_refused("<a x='&e;'/>", NQM_ERR_FORMAT, 0);
    assert_refused("<!DOCTYPE a [<!ENTITY e 'eeee'>]><a x='&e;'/>", NQM_ERR_FORMAT, 12);
    assert_refused("<!DOCTYPE a SYSTEM 'file:///etc/hostname'><a/>", NQM_ERR_FORMAT, 41);
    char deep[4 * (NQM_XML_MAX_DEPTH + 1)] = "";
    for (int i = 0; i <= NQM_XML_MAX_DEPTH; ++i)
        strcat(deep, "<a>");
    assert_refused(deep, NQM_ERR_LIMIT, 3 * NQM_XML_MAX_DEPTH);
}
