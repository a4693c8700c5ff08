# SPDX-License-Identifier: MIT
"""Calls of the C library: its errors as exceptions, exceptions of Python callbacks, progress, arrays."""
from __future__ import annotations

import contextlib
import ctypes
import enum
import itertools
import os
import signal
import sys
import threading
import weakref
from ctypes import POINTER
from typing import Any, Callable, Iterator, Optional, Sequence, Tuple, Type, Union

import numpy as np

from . import _abi
from ._abi import Progress, Status
from ._library import lib

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


def error_of(err: _abi.Error, status: int) -> Error:
    message = err.message.decode("utf-8", "replace") or status_text(status)
    return Error(message, Status(status), err.byte_offset if err.byte_offset >= 0 else None)


class Watch:
    """Keeps the first exception of callbacks until the call of the library has returned. A BRDF of Python code has one; a call
    with progress makes one."""

    def __init__(self) -> None:
        self.lock = threading.RLock()
        self.error: Optional[BaseException] = None
        self.shown = False  # an unfinished line of show_progress()
        self.interruptible = False  # during a call with Interrupts
        self.thread: Optional[int] = None  # that runs a function of the user

    def take(self) -> Optional[BaseException]:
        error, self.error = self.error, None
        return error

    def stopped(self) -> bool:
        return self.error is not None or (self.interruptible and Interrupts.pending)

    def run(self, function: Callable[..., Any], *args: Any) -> Any:
        """A function of the user in a callback; its exception is kept, and the result is None."""
        self.thread = threading.get_ident()
        try:
            with Interrupts.allowed():
                return function(*args)
        except BaseException as error:  # it cannot pass through the library; call() raises it
            self.error = error
            return None
        finally:
            self.thread = None


def refuse_reentry(watches: "Sequence[Watch]") -> None:
    """A function of the user must not call what is calling it: the call would wait for its own end."""
    if any(w.thread == threading.get_ident() for w in watches):
        raise Error("a function that the library calls uses the object that it is called for (its own BRDF, Scene or Scorer): give it "
                    "one of its own")


class Turns:
    """The lock of an object that serves one call after the other."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._watches: Sequence[Watch] = ()  # of the call in progress

    @contextlib.contextmanager
    def take(self, watches: "Sequence[Watch]" = ()) -> Iterator[None]:
        refuse_reentry(self._watches)
        with self._lock:
            self._watches = watches
            try:
                yield
            finally:
                self._watches = ()


class Interrupts:
    """Ctrl-C during a call with callbacks. Python may raise KeyboardInterrupt at the first instruction of a callback, where nothing can
    catch it, and it would be lost. During such a call a handler therefore notes the signal, which the callbacks report to the library, and
    raises only inside functions of the user."""

    pending = False
    raising = False

    @staticmethod
    def _handle(number: int, frame: Any) -> None:
        if Interrupts.raising:
            raise KeyboardInterrupt
        Interrupts.pending = True

    @staticmethod
    @contextlib.contextmanager
    def allowed() -> Iterator[None]:
        """Inside functions of the user, on the main thread: raise as usual."""
        main = threading.current_thread() is threading.main_thread()
        Interrupts.raising = main or Interrupts.raising
        try:
            yield
        finally:
            Interrupts.raising = Interrupts.raising and not main

    @staticmethod
    @contextlib.contextmanager
    def noted(watches: "Sequence[Watch]") -> Iterator[None]:
        """During a call with callbacks: the handler above, unless the program has one of its own."""
        if (not watches or threading.current_thread() is not threading.main_thread() or
                signal.getsignal(signal.SIGINT) is not signal.default_int_handler):
            yield
            return
        Interrupts.pending = False
        signal.signal(signal.SIGINT, Interrupts._handle)
        for watch in watches:
            watch.interruptible = True
        try:
            yield
        finally:
            for watch in watches:
                watch.interruptible = False
            signal.signal(signal.SIGINT, signal.default_int_handler)
            if Interrupts.pending:
                Interrupts.pending = False
                raise KeyboardInterrupt


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
    """A C callback, which is also how Ctrl-C stops the call: without one, Python would see it only afterwards."""
    function = progress_of(progress)

    def callback(user: Any, stage: bytes, done: float, total: float) -> int:
        if not own.stopped():
            own.shown = progress is True
            own.run(function, stage.decode(), done, total)
        return int(any(w.stopped() for w in (own, *watches)))

    return Progress(callback)


def call(function: Any, *args: Any, watches: Sequence[Watch] = (), own: Optional[Watch] = None) -> Any:
    """Call a function of the library and raise what went wrong: an exception of a callback first, then its own error. Threads that
    use the same Python callback take turns."""
    err = _abi.Error()
    fallible = bool(function.argtypes) and function.argtypes[-1] is POINTER(_abi.Error)
    used = ([own] if own else []) + list(watches)
    refuse_reentry(used)
    with contextlib.ExitStack() as stack:
        for watch in sorted(set(watches), key=id):
            stack.enter_context(watch.lock)
        try:
            with Interrupts.noted(used):
                result = function(*args, ctypes.byref(err)) if fallible else function(*args)
        except KeyboardInterrupt as interrupt:
            if not used:
                raise
            used[0].error = interrupt
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


def ignoring(path: PathLike, ignore: Optional[str]) -> bytes:
    """The argument that opens what reflects of a material."""
    return encode(path) if ignore is None else b"ignore:" + encode(ignore) + b":" + encode(path)


def decode(text: Optional[bytes]) -> Optional[str]:
    return None if text is None else os.fsdecode(text)


def address(array: np.ndarray) -> int:
    return array.ctypes.data


def array_at(at: int, shape: Tuple[int, ...], kind: Any = ctypes.c_double) -> np.ndarray:
    """A copy of an array of the library."""
    return np.ctypeslib.as_array(ctypes.cast(at, POINTER(kind)), shape).copy()


def names_of(function: Callable[[int], Optional[bytes]]) -> Tuple[str, ...]:
    """What a function of the library names for 0, 1, ..."""
    return tuple(name.decode() for name in iter(map(function, itertools.count()).__next__, None))


def words(values: Type[enum.IntEnum]) -> Tuple[str, ...]:
    """The names of an enum that counts from 0, for `choice`."""
    return tuple(v.name.lower() for v in values)


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
