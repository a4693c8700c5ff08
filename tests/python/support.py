# SPDX-License-Identifier: MIT
"""Shared by the tests of the Python package."""
import os
import subprocess


def run_tool(*arguments):
    """What the tool prints; with the kernels of the library, which does not read the environment."""
    return subprocess.run([os.environ["NQM_TOOL"], *arguments], stdout=subprocess.PIPE, check=True, env={**os.environ, "NQM_KERNELS": ""}).stdout
