#!/usr/bin/python3
"""outside.py SIDERAY FOLDER: of the pictures that `sideray run --pictures FOLDER` wrote, FLIP between the program's own one and
that with rays, outside of where rays are drawn; and the share of pixels that rays change."""
import pathlib
import re
import struct
import subprocess
import sys
import tempfile
import zlib


def read(path):
    """Width, height, and the pixels of a PNG without filters."""
    data, packed, place = path.read_bytes(), b"", 8
    while place < len(data):
        size, name = struct.unpack(">I4s", data[place:place + 8])
        body = data[place + 8:place + 8 + size]
        if name == b"IHDR":
            width, height = struct.unpack(">II", body[:8])
        packed += body if name == b"IDAT" else b""
        place += 12 + size
    rows = zlib.decompress(packed)
    return width, height, b"".join(rows[y * (3 * width + 1) + 1:(y + 1) * (3 * width + 1)] for y in range(height))


def write(path, width, height, pixels):
    def chunk(name, body):
        return struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))
    rows = b"".join(b"\0" + pixels[3 * y * width:3 * (y + 1) * width] for y in range(height))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)) +
                     chunk(b"IDAT", zlib.compress(rows, 1)) + chunk(b"IEND", b""))


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    flips, shares = [], []
    with tempfile.TemporaryDirectory() as work:
        own_path, rays_path = pathlib.Path(work) / "own.png", pathlib.Path(work) / "rays.png"
        for marks_path in sorted(folder.glob("*-marks.png"), key=lambda path: int(path.name.split("-")[0])):
            width, height, marks = read(marks_path)
            own, rays = (read(marks_path.with_name(marks_path.name.replace("marks", which)))[2] for which in ("own", "rays"))
            outside, changed = bytearray(rays), 0
            for i in range(0, len(marks), 3):
                if marks[i]:
                    outside[i:i + 3] = own[i:i + 3]
                    changed += own[i:i + 3] != rays[i:i + 3]
            write(own_path, width, height, own)
            write(rays_path, width, height, bytes(outside))
            said = subprocess.run([program, "compare", rays_path, own_path], stdout=subprocess.PIPE, text=True, check=False).stdout
            flips.append(float(re.search(r"(?i)flip\D*([\d.e-]+)", said).group(1)))
            shares.append(changed / (width * height))
            print(f"{marks_path.name.split('-')[0]:>6}: FLIP outside {flips[-1]:.5f}, changed by rays {100 * shares[-1]:.1f} %")
    if flips:
        print(f"{len(flips)} frames: FLIP outside at most {max(flips):.5f}, changed by rays {100 * sum(shares) / len(shares):.1f} %")


if __name__ == "__main__":
    main()
