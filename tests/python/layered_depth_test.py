"""Layered depth against closed forms: planes, boxes, a sphere of glass; and against two calls of trace_rays."""

import numpy as np
import pytest
from conftest import quad

import sideray
from sideray import SurfaceFace, SurfaceKind

SIZE = (64, 48)
GLASS = {"transmission": 1.0, "roughness": 0.0, "ior": 1.5, "thickness": 0.1}
POSE = sideray.Camera.look_at((0.2, 0.1, 3), (0, 0, 0)).world_from_camera
CAMERAS = {
    "perspective": sideray.Camera(POSE),
    "off-centre": sideray.Camera.from_intrinsics(POSE, 70, 55, 20, 30, SIZE, z_near=0.2),
    "orthographic": sideray.Camera(POSE, half_height=1.2, z_near=0.2, z_far=50),
}


def rays_of(camera, size=SIZE):
    """Origins where a pixel's way begins, unit directions, and the cosine to the view axis, in double precision."""
    origins, directions = camera.rays(size)
    axis = -camera.world_from_camera[:3, 2]
    directions = directions.astype(np.float64)
    if camera.half_height is not None:
        origins = origins + camera.z_near * axis
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    return origins, directions, directions @ axis


def depth_of(camera, points):
    return (points - camera.world_from_camera[:3, 3]) @ -camera.world_from_camera[:3, 2]


def pane(scene, center, normal, material=None, half=40.0):
    """A large square with this normal on its front."""
    normal = np.asarray(normal, float) / np.linalg.norm(normal)
    u = np.cross((0.0, 1.0, 0.1), normal)
    u /= np.linalg.norm(u)
    v = np.cross(normal, u)
    corners = [np.asarray(center) + half * (a * u + b * v) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    return scene.add_mesh(corners, [[0, 1, 2], [0, 2, 3]], material=material), normal


@pytest.mark.parametrize("name", CAMERAS)
def test_a_stack_of_panes(name):
    """Every pane is met, behind the opaque one too, in order, from whichever side; where a ray meets it is a quotient."""
    camera, scene = CAMERAS[name], sideray.Scene(env=None)
    stack = [  # center, normal, material, kind
        ((0, 0, 1.5), (0.1, 0.05, 1), {"alpha_mode": "blend", "base_color": (1, 1, 1, 0.5)}, SurfaceKind.BLEND),
        ((0, 0, 1.0), (0, 0.2, 1), {"transmission": 1.0}, SurfaceKind.THIN),
        ((0, 0, 0.4), (0.1, 0.1, -1), {"transmission": 1.0, "double_sided": True}, SurfaceKind.THIN),
        ((0, 0, 0.0), (0, 0, 1), None, SurfaceKind.OPAQUE),
        ((0, 0, -1.0), (-0.1, 0, -1), None, SurfaceKind.OPAQUE),
        ((0, 0, -2.0), (0.1, 0, 1), {"alpha_mode": "mask", "base_color": (1, 1, 1, 1)}, SurfaceKind.MASK),
        ((0, 0, -3.0), (0, 0.1, 1), GLASS, SurfaceKind.VOLUME),
    ]
    layers = None
    faces = [SurfaceFace.FRONT, SurfaceFace.FRONT, SurfaceFace.BACK, SurfaceFace.FRONT, SurfaceFace.HIDDEN_BACK, SurfaceFace.FRONT,
             SurfaceFace.FRONT]
    placed = [pane(scene, center, normal, material) for center, normal, material, _ in stack]
    layers = scene.layered_depth(SIZE, camera)
    origins, directions, cosines = rays_of(camera)
    assert layers.z.shape == (48, 64, 8) and layers.layers == 8 and layers.size == SIZE
    assert (layers.count == len(stack)).all()
    for k, ((shown, normal), (center, _, _, kind)) in enumerate(zip(placed, stack)):
        t = ((np.asarray(center) - origins) @ normal) / (directions @ normal)
        assert np.allclose(layers.distance[..., k], t, rtol=2e-6), k
        assert np.allclose(layers.z[..., k], depth_of(camera, origins + t[..., None] * directions), rtol=2e-6), k
        toward = normal if normal[2] > 0 else -normal
        assert np.allclose(layers.normal[..., k, :], toward, atol=1e-5) and np.allclose(layers.geometric_normal[..., k, :], toward, atol=1e-5)
        assert (layers.surface_id[..., k] == shown.surface_id).all() and (layers.instance[..., k] == shown.instance).all()
        assert (layers.kind[..., k] == kind).all() and (layers.face[..., k] == faces[k]).all()
        assert (layers.primitive[..., k] <= 1).all()
        assert (layers.translucent[..., k] == (kind >= SurfaceKind.BLEND)).all()
    assert np.isinf(layers.z[..., 7]).all() and np.isinf(layers.distance[..., 7]).all() and not layers.kind[..., 7].any()
    # As many as are asked for, the nearest.
    three = scene.layered_depth(SIZE, camera, layers=3)
    assert (three.count == 3).all() and np.array_equal(three.z, layers.z[..., :3])
    # The bent path ends at what is opaque, and thin panes bend nothing.
    bent = scene.layered_depth(SIZE, camera, bent=True)
    assert (bent.count == 4).all() and np.array_equal(bent.surface_id[..., :4], layers.surface_id[..., :4])
    assert np.allclose(bent.z[..., :4], layers.z[..., :4], rtol=1e-6)


BOX_TRIANGLES = np.array([[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7], [0, 1, 5], [0, 5, 4], [2, 3, 7], [2, 7, 6], [1, 2, 6], [1, 6, 5],
                          [0, 4, 7], [0, 7, 3]])


def box_corners(low, high):
    (x0, y0, z0), (x1, y1, z1) = low, high
    return [(x0, y0, z0), (x1, y0, z0), (x1, y1, z0), (x0, y1, z0), (x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)]


@pytest.mark.parametrize("name", CAMERAS)
def test_an_opaque_box_has_a_front_and_a_back(name):
    camera, scene = CAMERAS[name], sideray.Scene(env=None)
    low, high = np.array([-0.6, -0.5, -1.0]), np.array([0.5, 0.7, 0.2])
    pane(scene, (0, 0, 1), (0, 0, 1), {"transmission": 1.0})
    scene.add_mesh(box_corners(low, high), BOX_TRIANGLES)
    layers = scene.layered_depth(SIZE, camera)
    origins, directions, _ = rays_of(camera)
    with np.errstate(divide="ignore", invalid="ignore"):
        a, b = (low - origins) / directions, (high - origins) / directions
    enters, leaves = np.nanmax(np.minimum(a, b), -1), np.nanmin(np.maximum(a, b), -1)
    certain = np.abs(leaves - enters) > 1e-4  # not along an edge
    hit = (leaves > enters) & certain
    assert 200 < hit.sum() < 2000 and (layers.count[hit] == 3).all() and (layers.count[~hit & certain] == 1).all()
    assert np.allclose(layers.distance[hit][:, 1], enters[hit], rtol=2e-6)
    assert np.allclose(layers.distance[hit][:, 2], leaves[hit], rtol=2e-6)
    assert (layers.face[hit][:, 1] == SurfaceFace.FRONT).all() and (layers.face[hit][:, 2] == SurfaceFace.HIDDEN_BACK).all()
    # Normals are on the side that the ray comes from, on the back too.
    for k in (1, 2):
        assert (np.einsum("ij,ij->i", layers.geometric_normal[hit][:, k], directions[hit]) < 0).all()
    # The path of light ends at the front.
    bent = scene.layered_depth(SIZE, camera, bent=True)
    assert (bent.count[hit] == 2).all() and np.allclose(bent.distance[hit][:, 1], enters[hit], rtol=2e-6)


def refracted(direction, normal, ratio):
    """Snell's law; ratio: index of the medium that is left over that of the one entered. None: total reflection."""
    cosine = -direction @ normal
    rest = 1 - ratio ** 2 * (1 - cosine ** 2)
    return None if rest < 0 else ratio * direction + (ratio * cosine - np.sqrt(rest)) * normal


def box_path(origin, direction, low, high, ior, wall):
    """The places at which a path meets a box of glass, and then the plane z = wall: entry, inner reflections, exit, wall."""
    def sides(point, way, inside):
        with np.errstate(divide="ignore", invalid="ignore"):
            t = np.stack([(low - point) / way, (high - point) / way])
        near, far = np.fmin(*t), np.fmax(*t)
        axis = far.argmin() if inside else near.argmax()
        hits = inside or (near.max() < far.min() and near.max() > 0)
        return (axis, (far if inside else near)[axis]) if hits else None

    found, point, way, inside = [], origin, direction, False
    first = sides(point, way, False)
    for _ in range(10):
        at = first if not found else sides(point, way, True) if inside else None
        if at is None:
            t = (wall - point[2]) / way[2]
            return [*found, point + t * way] if t > 0 else found
        axis, t = at
        point = point + t * way
        normal = np.zeros(3)
        normal[axis] = -np.sign(way[axis])
        found.append(point)
        onward = refracted(way, normal, ior if inside else 1 / ior)
        if onward is None:
            way = way - 2 * (way @ normal) * normal
        else:
            way, inside = onward, not inside
    return found


@pytest.mark.parametrize("name", CAMERAS)
def test_a_box_of_glass_bends_and_reflects(name):
    """A thick box: paths leave it shifted, and those that reach a side from inside are reflected there."""
    camera, scene = CAMERAS[name], sideray.Scene(env=None)
    low, high = np.array([-0.7, -0.5, -1.5]), np.array([0.6, 0.55, 0.3])
    scene.add_mesh(box_corners(low, high), BOX_TRIANGLES, material=GLASS)
    pane(scene, (0, 0, -4), (0, 0, 1))
    layers = scene.layered_depth(SIZE, camera, bent=True)
    origins, directions, _ = rays_of(camera)
    compared = reflected = 0
    for y, x in np.ndindex(48, 64):
        places = np.array(box_path(origins[y, x], directions[y, x], low, high, 1.5, -4.0))
        turns = places[:-1]
        edge = np.sort(np.minimum(np.abs(turns - low), np.abs(turns - high)), axis=-1)[:, 1] if len(turns) else np.ones(1)
        if edge.min() < 1e-3:  # where two sides meet, rounding decides
            continue
        count = layers.count[y, x]
        assert count == len(places), (x, y)
        assert np.allclose(layers.z[y, x, :count], depth_of(camera, places), atol=2e-5)
        lengths = np.cumsum(np.linalg.norm(np.diff(np.concatenate([origins[y, x][None], places]), axis=0), axis=1))
        assert np.allclose(layers.distance[y, x, :count], lengths, atol=2e-5)
        compared, reflected = compared + (len(places) > 1), reflected + (len(places) > 3)
    assert compared > 300 and (reflected > 30 or name == "orthographic")


def sphere(radius, segments=768):
    """Positions, normals and triangles of a fine sphere: its facets are within radius * (pi / segments)^2 / 2 of it."""
    theta, phi = np.meshgrid(np.linspace(0, np.pi, segments // 2 + 1), np.arange(segments) * 2 * np.pi / segments, indexing="ij")
    normals = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), -np.sin(theta) * np.sin(phi)], -1).reshape(-1, 3)
    i, k = np.meshgrid(np.arange(segments // 2), np.arange(segments), indexing="ij")
    a, b = i * segments + k, i * segments + (k + 1) % segments
    triangles = np.stack([np.stack([a, a + segments, b], -1), np.stack([b, a + segments, b + segments], -1)], 2).reshape(-1, 3)
    return radius * normals, normals, triangles


@pytest.mark.parametrize("name", CAMERAS)
def test_a_sphere_of_glass(name):
    """Entry, exit and the wall behind, by Snell's law about the radius; and straight through."""
    camera, scene = CAMERAS[name], sideray.Scene(env=None)
    positions, normals, triangles = sphere(0.8)
    scene.add_mesh(positions, triangles, normals, material=GLASS)
    pane(scene, (0, 0, -3), (0, 0, 1))
    bent, straight = scene.layered_depth(SIZE, camera, bent=True), scene.layered_depth(SIZE, camera)
    origins, directions, _ = rays_of(camera)
    compared = 0
    for y, x in np.ndindex(48, 64):
        origin, way = origins[y, x], directions[y, x]
        middle = -origin @ way
        offset2 = origin @ origin - middle ** 2
        if offset2 > 0.65 ** 2:  # toward the edge the facets count for more
            assert offset2 < 0.81 ** 2 or bent.count[y, x] == straight.count[y, x] == 1
            continue
        half = np.sqrt(0.8 ** 2 - offset2)
        assert straight.count[y, x] == 3
        assert np.allclose(straight.distance[y, x, :2], (middle - half, middle + half), atol=1e-4)
        enters = origin + (middle - half) * way
        inside = refracted(way, enters / 0.8, 1 / 1.5)
        leaves = enters - 2 * (enters @ inside) * inside
        behind = refracted(inside, -leaves / 0.8, 1.5)
        wall = leaves + (-3 - leaves[2]) / behind[2] * behind
        places = np.array([enters, leaves, wall])
        assert bent.count[y, x] == 3, (x, y)
        assert np.allclose(bent.z[y, x, :3], depth_of(camera, places), atol=2e-4)
        lengths = np.cumsum(np.linalg.norm(np.diff(np.concatenate([origin[None], places]), axis=0), axis=1))
        assert np.allclose(bent.distance[y, x, :3], lengths, atol=2e-4)
        assert np.allclose(bent.normal[y, x, :3], (enters / 0.8, -leaves / 0.8, (0, 0, 1)), atol=2e-4)
        assert bent.face[y, x, :3].tolist() == [SurfaceFace.FRONT, SurfaceFace.HIDDEN_BACK, SurfaceFace.FRONT]
        compared += 1
    assert compared > 300


def random_scene(seed, count=160):
    """Quads of all kinds in random places; double sided, as trace_rays leaves backs of others out where they are translucent."""
    rng = np.random.default_rng(seed)
    scene = sideray.Scene(env=None)
    kinds = [None, {"alpha_mode": "blend", "base_color": (1, 1, 1, 0.4)}, {"transmission": 1.0}, GLASS]
    positions, triangles = quad()
    for i in range(count):
        frame = np.eye(4)
        frame[:3, :3] = np.linalg.qr(rng.normal(size=(3, 3)))[0] * rng.uniform(0.2, 0.8)
        frame[:3, 3] = rng.uniform((-1.5, -1.5, -4), (1.5, 1.5, 1.5))
        scene.add_mesh(positions, triangles, material={**(kinds[i % 4] or {}), "double_sided": True}, transform=frame)
    return scene


@pytest.mark.parametrize("name", CAMERAS)
def test_layers_are_those_of_two_calls_of_trace_rays(name):
    camera, scene = CAMERAS[name], random_scene(3)
    origins, directions, _ = rays_of(camera)
    near = camera.z_near if camera.half_height is None else 0.0
    cosines = directions @ -camera.world_from_camera[:3, 2]
    hits = np.concatenate([scene.trace_rays(origins, directions, t_near=near / cosines, layers=32, translucent=t) for t in (False, True)],
                          axis=-1)
    hits = np.take_along_axis(hits, np.argsort(hits["distance"], axis=-1, kind="stable"), axis=-1)
    layers = scene.layered_depth(SIZE, camera, layers=20)
    # A ray through an edge may be decided either way: the two are not the same bits.
    same = (hits["surface_id"][..., :20] == layers.surface_id).all(-1)
    assert same.mean() > 0.998 and layers.count.max() > 8 and not (layers.count[same] != np.isfinite(hits["distance"]).sum(-1)[same]).any()
    found = np.isfinite(layers.distance) & same[..., None]
    assert np.allclose(layers.distance[found], hits["distance"][..., :20][found], rtol=2e-6)
    assert np.array_equal(layers.primitive[found], hits["primitive"][..., :20][found])
    assert np.allclose(np.abs(np.einsum("ij,ij->i", layers.geometric_normal[found], hits["normal"][..., :20, :][found])), 1, atol=1e-5)
    front = np.einsum("ij,ij->i", hits["normal"][..., :20, :][found],
                      np.broadcast_to(directions[..., None, :], (*layers.z.shape, 3))[found]) < 0
    assert np.array_equal(layers.face[found] == SurfaceFace.FRONT, front)


def test_bent_layers_end_where_the_channels_say(renderer):
    scene = sideray.load("solids")
    picture = renderer.render(scene, (80, 60), aov="first,behind")
    layers = scene.layered_depth((80, 60), layers=32, bent=True)
    assert np.array_equal(layers.z[..., 0], picture["first.Z"]) and np.array_equal(layers.surface_id[..., 0], picture["first.surface"])
    assert np.array_equal(layers.normal[..., 0, :][layers.count > 0], picture["first.N"][layers.count > 0])
    ended = picture["behind.surface"] > 0
    last = np.maximum(layers.count.astype(int) - 1, 0)[..., None]
    assert ended.sum() > 1000
    assert np.array_equal(np.take_along_axis(layers.z, last, -1)[..., 0][ended], picture["behind.Z"][ended])
    assert np.array_equal(np.take_along_axis(layers.distance, last, -1)[..., 0][ended], picture["behind.length"][ended])


def test_nothing_is_no_layers():
    for bent in (False, True):
        layers = sideray.Scene(env=None).layered_depth((5, 4), sideray.Camera(), layers=2, bent=bent)
        assert layers.z.shape == (4, 5, 2) and np.isinf(layers.z).all() and not layers.count.any() and not layers.normal.any()


def test_wrong_requests_are_refused():
    scene = sideray.Scene(env=None)
    for size, layers, what in (((8, 8), 65, "layers 65"), ((8, 8), 0, "0 layers"), ((0, 8), 1, "0x8"), ((16385, 1), 1, "16385x1")):
        with pytest.raises(sideray.InvalidArgument, match=what):
            scene.layered_depth(size, sideray.Camera(), layers=layers)
