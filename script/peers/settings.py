"""The scenes of script/scoreboard, and how each is seen and lit."""
import dataclasses
import pathlib


@dataclasses.dataclass
class Setting:
    """A scene, and how it is seen and lit."""

    name: str
    source: str  # a file, or a built-in scene of Sideray
    what: str = ""
    camera: str = ""
    eye: tuple = ()
    target: tuple = ()
    fov: float = 45
    sky: str = "sky"  # Sideray's, none, or a lat-long .hdr
    lamps: tuple = ()  # (position, candela)
    thickness: dict = dataclasses.field(default_factory=dict)  # of materials by name
    exposure: float = 0  # stops
    truth: str = "Cycles:128,Mitsuba:512"  # tracers and their samples a pixel
    own_samples: int = 32  # positions of Sideray's own paths
    dolly: tuple = ()  # by how much the camera moves in a frame of --dolly, right, up and back
    width: int = 480
    height: int = 270


STUDIO = "lightroom_14b.hdr"  # of the Khronos glTF Render Fidelity project
SETTINGS = [
    Setting("bistro", "bistro", "an interior at evening, crowded with glasses; seven lamps and a street lamp", camera="main",
            sky="none", truth="Cycles:64", own_samples=8),
    Setting("attenuation", "AttenuationTest/AttenuationTest.glb", "bodies of blue glass before a board", eye=(0, 0, 22),
            target=(0, 0, 0), sky=STUDIO, exposure=1, truth="Cycles:128,Mitsuba:1024"),
    Setting("cup", "CupAndWater/CupAndWater.glb", "a cup of water and a straw", eye=(0.2, 0.25, 0.35), target=(0, 0.09, 0), fov=40,
            sky=STUDIO, exposure=1, thickness={"Cup_doubleSided": 0.004, "Water_doubleSided": 0.06}, dolly=(0.003, 0, -0.002)),
    Setting("table", "GlassTable/GlassTable.glb", "a table of dark glass", eye=(2.6, 2.3, 3.6), target=(0, 0.5, 0), fov=35, sky=STUDIO,
            exposure=1.5),
    Setting("forest", "forest", "trees, bushes and grass in the sun", camera="clearing", truth="Cycles:64", own_samples=8,
            dolly=(0.06, 0, -0.04)),
    Setting("theater", "HomeTheater/HomeTheater.gltf", "a furnished room lit by three lamps", eye=(0.3, 0.2, 2.2), target=(0, -0.4, -2),
            fov=65, sky="none", truth="Cycles:128,Mitsuba:256", lamps=(((0, 1.2, -1), 4), ((-1.5, 1.2, 1), 3), ((1.5, 1.2, 1), 3))),
]


def located(setting, assets):
    """With the files found below the folders of assets; None where one is not there."""
    def find(name):
        for folder in [pathlib.Path("."), *assets]:
            if (folder / name).is_file():
                return str((folder / name).resolve())
        return None

    source = find(setting.source) if "." in setting.source else setting.source
    sky = find(setting.sky) if "." in setting.sky else setting.sky
    return dataclasses.replace(setting, source=source, sky=sky) if source and sky else None
