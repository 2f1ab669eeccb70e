"""Errors that stop a build, with a message for the author."""

from __future__ import annotations

import errno

_DISK = {
    errno.EACCES: "permission is denied",
    errno.EPERM: "permission is denied",
    errno.EROFS: "the file system is read-only",
    errno.ENOSPC: "the disk is full",
    errno.EDQUOT: "the disk quota is used up",
    errno.ENOTDIR: "a file stands where a folder is wanted",
    errno.EEXIST: "a file stands where a folder is wanted",
}


class BuildError(Exception):
    """The report cannot be built; the message names the reason and the author's file."""


def disk_failure(error: OSError) -> BuildError | None:
    """Return the error to report if a disk cannot be written to, else None.

    Examples
    --------
    >>> print(disk_failure(OSError(errno.ENOSPC, "", "report/build/report.pdf")))
    cannot write report/build/report.pdf: the disk is full
    """
    reason = _DISK.get(error.errno or 0)
    return (
        BuildError(f"cannot write {error.filename or 'the report'}: {reason}") if reason else None
    )
