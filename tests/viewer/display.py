"""An X server of a test's own (Xvfb), whose screen is a file."""
import os
import pathlib
import struct
import subprocess

from x11 import Client


class Display:
    def __init__(self, folder, size):
        self.folder, self.size = pathlib.Path(folder), size
        read, write = os.pipe()
        self.server = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "%dx%dx24" % size, "-fbdir", str(folder),
                                        "-nolisten", "tcp", "-noreset"], pass_fds=[write], stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as stream:
            self.name = ":" + stream.readline().strip()
        self.environment = {**os.environ, "DISPLAY": self.name}

    def client(self):
        return Client(self.name)

    def end(self):
        self.server.terminate()
        self.server.wait()

    def use(self, *words):
        """Runs xdotool; what it writes."""
        return subprocess.run(["xdotool", *map(str, words)], env=self.environment, stdout=subprocess.PIPE,
                              stderr=subprocess.DEVNULL, text=True, check=False).stdout.strip()

    def screen(self, box=None):
        """The pixels in (left, top, right, bottom), four bytes each: blue, green, red, nothing. None: all of them."""
        data = (self.folder / "Xvfb_screen0").read_bytes()
        header = struct.unpack(">25I", data[:100])
        begin, stride = header[0] + 12 * header[19], header[12]
        left, top, right, bottom = box or (0, 0, *self.size)
        return b"".join(data[begin + y * stride + 4 * left:begin + y * stride + 4 * right] for y in range(top, bottom))

    def picture(self):
        """The screen by Pillow."""
        from PIL import Image
        return Image.frombuffer("RGB", self.size, self.screen(), "raw", "BGRX", 0, 1)
