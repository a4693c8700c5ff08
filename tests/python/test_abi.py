# SPDX-License-Identifier: MIT
"""The structs and enums of python/nqm/_abi.py are those of the public headers: a C program prints sizes, offsets and values. Its
functions have as many arguments as their declarations."""
import ctypes
import glob
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

from nqm import _abi, _library

SOURCE = os.environ["NQM_SOURCE"]
HEADERS = sorted(glob.glob(SOURCE + "/include/nqm/*.h"))


def c_text():
    text = ""
    for path in HEADERS:
        with open(path, encoding="utf-8") as file:
            text += file.read()
    return re.sub(r"/\*.*?\*/|//[^\n]*", " ", text, flags=re.S)


def functions():
    """Yield (name, result, arguments) of the public functions."""
    text = re.sub(r"\s+", " ", c_text())
    for found in re.finditer(r"NQM_API (?:NQM_MUST_CHECK )?([\w *]*?)\b(\w+)\(", text):
        depth, end = 1, found.end()
        while depth:
            depth += {"(": 1, ")": -1}.get(text[end], 0)
            end += 1
        yield found.group(2), found.group(1).strip(), re.sub(r"\([^()]*\)", "", text[found.end():end - 1]).strip()


# Calls functions with NULL and 0 for every argument but the last, the error.
CALL_WITH_NULL = """
import ctypes, sys
from nqm import _abi
from nqm._library import lib
for line in sys.argv[1:]:
    name, n = line.split(":")
    print(name, end=" ", flush=True)
    error = _abi.Error()
    arguments = [ctypes.c_void_p(0)] * (int(n) - 1)
    print(lib[name](*arguments, ctypes.byref(error)), lib[name](*arguments, None), error.message.decode(), flush=True)
"""


STRUCTS = {re.sub("(?=[A-Z])", "_", name).lower(): value for name, value in vars(_abi).items()
           if isinstance(value, type) and issubclass(value, ctypes.Structure) and value is not ctypes.Structure}
STRUCTS = {"nqm" + name: struct for name, struct in STRUCTS.items()}


def expected():
    """Lines that the C program must print, with the expressions that print them."""
    rows = []
    for name, struct in STRUCTS.items():
        rows.append(("sizeof(%s)" % name, ctypes.sizeof(struct)))
        for field, *_ in struct._fields_:
            rows.append(("offsetof(%s, %s)" % (name, field), getattr(struct, field).offset))
            rows.append(("sizeof(((%s *)0)->%s)" % (name, field), getattr(struct, field).size))
    rows += [("NQM_OK" if s == 0 else "NQM_ERR_" + s.name, s.value) for s in _abi.Status]
    for prefix, words in (("NQM_INVALID_", _abi.InvalidPolicy), ("NQM_SCORE_", _abi.ScoreQuantity), ("NQM_SCENE_", _abi.SceneKind),
                          ("NQM_SPLIT_", _abi.Split), ("NQM_FILE_", _abi.FileFormat)):
        rows += [(prefix + word.name, word.value) for word in words]
    return rows + [("NQM_METRIC_COUNT", len(_abi.Metric)), ("NQM_SCORE_BLOCK", _abi.SCORE_BLOCK)]


# Calls each function in a child with NULL and 0 for every argument and prints the signal that ended it, or 0. Results may be structs.
CALL_ALL_WITH_NULL = """
import ctypes, os, sys
from nqm._library import lib
class Result(ctypes.Structure):
    _fields_ = [("x", ctypes.c_char * 4096)]
for line in sys.argv[1:]:
    name, doubles, is_struct = line.split(":")
    child = os.fork()
    if not child:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
        function = lib[name]
        function.restype = Result if int(is_struct) else ctypes.c_void_p
        function.argtypes = None
        function(*[ctypes.c_double(0) if d == "1" else ctypes.c_void_p(0) for d in doubles])
        os._exit(0)
    print(name, os.waitpid(child, 0)[1] & 127, flush=True)
"""


class Abi(unittest.TestCase):
    def test_layout(self):
        cc = os.environ.get("CC", "cc")
        if not shutil.which(cc):
            self.skipTest("there is no C compiler")
        rows = expected()
        lines = ['printf("%%lld\\n", (long long)(%s));' % expression for expression, _ in rows]
        includes = ["#include <nqm/%s>" % os.path.basename(path) for path in HEADERS]
        program = "\n".join(includes + ["#include <stddef.h>", "#include <stdio.h>", "int main(void) {", *lines, "return 0;", "}"])
        with tempfile.TemporaryDirectory() as folder:
            with open(folder + "/abi.c", "w") as file:
                file.write(program)
            subprocess.run([cc, "-std=c11", "-I" + SOURCE + "/include", folder + "/abi.c", "-o", folder + "/abi"], check=True)
            environment = {k: v for k, v in os.environ.items() if k != "LD_PRELOAD"}
            printed = subprocess.run([folder + "/abi"], stdout=subprocess.PIPE, text=True, check=True, env=environment).stdout.split()
        found = [(expression, int(value)) for (expression, _), value in zip(rows, printed)]
        self.assertEqual(found, rows)

    def test_every_member_is_declared(self):
        found = dict(re.findall(r"typedef struct (\w+) \{(.*?)\} \1;", c_text(), re.S))
        self.assertEqual(set(found), set(STRUCTS))
        for struct, body in found.items():
            body = re.sub(r"\(\*(\w+)\)\([^)]*\)", r"\1", body)
            names = [re.search(r"(\w+)\s*(?:\[\w+\])*$", part.strip()).group(1)
                     for line in body.split(";") if line.strip() for part in line.split(",")]
            self.assertEqual(names, [f[0] for f in STRUCTS[struct]._fields_], struct)

    def test_functions(self):
        declared = {name: (result, arguments) for name, result, arguments in functions() if name.startswith("nqm_")}
        self.assertEqual(set(declared), set(_abi.FUNCTIONS))
        for name, (result, arguments) in _abi.FUNCTIONS.items():
            given = declared[name][1]
            self.assertEqual(0 if given == "void" else given.count(",") + 1, len(arguments), name)
            self.assertEqual(result is None, declared[name][0] == "void", name)

    def test_null(self):
        """Functions that return a status name an argument that is NULL; the others assert that it is not."""
        none_required = {"nqm_selftest", "nqm_files_within"}
        statuses = {name: arguments for name, result, arguments in functions() if result == "nqm_status"}
        self.assertGreater(len(statuses), 40)
        calls = ["%s:%d" % (name, arguments.count(",") + 1 - len(re.findall(r"double \w", arguments))) for name, arguments in statuses.items() if name not in none_required]
        run = subprocess.run([sys.executable, "-c", CALL_WITH_NULL, *calls], stdout=subprocess.PIPE, text=True)
        for line, (name, *_) in zip(run.stdout.splitlines(), (call.split(":") for call in calls)):
            found = re.fullmatch(name + r" -1 -1 %s: the argument (\w+) is NULL" % name, line)
            self.assertTrue(found, line)
            self.assertRegex(statuses[name], r"\b%s\b" % found.group(1), line)
        self.assertEqual(run.returncode, 0, "crashed at: " + run.stdout.splitlines()[-1])
        calls = []
        for name, result, arguments in functions():
            doubles = "".join(str(int(bool(re.match(r"\s*double \w+$", a)))) for a in arguments.split(",") if a != "void")
            is_struct = result.startswith("nqm_") and "*" not in result and result != "nqm_status"
            calls.append("%s:%s:%d" % (name, doubles, is_struct))
        run = subprocess.run([sys.executable, "-c", CALL_ALL_WITH_NULL, *calls], stdout=subprocess.PIPE, text=True, check=True)
        ended = dict(line.split() for line in run.stdout.splitlines())
        self.assertEqual(len(ended), len(calls))
        with open(SOURCE + "/include/nqm/base.h", encoding="utf-8") as file:
            listed = re.search(r"was built with NDEBUG. They are\s(.*?)\.\n", file.read(), re.S).group(1)
        stopped = {name: int(code) for name, code in ended.items() if code != "0"}
        self.assertEqual(stopped, {name: int(signal.SIGABRT) for name in re.findall(r"nqm_\w+", listed)})
        source = ""
        for path in glob.glob(SOURCE + "/src/**/*.c", recursive=True):
            with open(path, encoding="utf-8") as file:
                source += file.read()
        for name, result, arguments in functions():
            if "*" in arguments and result != "nqm_status" and not name.endswith(("_free", "_clear")) and name != "nqm_pairs_column":
                self.assertRegex(source, r"\b%s\([^;{]*\) \{\n    assert\(" % name)

    def test_version(self):
        text = c_text()
        digits = [re.search(r"NQM_VERSION_%s (\d+)" % part, text).group(1) for part in ("MAJOR", "MINOR", "PATCH")]
        self.assertEqual(".".join(digits), _library.VERSION)

    def test_missing_library(self):
        environment = dict(os.environ, NQM_LIBRARY="/nowhere")
        run = subprocess.run([sys.executable, "-c", "import nqm"], stderr=subprocess.PIPE, text=True, env=environment)
        self.assertIn("ImportError: the library that NQM_LIBRARY names cannot be loaded", run.stderr)


if __name__ == "__main__":
    unittest.main()
