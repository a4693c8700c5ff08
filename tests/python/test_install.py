# SPDX-License-Identifier: MIT
"""The package finds the library where an installation has it; pip installs it without a network; it has its types."""
import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

SOURCE, LIBRARY = os.environ["NQM_SOURCE"], os.environ["NQM_LIBRARY"]
CODE = "import nqm; print(nqm._library.lib._name, nqm.__version__)"


class Install(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)
        self.environment = {k: v for k, v in os.environ.items() if k not in ("NQM_LIBRARY", "PYTHONPATH")}

    def run_python(self, *arguments, **variables):
        return subprocess.run([sys.executable, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                              env=dict(self.environment, **variables), cwd=self.folder)

    def test_prefix(self):
        for package, library in (("lib/python3/dist-packages", "lib"), ("lib/python3/dist-packages", "lib/x86_64-linux-gnu"),
                                 ("local/lib/python3.11/site-packages", "lib"), ("venv/site-packages", "venv/site-packages/nqm/lib")):
            prefix = tempfile.mkdtemp(dir=self.folder)
            shutil.copytree(SOURCE + "/python/nqm", "%s/%s/nqm" % (prefix, package))
            os.makedirs("%s/%s" % (prefix, library), exist_ok=True)
            path = "%s/%s/libnqm-full.so.0" % (prefix, library)
            os.symlink(LIBRARY, path)
            run = self.run_python("-c", CODE, PYTHONPATH="%s/%s" % (prefix, package))
            self.assertEqual((run.stderr, run.stdout.split()[:1]), ("", [path]))

    def test_source_tree(self):
        shutil.copytree(SOURCE + "/python", self.folder + "/python")
        os.mkdir(self.folder + "/build")
        os.symlink(LIBRARY, self.folder + "/build/libnqm-full.so")
        run = self.run_python("-c", CODE, PYTHONPATH=self.folder + "/python")
        self.assertEqual(run.stdout.split()[:1], [self.folder + "/build/libnqm-full.so"])

    def test_not_found(self):
        shutil.copytree(SOURCE + "/python/nqm", self.folder + "/nqm")
        run = self.run_python("-c", CODE, PYTHONPATH=self.folder, PATH="/nowhere", HOME="/nowhere", LD_LIBRARY_PATH="")
        if run.returncode == 0:
            self.skipTest("nqm is installed on this system")
        self.assertRegex(run.stderr, "ImportError: the C library libnqm-full is not found .*set the environment variable NQM_LIBRARY")

    @unittest.skipUnless(importlib.util.find_spec("pip") and importlib.util.find_spec("setuptools"), "there is no pip or setuptools")
    def test_pip(self):
        shutil.copytree(SOURCE + "/python", self.folder + "/python", ignore=shutil.ignore_patterns("build", "*.egg-info"))
        run = self.run_python("-m", "pip", "install", "-q", "--no-deps", "--no-index", "--no-build-isolation", "--no-compile",
                              "--target", self.folder + "/site", self.folder + "/python")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertTrue(os.path.exists(self.folder + "/site/nqm/py.typed"))
        run = self.run_python("-c", CODE, PYTHONPATH=self.folder + "/site", NQM_LIBRARY=LIBRARY)
        self.assertEqual(run.stdout.split()[:1], [LIBRARY], run.stderr)


if __name__ == "__main__":
    unittest.main()
