# SPDX-License-Identifier: MIT
"""The wheel of ./dev wheel, which runs this: its tag is what the symbols need, it brings what not every Linux has, and the licences of that.
Skipped where none was built."""
import email.parser
import glob
import os
import re
import subprocess
import sys
import tempfile
import unittest
import zipfile

WHEELS = glob.glob(os.environ["NQM_SOURCE"] + "/build/wheel/*.whl")
if not WHEELS:
    print("skipped: build/wheel has no wheel (./dev wheel)")
    sys.exit(77)
# Every Linux with this glibc has these.
SYSTEM = {"libc.so.6", "libm.so.6", "libgcc_s.so.1", "libstdc++.so.6", "ld-linux-x86-64.so.2"}


def output(*command):
    return subprocess.run(command, stdout=subprocess.PIPE, check=True, text=True).stdout


class Wheel(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        with zipfile.ZipFile(WHEELS[0]) as archive:
            archive.extractall(cls.folder.name)
            cls.modes = {i.filename: i.external_attr >> 16 for i in archive.infolist()}
        cls.libraries = glob.glob(cls.folder.name + "/nqm/lib/*")
        cls.tool = cls.folder.name + "/nqm/bin/nqm"
        os.chmod(cls.tool, 0o755)  # as pip does by the modes

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def info(self, name):
        path, = glob.glob("%s/*.dist-info/%s" % (self.folder.name, name))
        return path

    def test_tag(self):
        symbols = output("objdump", "-T", self.tool, *self.libraries)
        glibc = max(tuple(map(int, v.split("."))) for v in re.findall(r"GLIBC_(\d+\.\d+)", symbols))
        tag = "py3-none-manylinux_%d_%d_%s" % (*glibc, os.uname().machine)
        self.assertTrue(WHEELS[0].endswith("-%s.whl" % tag), "%s needs %s" % (WHEELS[0], tag))
        with open(self.info("WHEEL"), encoding="utf-8") as file:
            fields = email.parser.Parser().parse(file)
        self.assertEqual((fields["Tag"], fields["Root-Is-Purelib"]), (tag, "false"))

    def test_libraries(self):
        """Each needs those of the system and of the wheel only, is found there, and has a name of its own."""
        own = set(map(os.path.basename, self.libraries))
        for path in [self.tool, *self.libraries]:
            dynamic = output("objdump", "-p", path)
            self.assertLessEqual(set(re.findall(r"NEEDED +(\S+)", dynamic)), SYSTEM | own, path)
            self.assertRegex(dynamic, r"RUNPATH +\$ORIGIN/\.\./lib\n")
            if path != self.tool:
                self.assertRegex(os.path.basename(path), "^libnqm-")
                self.assertIn("SONAME " + os.path.basename(path), re.sub(" +", " ", dynamic))
        for path in (self.tool, self.folder.name + "/nqm/lib/libnqm-full.so.0"):
            with open(path, "rb") as file:
                self.assertIn(b"\0libnqm-embree3.so.3\0", file.read(), "Embree is loaded by its name")

    def test_contents(self):
        self.assertLessEqual(os.path.getsize(WHEELS[0]), 25e6)
        programs = [mode for name, mode in self.modes.items() if name.endswith(("nqm/bin/nqm", "data/scripts/nqm"))]
        self.assertEqual([mode & 0o777 for mode in programs], [0o755, 0o755])
        bundled = {n for n in map(os.path.basename, self.libraries) if not re.match(r"libnqm-(full|models)\.", n)}
        self.assertEqual(sum(not name.startswith("common-") for name in os.listdir(self.info("licenses"))), len(bundled))
        for name in glob.glob(self.folder.name + "/nqm/**", recursive=True):
            self.assertNotIn("__pycache__", name)

    def test_tool(self):
        models = output(self.tool, "info", "--models")
        self.assertIn("default", models)
        self.assertNotIn("transport-paper", models)


if __name__ == "__main__":
    unittest.main()
