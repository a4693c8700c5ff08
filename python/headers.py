#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Print python/nqm/_abi.py: the enums, structs and functions of the public headers for ctypes. ./dev pages writes it, and
tests/structure/reference.sh checks that it is up to date. It reads C as the headers of include/nqm write it, which clang-format keeps
regular; a declaration that it does not understand is an error."""
import os
import re

HEADERS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "include", "nqm")
NUMBERS = {"int": "c_int", "char": "c_char", "double": "c_double", "float": "c_float", "size_t": "c_size_t", "int64_t": "c_int64",
           "uint64_t": "c_uint64", "uint8_t": "c_uint8"}
COMMA = r",(?![^()]*\))"  # not inside of brackets
constants = {}  # name: value
values = {"void": "None", **NUMBERS}  # C type: ctypes expression; structs, enums and types of functions follow
structs = set()

HEAD = '''# SPDX-License-Identifier: MIT
"""Made by python/headers.py from include/nqm/*.h (./dev pages): change those. A pointer to a struct has its type; pointers to objects and
arrays are addresses, which callbacks get as pointers."""
import enum
from ctypes import (CFUNCTYPE, POINTER, Structure, c_char, c_char_p, c_double, c_float, c_int, c_int64, c_size_t, c_uint8, c_uint64,
                    c_void_p)'''


def header(name, seen):
    """Text of a header after those that it includes, without comments and lines of the preprocessor."""
    if name in seen:
        return ""
    seen.add(name)
    with open(os.path.join(HEADERS, name), encoding="utf-8") as file:
        text = file.read()
    included = "".join(header(other, seen) for other in re.findall(r"#include <nqm/(\w+\.h)>", text))
    text = re.sub(r"/\*.*?\*/", " ", text, flags=re.S)
    text = re.sub(r"#ifdef __cplusplus.*?#endif", " ", text, flags=re.S)
    text = re.sub(r"(?m)^#.*$", " ", text)
    return included + re.sub(r"\s+", " ", text)


def class_name(c_name):
    return "".join(word.capitalize() for word in re.sub("^nqm_|_fn$", "", c_name).split("_"))


def type_of(base, stars, of_callback=False):
    """The ctypes expression of a C type; `stars`: its pointers."""
    base = re.sub(r"\b(?:const|struct)\b", "", base).strip()
    if not stars:
        return values[base]
    if len(stars) > 1 or base not in values or base == "void":
        return "c_void_p"
    if base == "char":
        return "c_char_p"
    return "POINTER(%s)" % values[base] if of_callback or base in structs else "c_void_p"


def declared(text, of_callback=False):
    """(name, ctypes expression) of a declarator such as "const double *x" or "char text[2][NQM_REMARK_TEXT]"."""
    function = re.fullmatch(r"(.+?)\(\*(\w+)\)\((.*)\)", text)
    if function:
        return function.group(2), callback(function.group(1).strip(), function.group(3))
    found = re.fullmatch(r"([\w ]+?) ?((?:\* ?(?:const )?)*)(\w+)((?: ?\[\w+\])*)", text)
    if not found:
        raise SystemExit("python/headers.py does not understand: " + text)
    expression = type_of(found.group(1), re.findall(r"\*", found.group(2)), of_callback)
    for size in reversed(re.findall(r"\w+", found.group(4))):
        expression = "%s * %d" % ("(%s)" % expression if " " in expression else expression, eval(size, dict(constants)))
    return found.group(3), expression


def arguments(text, of_callback=False):
    found = [] if text == "void" else [declared(a.strip(), of_callback)[1] for a in re.split(COMMA, text)]
    return ["c_char_p" if a.startswith("c_char *") else a for a in found]


def callback(result, text):
    return "CFUNCTYPE(%s)" % ", ".join([type_of(result, ""), *arguments(text, of_callback=True)])


def enumeration(name, body):
    """Yield the lines of an enum, without what counts its values; nameless ones become constants."""
    members, value = {}, -1
    for part in body.split(","):
        member, _, expression = (p.strip() for p in part.partition("="))
        if member:
            value = eval(expression, dict(constants)) if expression else value + 1
            members[member] = constants[member] = value
    prefix = os.path.commonprefix(list(members)).rpartition("_")[0] if name else "NQM"
    short = {re.sub("^ERR_", "", m[len(prefix) + 1:]): v for m, v in members.items()}
    if name:
        values[name] = "c_int"
        yield "\n\nclass %s(enum.IntEnum):\n    \"\"\"`%s`\"\"\"\n" % (class_name(name), name)
    else:
        yield "\n"
    for member, value in short.items():
        if not (name and member == "COUNT"):
            yield "%s%s = %d" % ("    " if name else "", member, value)


def structure(name, body):
    """Yield the lines of a struct."""
    yield "\n\nclass %s(Structure):\n    _fields_ = [" % class_name(name)
    for statement in filter(None, (s.strip() for s in body.split(";"))):
        first, *more = re.split(COMMA, statement)
        base = re.match(r"[\w ]+ ", first).group() if more else ""
        for text in (first, *(base + m.strip() for m in more)):
            yield "        (\"%s\", %s)," % declared(text.strip())
    yield "    ]"
    structs.add(name)
    values[name] = class_name(name)


def main():
    seen = set()
    text = "".join(header(name, seen) for name in sorted(os.listdir(HEADERS)))
    print(HEAD)
    functions = []
    item = (r"typedef struct (?P<opaque>\w+) (?P=opaque);|(?:typedef )?enum (?P<enum>\w*) ?\{(?P<values>.*?)\} ?\w*;|"
            r"typedef struct (?P<struct>\w+) \{(?P<members>.*?)\} (?P=struct);|typedef (?P<result>\w+) \(\*(?P<callback>\w+)\)\((?P<gets>.*?)\);|"
            r"NQM_API (?:NQM_MUST_CHECK )?(?P<declaration>.*?)\((?P<arguments>.*?)\);|static inline .*?\}")
    position = 0
    for found in re.finditer(item, text):
        if text[position:found.start()].strip():
            raise SystemExit("python/headers.py does not understand: " + text[position:found.start()])
        position = found.end()
        group = found.groupdict()
        if group["values"]:
            print("\n".join(enumeration(group["enum"], group["values"])))
        elif group["struct"]:
            print("\n".join(structure(group["struct"], group["members"])))
        elif group["callback"]:
            values[group["callback"]] = class_name(group["callback"])
            print("\n\n%s = %s" % (class_name(group["callback"]), callback(group["result"], group["gets"])))
        elif group["declaration"]:
            name, result = declared(group["declaration"])
            functions.append("    \"%s\": (%s, [%s])," % (name, result, ", ".join(arguments(group["arguments"]))))
    print("\n\n#: name: (result, arguments)\nFUNCTIONS = {\n%s\n}" % "\n".join(functions))


main()
