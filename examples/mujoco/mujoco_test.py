"""mujoco_test.py PROGRAM FOLDER: glass in MuJoCo's own pictures changes what is behind glass, and nothing else.

Models without glass come out as mjr_render drew them, bit by bit; glass with the index of air would be seen nowhere, so that
what rays show through real glass has the colours of the scene. A mesh is glass too, also under a light that casts shadows, which
makes mjr_render leave another texture unit active. Exit code 0 if all went well.
"""

import pathlib
import re
import struct
import subprocess
import sys
import tempfile
import zlib

# An octahedron over a chequered floor.
MESH = """<mujoco><visual><global offwidth="160" offheight="120"/></visual><statistic center="0 0 .5" extent="3"/>
<asset>
  <texture name="grid" type="2d" builtin="checker" rgb1=".1 .2 .3" rgb2=".9 .8 .7" width="64" height="64"/>
  <material name="grid" texture="grid" texrepeat="20 20"/><material name="glass" rgba=".9 .9 .9 .3"/>
  <mesh name="octahedron" vertex="1 0 0 -1 0 0 0 1 0 0 -1 0 0 0 1 0 0 -1"/>
</asset>
<worldbody>
  <light pos="0 0 5" dir="0 0 -1" castshadow="true"/><geom type="plane" size="5 5 .1" material="grid"/>
  <geom type="sphere" size=".2" pos="2 1 .2" rgba="1 0 0 1"/>
  <geom type="mesh" mesh="octahedron" pos="0 0 1.1" material="glass"/>
</worldbody></mujoco>"""


def read_png(path):
    """Rows of RGB bytes of an 8-bit RGB picture, any filter."""
    data, at, stream = path.read_bytes(), 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        body = data[at + 8 : at + 8 + length]
        if kind == b"IHDR":
            width, height = struct.unpack(">II", body[:8])
        if kind == b"IDAT":
            stream += body
        at += 12 + length
    raw, stride, rows, above = zlib.decompress(stream), 3 * width, [], bytearray(3 * width)
    for y in range(height):
        kind, row = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1 : (y + 1) * (stride + 1)])
        for i in range(stride):
            left, corner = (row[i - 3], above[i - 3]) if i >= 3 else (0, 0)
            up = above[i]
            nearest = min((left, up, corner), key=lambda c: abs(left + up - corner - c))
            row[i] = (row[i] + (0, left, up, (left + up) // 2, nearest)[kind]) & 255
        rows.append(row)
        above = row
    return width, height, rows


def draw(program, model, folder, *options):
    before, after = folder / "before.png", folder / "after.png"
    command = [program, str(model), "-o", str(after), "--before", str(before), *options]
    result = subprocess.run(command, capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(f"{' '.join(command)}: {result.stderr}")
    return read_png(before), read_png(after)


def changed(first, second):
    """Places of pixels that differ."""
    (width, height, a), (_, _, b) = first, second
    return {(x, y) for y in range(height) if a[y] != b[y] for x in range(width) if a[y][3 * x : 3 * x + 3] != b[y][3 * x : 3 * x + 3]}


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    work = pathlib.Path(tempfile.mkdtemp())
    small = (folder / "glassware.xml").read_text().replace('offwidth="640" offheight="480"', 'offwidth="160" offheight="120"')
    glass, none = work / "glass.xml", work / "none.xml"
    glass.write_text(small)
    none.write_text(small.replace('name="glass clear"', 'name="clear"').replace('name="glass green"', 'name="green"')
                    .replace('material="glass clear"', 'material="clear"').replace('material="glass green"', 'material="green"'))
    before, after = draw(program, none, work)
    if changed(before, after):
        sys.exit(f"without glass {len(changed(before, after))} pixels are not those of mjr_render")
    # Lights that follow a body look different in the first picture that mjr_render draws.
    humanoid = pathlib.Path("/usr/share/mujoco/model/humanoid/humanoid.xml")
    if humanoid.exists():
        before, after = draw(program, humanoid, work)
        if changed(before, after):
            sys.exit(f"of the humanoid {len(changed(before, after))} pixels are not those of mjr_render")
    before, after = draw(program, glass, work)
    places = changed(before, after)
    if not 1000 < len(places) < 8000:
        sys.exit(f"{len(places)} pixels changed by glass: it covers about 2000 of 19200")
    if any(y < 30 for _, y in places):
        sys.exit("the sky above everything has changed")
    # The ball shows the scene upside down: the sky below, the table above.
    blue = [(x, y) for x, y in places if after[2][y][3 * x + 2] > after[2][y][3 * x] + 30 and x < 90]
    if not blue or sum(y for _, y in blue) / len(blue) < 60:
        sys.exit("the sky is not seen in the lower half of the glass ball")
    mesh, nothing = work / "mesh.xml", work / "nothing.xml"
    mesh.write_text(MESH)
    nothing.write_text(re.sub(r'<geom type="mesh"[^>]*>', "", MESH))
    seen = changed(draw(program, nothing, work)[0], draw(program, mesh, work)[1])
    if not 300 < len(seen) < 10000:
        sys.exit(f"{len(seen)} pixels show a glass mesh: it covers about 2000 of 19200")
    print(f"{len(seen)} pixels of a glass mesh")
    print(f"{len(places)} pixels of glass, {len(blue)} of them show the sky from below")


if __name__ == "__main__":
    main()
