# SPDX-License-Identifier: MIT
"""The examples in doc/python.md and in the docstrings print what they show; doc/reference-python.md and the stored figures of the notebook
are up to date."""
import doctest
import os
import re
import subprocess
import sys
import tempfile
import unittest

import numpy as np

import nqm

SOURCE = os.environ["NQM_SOURCE"]
NUMBER = re.compile(r"-?\d+\.\d+")


class Close(doctest.OutputChecker):
    """Decimal numbers may differ by 2 % and two units in the last place."""

    def check_output(self, want, got, optionflags):
        if super().check_output(want, got, optionflags):
            return True
        shown, printed = NUMBER.findall(want), NUMBER.findall(got)
        if len(shown) != len(printed) or not super().check_output(NUMBER.sub("0", want), NUMBER.sub("0", got), optionflags):
            return False
        return all(abs(float(a) - float(b)) <= .02 * abs(float(a)) + 2.01 * 10.0 ** -len(a.partition(".")[2])
                   for a, b in zip(shown, printed))


class Pages(unittest.TestCase):
    maxDiff = None

    def run_examples(self, text, name, names):
        examples = doctest.DocTestParser().get_doctest(text, names, name, name, 0)
        self.assertTrue(examples.examples)
        output = []
        doctest.DocTestRunner(Close(), verbose=False, optionflags=doctest.ELLIPSIS).run(examples, out=output.append)
        self.assertEqual("".join(output), "")

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(folder.name)

    def test_page(self):
        with open(SOURCE + "/doc/python.md", encoding="utf-8") as file:
            text = re.sub(r"(?m)^```.*$", "", file.read())
        self.run_examples(text, "python.md", {})

    def test_docstrings(self):
        for thing in (nqm, *vars(nqm).values()):
            if thing is nqm or ">>>" in (getattr(thing, "__module__", "").startswith("nqm.") and thing.__doc__ or ""):
                self.run_examples(thing.__doc__, thing.__name__, {"nqm": nqm, "np": np})

    def test_reference(self):
        made = subprocess.run([sys.executable, SOURCE + "/doc/reference_python.py"], stdout=subprocess.PIPE, check=True).stdout.decode()
        with open(SOURCE + "/doc/reference-python.md", encoding="utf-8") as file:
            self.assertEqual(made, file.read(), "doc/reference-python.md is old: run ./dev pages")

    def test_every_public_name_is_documented(self):
        for name in nqm.__all__:
            self.assertTrue(getattr(nqm, name).__doc__, name)


if __name__ == "__main__":
    unittest.main()
