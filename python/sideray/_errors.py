"""Errors: sideray.Error and its subclasses, which are exceptions of Python's own too where one fits."""

import re
from typing import Optional


class Error(Exception):
    """A call failed and changed nothing. The text says what was wrong, where, and what to do.

    status: the number of the C interface (`sideray_status` in sideray/base.h), negative.
    """

    status: int = -7

    def __init__(self, message: str = "", status: Optional[int] = None) -> None:
        super().__init__(message)
        if status is not None:
            self.status = status


class InvalidArgument(Error, ValueError):
    """An argument, an option or a file is not what is accepted; the message names the accepted range."""

    status = -1


class UnknownChannel(InvalidArgument, KeyError):
    """The picture has no channel of that name; the message lists those that it has."""

    __str__ = Exception.__str__  # KeyError quotes its text


class SceneNotFound(Error, FileNotFoundError):
    """There is no such file."""

    status = -1
    __str__ = Exception.__str__


class OutOfMemory(Error, MemoryError):
    """Memory, of the machine or of the device, does not suffice."""

    status = -2


class Unsupported(Error, NotImplementedError):
    """The driver or the build lacks something; the message names it."""

    status = -3


class NoDevice(Error, RuntimeError):
    """There is no usable OpenGL device; the message says why for each candidate."""

    status = -4


class DeviceFailed(Error, RuntimeError):
    """The driver reported an error or lost the context."""

    status = -5


_CLASSES = {c.status: c for c in (InvalidArgument, OutOfMemory, Unsupported, NoDevice, DeviceFailed)}


def of_status(status: int, message: str) -> Error:
    """The exception for a status of the C interface."""
    return _CLASSES.get(status, Error)(message, status)


def of_usage(message: str) -> Error:
    """The exception for wrong usage of the program, whose options are keywords here."""
    return InvalidArgument(re.sub(r"--([a-z][a-z-]*)", lambda name: name[1].replace("-", "_"), message))
