"""What the tests of the Python package share: a renderer, small scenes, files that the program makes."""

import numpy as np
import pytest

import sideray


@pytest.fixture(scope="session")
def renderer():
    with sideray.Renderer() as made:
        yield made


def quad(z=0.0, half=1.0):
    """Positions and triangles of a square that faces +Z."""
    corners = np.array([[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]])
    return corners, np.array([[0, 1, 2], [0, 2, 3]])


def plain_scene(**material):
    """A square at z = 0 seen from z = 3: it covers the middle of the picture."""
    scene = sideray.Scene(env=None)
    positions, triangles = quad()
    scene.add_mesh(positions, triangles, material=material or None)
    scene.camera = sideray.Camera.look_at((0, 0, 3), (0, 0, 0))
    return scene


@pytest.fixture
def square():
    return plain_scene()
