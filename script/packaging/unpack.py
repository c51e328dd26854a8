"""unpack.py ARCHIVE.tar.gz FOLDER: FOLDER becomes what the archive's one folder holds.

Files that are the same already stay untouched, so that a build in place compiles only what has changed: in a reproducible
archive all files are of one time.
"""
import pathlib
import sys
import tarfile


def main(archive, folder):
    folder = pathlib.Path(folder)
    kept = set()
    with tarfile.open(archive) as tar:
        for member in tar.getmembers():
            if not member.isfile():
                continue
            path = folder.joinpath(*pathlib.PurePosixPath(member.name).parts[1:])
            kept.add(path)
            content = tar.extractfile(member).read()
            if not path.is_file() or path.read_bytes() != content:
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(content)
            path.chmod(0o755 if member.mode & 0o100 else 0o644)
    for path in [path for path in folder.rglob("*") if path.is_file() and path not in kept]:
        path.unlink()


main(*sys.argv[1:])
