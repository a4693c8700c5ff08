#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Print doc/reference-c.md: the public functions of each header with the first sentence of their documentation. The headers are the
manual; this page is an index to them. ./dev pages writes it, and tests/structure/reference.sh checks that it is up to date."""
import glob
import os
import re

HEADERS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "include", "nqm")
ORDER = re.findall(r"<nqm/(\w+)\.h>", open(os.path.join(HEADERS, "nqm.h")).read())


def first_sentence(comment):
    """The first sentence, or the part before a list of parameters."""
    comment = re.split(r"\n \*\s*\n", comment.strip(" *\n"))[0]  # its first paragraph
    text = re.sub(r"\s*\n\s*\*?\s*", " ", comment.strip().lstrip("*")).strip()
    text = text.partition(" @")[0]
    text = re.split(r"(?<=[A-Za-z0-9)\"])[.:;] (?=[A-Z])", text + " ")[0]
    text = re.sub(r" \([^)]*[\";/][^)]*\)", "", text)  # the headers say more
    return re.split(r"[;:] |, for example |, which |, because ", text)[0].strip().rstrip(".;:")


def functions(text):
    """Yield (name, summary); functions that follow each other share the comment before the first."""
    summary = ""
    for comment, code in re.findall(r"/\*\*(?!<)(.*?)\*/([^/]*(?:/(?!\*\*[^<])[^/]*)*)", text, flags=re.S):
        summary = first_sentence(comment) + (" (**experimental**)" if "NQM_EXPERIMENTAL" in comment else "")
        for name in re.findall(r"NQM_API[^;]*?\b(nqm_\w+)\(", code):
            if not name.endswith("_free"):
                yield name, summary


print("""# Reference of the C library

Which functions are there? This page is an index made from the headers (`./dev pages`), which are the manual: shapes, units, ranges, errors,
ownership and threads are described there. What is opened, loaded or created is freed by the function `_free` of its type, which the lists leave out.
What is marked as **experimental** may change in any release. `<nqm/nqm.h>` includes all headers; [base.h](../include/nqm/base.h) has the conventions, and
[examples/](../examples) has complete programs.""")
PLAIN = re.compile(r"_(?:default|get_\w+|count|name|text|version|id|degrees|wi|wo|weights|size)$")  # their names say what they return
CORE = ("base", "material", "brdf", "samples", "percept", "model", "metric", "texture")
names = [n for n in ORDER if os.path.exists(os.path.join(HEADERS, n + ".h"))]
names += sorted({os.path.basename(p)[:-2] for p in glob.glob(HEADERS + "/*.h")} - set(names) - {"nqm"})
for name in sorted(set(names), key=names.index):
    with open(os.path.join(HEADERS, name + ".h")) as file:
        text = file.read()
    title = re.search(r"nqm/%s\.h - (.*?)(?:\n \*\n| \*/)" % name, text, flags=re.S).group(1)
    title = re.sub(r"\s*\n \*\s*", " ", title).strip()
    title = title.replace("NQM_EXPERIMENTAL", "**Experimental**")
    if name not in CORE and "libnqm-full" not in title:
        title += " In libnqm-full only."
    print("\n## %s.h\n\n[nqm/%s.h](../include/nqm/%s.h): %s\n" %
          (name, name, name, title))
    plain = []
    for function, summary in functions(text):
        if PLAIN.search(function):
            plain.append("`%s()`" % function)
        else:
            print("- `%s()`: %s" % (function, summary.replace("<", "&lt;")))
    if plain:
        print("- %s" % ", ".join(plain))
