# SPDX-License-Identifier: MIT
"""The tutorial notebook runs from its first to its last cell, prints what it stores, and stores its figures."""
import os
import subprocess
import sys

if os.environ.get("NQM_SANITIZE"):
    print("skipped: the other tests of Python call the same functions")
    sys.exit(77)
folder = os.path.join(os.environ["NQM_SOURCE"], "python")
sys.exit(subprocess.run([sys.executable, folder + "/notebook.py", folder + "/tutorial.ipynb"]).returncode)
