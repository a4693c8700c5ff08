# SPDX-License-Identifier: MIT
"""Shared by the tests of the Python package."""
import os
import subprocess


def run_tool(*arguments):
    """What the tool prints."""
    return subprocess.run([os.environ["NQM_TOOL"], *arguments], stdout=subprocess.PIPE, check=True).stdout
