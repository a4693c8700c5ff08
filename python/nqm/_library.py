# SPDX-License-Identifier: MIT
"""The C library: where it is found, and its functions with the types of include/nqm/*.h."""
from __future__ import annotations

import ctypes
import ctypes.util
import os
import shutil
import sys
from ctypes import c_char_p
from pathlib import Path
from typing import Iterator

from ._abi import FUNCTIONS
from ._version import VERSION

NAMES = ("libnqm-full.so.0", "libnqm-full.so")


def _candidates() -> Iterator[str]:
    """Paths and names of the library, best first."""
    package = Path(__file__).resolve().parent
    folders = [package / "lib", package, package.parent, package.parent.parent / "build"]
    folders += [p / lib for p in package.parents for lib in ("lib", "lib64") if "lib" in package.parts]
    folders.append(Path(sys.prefix) / "lib")
    tool = shutil.which("nqm")
    if tool:
        folders += [Path(tool).resolve().parent, Path(tool).resolve().parent.parent / "lib"]
    for folder in folders:
        for name in NAMES:
            for path in [folder / name, *sorted(folder.glob("*-linux-gnu*/" + name))]:
                if path.is_file():
                    yield str(path)
    yield NAMES[0]  # the loader's own search: LD_LIBRARY_PATH, ld.so.conf
    found = ctypes.util.find_library("nqm-full")
    if found:
        yield found
    for path in (Path.home() / ".local/lib", Path("/usr/local/lib")):
        if (path / NAMES[0]).is_file():
            yield str(path / NAMES[0])


def _declare(library: ctypes.CDLL, path: str) -> ctypes.CDLL:
    try:
        library.nqm_version.restype = c_char_p
        running = library.nqm_version().decode()
        if running.split(".")[:2] != VERSION.split(".")[:2]:
            raise ImportError("%s is version %s of nqm, but this Python package needs %s: install both from the same release" %
                              (path, running, VERSION))
        for name, (result, arguments) in FUNCTIONS.items():
            function = getattr(library, name)
            function.restype, function.argtypes = result, arguments
    except AttributeError as error:
        raise ImportError("%s is not libnqm-full of version %s: %s" % (path, VERSION, error)) from None
    return library


def _load() -> ctypes.CDLL:
    given = os.environ.get("NQM_LIBRARY")
    if given:
        path = Path(given)
        if path.is_dir():
            path = next((path / name for name in NAMES if (path / name).is_file()), path / NAMES[0])
        try:
            return _declare(ctypes.CDLL(str(path)), str(path))
        except OSError as error:
            raise ImportError("the library that NQM_LIBRARY names cannot be loaded: %s" % error) from None
    reasons = []
    for candidate in _candidates():
        try:
            return _declare(ctypes.CDLL(candidate), candidate)
        except OSError as error:
            reasons.append(str(error))
    raise ImportError(
        "the C library libnqm-full is not found (%s). Install it (Debian: apt install ./libnqm0_*.deb; source: cmake "
        "--install build), or set the environment variable NQM_LIBRARY to the file libnqm-full.so or its folder" %
        "; ".join(dict.fromkeys(reasons)))


lib = _load()
