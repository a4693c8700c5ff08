#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The size of the API and its names: at most MAX_FUNCTIONS public functions, all of which libnqm-full.so exports; no public struct
with more than MAX_FIELDS fields; and over all headers of src/, tools/ and include/ no type or function declared twice, and functions
that begin with the same word after nqm_ in one room only, so that a search for the word leads to that room."""
import glob
import os
import re
import subprocess
import sys

MAX_FUNCTIONS = 95
MAX_FIELDS = 20
SOURCE, BUILD = os.environ["NQM_SOURCE"], os.environ["NQM_BUILD"]
faults = []
# Words that still begin functions of several rooms. Take a line out when its word has one room left; do not add lines.
SHARED = {
    "adam": "kernel net",
    "compare": "math metric",
    "delta": "metric percept",
    "directions": "brdf sample",
    "gradient": "kernel net",
    "half": "brdf kernel math",
    "human": "data judge",
    "interval": "model train",
    "light": "metric render",
    "map": "base figures render",
    "material": "brdf data material",
    "model": "model train",
    "nbrdf": "brdf encode",
    "novelty": "model train",
    "picture": "figures percept",
    "rays": "label render",
    "row": "kernel net",
    "sample": "metric sample",
    "scene": "label render",
    "spread": "model render",
    "srgb": "figures material",
    "transport": "label metric model",
}


def text_of(path):
    """A header without comments, string literals and preprocessor lines; extern "C" does not open a block."""
    with open(path) as file:
        text = file.read()
    text = re.sub(r"/\*.*?\*/|//[^\n]*", " ", text, flags=re.S)
    text = re.sub(r'#ifdef __cplusplus.*?#endif', " ", text, flags=re.S)
    text = re.sub(r"(?m)^[ \t]*#(?:[^\n]*\\\n)*[^\n]*$", " ", text)
    return re.sub(r'"(?:[^"\\]|\\.)*"', '""', text)


def statements(text):
    """Yield (head, body) of the text outside all braces; body is None for a statement without braces."""
    depth, head, body = 0, "", ""
    for c in text:
        if c == "{":
            depth += 1
        if depth:
            body += c
        else:
            head += c
        if c == "}":
            depth -= 1
        if depth == 0 and (c == ";" or (c == "}" and "(" in head and "=" not in head)):
            yield head.strip(), body or None
            head, body = "", ""


def fields(body):
    """Number of members of a struct; an inner struct or union counts as one."""
    inner = body[1:-1]
    while "{" in inner:
        inner = re.sub(r"\{[^{}]*\}", " ", inner)
    inner = re.sub(r"\([^()]*\)", " ", re.sub(r"\([^()]*\)", " ", inner))
    return sum(s.count(",") + 1 for s in inner.split(";") if s.strip())


declared = {}  # (kind, name) -> header
public = set()
largest = (0, "")
headers = sorted(glob.glob(SOURCE + "/include/**/*.h", recursive=True) + glob.glob(SOURCE + "/src/**/*.h", recursive=True) +
                 glob.glob(SOURCE + "/tools/**/*.h", recursive=True))
for path in headers:
    short = os.path.relpath(path, SOURCE)

    def declare(kind, name):
        if name.isupper():  # the NAME(...) of an included source, which a macro replaces
            return
        if (kind, name) in declared:
            faults.append("%s: %s %s is declared in %s, too" % (short, kind, name, declared[kind, name]))
        declared[kind, name] = short

    for head, body in statements(re.sub(r"__attribute__\s*\(\(.*?\)\)", " ", text_of(path))):
        tag = re.match(r"(?:typedef )?\s*(struct|union|enum) (\w+)", head)
        if body and tag:
            declare("definition of", tag.group(2))
        if body and tag and tag.group(1) == "struct" and short.startswith("include"):
            largest = max(largest, (fields(body), tag.group(2)))
            if fields(body) > MAX_FIELDS:
                faults.append("%s: struct %s has %d fields, more than %d" % (short, tag.group(2), fields(body), MAX_FIELDS))
        if head.startswith("typedef"):
            name = re.search(r"\(\s*\*\s*(\w+)\s*\)", head) or re.search(r"(\w+)\s*(?:\[[^]]*\]\s*)*;?$", head.rstrip("; ") + ";")
            name = name or re.search(r"(\w+)\s*\(", head)  # a function type
            declare("type", name.group(1))
        elif "(" in head and "=" not in head and not (body and tag):
            name = re.search(r"(\w+)\s*\(", head)
            declare("function", name.group(1))
            if "NQM_API" in head:
                public.add(name.group(1))

included = set(re.findall(r"<nqm/(\w+\.h)>", open(SOURCE + "/include/nqm/nqm.h").read()))
faults += ["nqm/nqm.h does not include nqm/" + name for name in set(os.listdir(SOURCE + "/include/nqm")) - included - {"nqm.h"}]
implements = dict(re.findall(r"^<(nqm/\w+\.h)>\s+(\w+)", open(SOURCE + "/src/LAYERS").read(), re.M))
rooms = {}  # first word -> rooms
for (kind, name), short in declared.items():
    if kind == "function" and name.startswith("nqm_"):
        folders = short.split("/")
        room = implements["nqm/" + folders[2]] if folders[0] == "include" else folders[1]
        rooms.setdefault(name.split("_")[1], set()).add(room)
for word, those in rooms.items():
    if those - set(SHARED.get(word, "").split()) and len(those) > 1:
        faults.append("functions nqm_%s_... are in the rooms %s: name those of all but one differently" % (word, ", ".join(sorted(those))))
for word, those in SHARED.items():
    if len(rooms.get(word, ())) < 2 or set(those.split()) - rooms[word]:
        faults.append("SHARED: %s is no longer shared by %s" % (word, those))

for kind, name in list(declared):
    if kind == "function" and ("type", name) in declared:
        faults.append("%s is a function (%s) and a type (%s)" % (name, declared[kind, name], declared["type", name]))
nm = subprocess.run(["nm", "--dynamic", "--defined-only", BUILD + "/libnqm-full.so"], stdout=subprocess.PIPE, text=True, check=True)
exported = {line.split()[2] for line in nm.stdout.splitlines() if len(line.split()) == 3}
if public != exported:
    faults.append("declared with NQM_API but not exported, or the reverse: %s" % sorted(public ^ exported))
if len(declared) < 500 or len(public) < 50:
    faults.append("only %d names were found: the test reads nothing" % len(declared))
if len(exported) > MAX_FUNCTIONS:
    faults.append("%d public functions, more than %d" % (len(exported), MAX_FUNCTIONS))
print("%d public functions; largest public struct: %s with %d fields; %d names in %d headers" %
      (len(exported), largest[1], largest[0], len(declared), len(headers)))
print("\n".join(faults))
sys.exit(1 if faults else 0)
