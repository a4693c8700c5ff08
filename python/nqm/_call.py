# SPDX-License-Identifier: MIT
"""Calls of the C library: its errors as exceptions, exceptions of Python callbacks, progress, arrays."""
from __future__ import annotations

import contextlib
import ctypes
import os
import sys
import threading
import weakref
from ctypes import POINTER
from typing import Any, Callable, Optional, Sequence, Union

import numpy as np

from ._abi import CError, Progress, Status, lib

PathLike = Union[str, "os.PathLike[str]"]
#: Progress of a long call: called with the stage ("fit"), the work done, and the total work (0: unknown). Raise an exception
#: to stop the call. `True` shows a line on standard error.
ProgressLike = Union[None, bool, Callable[[str, float, float], Any]]

_CODES = {Status.OK: 0, Status.ARG: 2, Status.IO: 3, Status.FORMAT: 4, Status.INCOMPATIBLE: 5, Status.MODEL: 6,
          Status.NOMEM: 7, Status.LIMIT: 7, Status.NUMERIC: 8, Status.CANCELLED: 130}


class Error(Exception):
    """A call of the library failed. The text is that of the command-line tool: it names the file and the byte, if there are any.

    Attributes:
        status: what went wrong, a `Status`
        byte: position of the fault in its file, bytes from the start; None if there is none
        code: the exit code of the command-line tool for this error (2 argument, 3 file, 4 format, 5 incompatible, 6 model,
            7 memory or limit, 8 computation, 130 stopped)
    """

    __module__ = "nqm"  # as tracebacks show it

    def __init__(self, message: str, status: Status = Status.ARG, byte: Optional[int] = None) -> None:
        super().__init__(message)
        self.status = status
        self.byte = byte
        self.code = _CODES[status]

    def __reduce__(self) -> Any:
        return Error, (str(self), self.status, self.byte)


def status_text(status: int) -> str:
    return lib.nqm_status_text(status).decode()


def error_of(err: CError, status: int) -> Error:
    message = err.message.decode("utf-8", "replace") or status_text(status)
    return Error(message, Status(status), err.byte_offset if err.byte_offset >= 0 else None)


class Watch:
    """Keeps the first exception of callbacks until the call of the library has returned. A BRDF of Python code has one; a call
    with progress makes one."""

    def __init__(self) -> None:
        self.lock = threading.RLock()
        self.error: Optional[BaseException] = None
        self.shown = False  # an unfinished line of show_progress()

    def take(self) -> Optional[BaseException]:
        error, self.error = self.error, None
        return error


def show_progress(stage: str, done: float, total: float) -> None:
    """Show progress as one line on standard error."""
    text = "%s %3.0f %%" % (stage, 100 * done / total) if total > 0 else stage
    sys.stderr.write("\r%-40s" % text)
    sys.stderr.flush()


def progress_of(progress: ProgressLike) -> Callable[[str, float, float], Any]:
    if progress is True:
        return show_progress
    return progress if callable(progress) else lambda stage, done, total: None


def progress_callback(progress: ProgressLike, watches: "Sequence[Watch]", own: Watch) -> Any:
    """A C callback, which also lets Ctrl-C through: without one, Python would see it only after the call."""
    function = progress_of(progress)

    def callback(user: Any, stage: bytes, done: float, total: float) -> int:
        if own.error is None:
            own.shown = progress is True
            try:
                function(stage.decode(), done, total)
            except BaseException as error:  # KeyboardInterrupt among them
                own.error = error
        return int(any(w.error is not None for w in (own, *watches)))

    return Progress(callback)


def call(function: Any, *args: Any, watches: Sequence[Watch] = (), own: Optional[Watch] = None) -> Any:
    """Call a function of the library and raise what went wrong: an exception of a callback first, then its own error. Threads that
    use the same Python callback take turns."""
    err = CError()
    fallible = bool(function.argtypes) and function.argtypes[-1] is POINTER(CError)
    with contextlib.ExitStack() as stack:
        for watch in sorted(set(watches), key=id):
            stack.enter_context(watch.lock)
        result = function(*args, ctypes.byref(err)) if fallible else function(*args)
        used = ([own] if own else []) + list(watches)
        errors = [w.take() for w in used]
        if any(w.shown for w in used):
            sys.stderr.write("\n")
            for w in used:
                w.shown = False
    for error in errors:
        if error is not None:
            raise error
    if fallible and result != 0:
        raise error_of(err, result)
    return result


def own_handle(owner: Any, handle: ctypes.c_void_p, free: Any) -> Any:
    """Free `handle` together with its Python object; at exit the system does it."""
    finalizer = weakref.finalize(owner, free, handle)
    finalizer.atexit = False
    return finalizer


def encode(text: PathLike) -> bytes:
    """A path or spec for the library. A NUL would cut it off silently."""
    data = os.fsencode(text)
    if b"\0" in data:
        raise ValueError("a path or spec contains a NUL character")
    return data


def decode(text: Optional[bytes]) -> Optional[str]:
    return None if text is None else os.fsdecode(text)


def address(array: np.ndarray) -> int:
    return array.ctypes.data


def choice(name: str, value: str, names: Sequence[str]) -> int:
    if value not in names:
        raise ValueError("%s is one of %s; not %r" % (name, ", ".join(names), value))
    return names.index(value)


def triples(name: str, value: Any, dtype: Any = np.float64) -> np.ndarray:
    """An array (..., 3), contiguous."""
    array = np.ascontiguousarray(value, dtype=dtype)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ValueError("%s has the shape (..., 3); not %s" % (name, array.shape))
    return array
