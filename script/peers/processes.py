"""Runs other programs for script/scoreboard: to their end, to a limit of time, never leaving one behind."""
import contextlib
import dataclasses
import os
import pathlib
import signal
import subprocess
import tempfile
import threading
import time

PAGE_KB = os.sysconf("SC_PAGE_SIZE") // 1024


class Failure(Exception):
    """Something that a program did wrong: its message is for the user."""


@dataclasses.dataclass
class Run:
    """What a process took from its start to its end, its children included."""

    wall_s: float
    processor_s: float
    peak_mb: float
    out: str
    err: str


class Watch(threading.Thread):
    """Follows the resident memory of a process and of all that it starts."""

    def __init__(self, root):
        super().__init__(daemon=True)
        self.root, self.peak_kb, self.over = root, 0, threading.Event()

    def run(self):
        while not self.over.wait(0.2):
            self.peak_kb = max(self.peak_kb, resident_kb(self.root))


def resident_kb(root):
    """Memory of a tree of processes; pages of files count once, in the process that has most of them."""
    parents, sizes = {}, {}
    for folder in pathlib.Path("/proc").iterdir():
        if folder.name.isdigit():
            with contextlib.suppress(OSError, ValueError, IndexError):
                parents[int(folder.name)] = int((folder / "stat").read_text().rpartition(")")[2].split()[1])
                pages, shared = (folder / "statm").read_text().split()[1:3]
                sizes[int(folder.name)] = (int(pages) * PAGE_KB, int(shared) * PAGE_KB)
    children = {root}
    while True:
        more = {pid for pid, parent in parents.items() if parent in children} - children
        if not more:
            break
        children |= more
    ours = [sizes[pid] for pid in children if pid in sizes]
    return sum(all_ - shared for all_, shared in ours) + max((shared for _, shared in ours), default=0)


def run(command, limit_s, environment=None):
    """Runs a command to its end. Its children end with it where it exceeds the limit."""
    before, start = os.times(), time.perf_counter()
    with tempfile.TemporaryFile("w+", errors="replace") as out, tempfile.TemporaryFile("w+", errors="replace") as err:
        process = subprocess.Popen([str(c) for c in command], stdout=out, stderr=err, start_new_session=True,
                                   env={**os.environ, **(environment or {})})
        watch = Watch(process.pid)
        watch.start()
        try:
            code = process.wait(limit_s)
        except BaseException as stop:
            end(process)
            if isinstance(stop, subprocess.TimeoutExpired):
                raise Failure(f"took longer than {limit_s:g} s (--limit)") from None
            raise
        finally:
            watch.over.set()
            watch.join()
        wall, after = time.perf_counter() - start, os.times()
        out.seek(0)
        err.seek(0)
        texts = out.read(), err.read()
    if code != 0:
        raise Failure(f"exit code {code}\n{last_lines(''.join(texts))}")
    processor = after.children_user + after.children_system - before.children_user - before.children_system
    return Run(wall, processor, watch.peak_kb / 1024, *texts)


def end(process):
    """Ends a process group, by a request first: a browser has its own group, which its parent must end."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGTERM)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(5)
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def last_lines(text, count=12):
    return "\n".join("    " + line for line in text.strip().splitlines()[-count:])
