# SPDX-License-Identifier: MIT
"""The tutorial notebook runs from its first to its last cell, prints what it stores, and stores its figures."""
import os
import subprocess
import sys

folder = os.path.join(os.environ["NQM_SOURCE"], "python")
sys.exit(subprocess.run([sys.executable, folder + "/notebook.py", folder + "/tutorial.ipynb"]).returncode)
