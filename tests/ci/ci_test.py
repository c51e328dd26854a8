#!/usr/bin/env python3
"""The commands of examples/ci as they are written: ci_test.py SIDERAY SOURCE."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

PROGRAM, SOURCE = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
EXAMPLE = SOURCE / "examples" / "ci"


def recorded_by():
    """The commands of the README's block that are sideray's."""
    block = re.search(r"```\n(.*?)```", (EXAMPLE / "README.md").read_text(), re.DOTALL)[1]
    return [line for line in block.splitlines() if line.startswith("sideray ")]


def checked_by():
    """The workflow's `run:` lines but for the installation, which is the package's own test."""
    lines = re.findall(r"^ +run: (.*)$", (EXAMPLE / "golden.yml").read_text(), re.MULTILINE)
    return [line for line in lines if not line.startswith("apt-get ")]


def run(command, folder):
    path = f"{PROGRAM.parent}:{os.environ['PATH']}"
    done = subprocess.run(command, shell=True, cwd=folder, env={**os.environ, "PATH": path}, stdout=subprocess.PIPE, text=True)
    print(f"{command}: {done.returncode}\n{done.stdout}")
    return done


def main():
    record, check = recorded_by(), checked_by()
    assert len(record) == 1 and len(check) == 1, (record, check)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "golden").mkdir()
        shutil.copy(EXAMPLE / "jobs.json", folder / "golden")
        assert run(record[0], folder).returncode == 0
        assert run(check[0], folder).returncode == 0
        assert 'failures="0"' in (folder / "golden.xml").read_text()
        # Another picture is a failure, and what the workflow keeps is there.
        for file in (folder / "golden" / "jobs.json", folder / "golden" / "references" / "manifest.json"):
            text = file.read_text()
            changed = re.sub(r'"scene": ?"solids"', '"scene": "haze"', text)
            assert changed != text, file
            file.write_text(changed)
        assert run(check[0], folder).returncode == 3
        assert 'failures="1"' in (folder / "golden.xml").read_text()
        for kept in re.findall(r"^ {12}(\S+)$", (EXAMPLE / "golden.yml").read_text(), re.MULTILINE):
            assert (folder / kept).exists(), kept


if __name__ == "__main__":
    main()
