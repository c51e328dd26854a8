"""Runs other programs for script/peers: to their end, to a limit of time, never leaving one behind."""
import contextlib
import os
import select
import signal
import subprocess
import time


class Failure(Exception):
    """Something that a program did wrong: its message is for the user."""


def run(command, limit_s, environment=None):
    """Runs a command to its end: (milliseconds, stdout, stderr). Its children end with it where it exceeds the limit."""
    start = time.perf_counter()
    with subprocess.Popen([str(c) for c in command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          errors="replace", start_new_session=True, env={**os.environ, **(environment or {})}) as process:
        try:
            out, err = process.communicate(timeout=limit_s)
        except BaseException as stop:
            end(process)
            if isinstance(stop, subprocess.TimeoutExpired):
                raise Failure(f"took longer than {limit_s:g} s (--limit)") from None
            raise
    if process.returncode != 0:
        raise Failure(f"exit code {process.returncode}\n{last_lines(out + err)}")
    return 1000 * (time.perf_counter() - start), out, err


def end(process):
    """Ends a process group: asks first, so that a browser which has a group of its own is ended by who started it."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGTERM)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(5)
        os.killpg(process.pid, signal.SIGKILL)


def last_lines(text, count=12):
    return "\n".join("    " + line for line in text.strip().splitlines()[-count:])


@contextlib.contextmanager
def display(programs, size):
    """A display of its own for the programs that need one, in DISPLAY; started once, so that no process pays for it."""
    if not any(program.needs_display for program in programs):
        yield
        return
    reading, writing = os.pipe()
    server = subprocess.Popen(["Xvfb", "-displayfd", str(writing), "-screen", "0", size + "x24", "-nolisten", "tcp"],
                              pass_fds=[writing], stderr=subprocess.DEVNULL)
    os.close(writing)
    try:
        number = os.read(reading, 16).decode().strip() if select.select([reading], [], [], 30)[0] else ""
        if not number:
            raise Failure("Xvfb does not start")
        os.environ["DISPLAY"] = ":" + number
        yield
    finally:
        os.close(reading)
        server.terminate()
        server.wait()
