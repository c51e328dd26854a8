"""Draws a .glb with VTK and prints what it took as JSON: run by script/scoreboard.

Depth peeling, physically based materials, the file's lights, the sky as image-based lighting; no shadows, since VTK's
shadow maps know neither point lights nor peeling.
"""
import json
import pathlib
import sys

import vtk

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
sys.dont_write_bytecode = True
from frames import parser_of, timed  # noqa: E402
from gltf import Glb, Material  # noqa: E402

MOST_PEELS = 100


def primitives(scene):
    """The primitives in the order in which vtkGLTFImporter makes actors of them: the node pushed last comes first."""
    nodes = list(scene["scenes"][scene.get("scene", 0)]["nodes"])
    while nodes:
        node = scene["nodes"][nodes.pop()]
        if "mesh" in node:
            yield from scene["meshes"][node["mesh"]]["primitives"]
        nodes += node.get("children", [])


def triangles(scene, primitive):
    corners = primitive.get("indices", primitive["attributes"]["POSITION"])
    return scene["accessors"][corners]["count"] // 3


def restore_translucency(scene, actors):
    """VTK's importer drops the alpha of a base colour, and reads neither transmission nor volumes."""
    sources = list(primitives(scene))
    counts = [actor.GetMapper().GetInput().GetNumberOfCells() for actor in actors]
    if counts != [triangles(scene, source) for source in sources]:
        sys.exit("vtk_frames: the actors that VTK imported do not stand in the order of the file's primitives")
    for actor, source in zip(actors, sources):
        material = Material(scene["materials"][source["material"]] if "material" in source else {})
        if material.opacity() == 1 and material.mode != "BLEND":
            continue
        look = actor.GetProperty()
        look.SetOpacity(material.opacity())
        look.SetColor([a * b for a, b in zip(look.GetColor(), material.tint())])
        actor.ForceOpaqueOff()
        actor.ForceTranslucentOn()


def calibrate_lights(renderer):
    """VTK's importer gives lamps no falloff, makes those that shine all around shine into half a space, and leaves them at
    their default place, (0, 0, 1) in their own space."""
    lights = renderer.GetLights()
    for index in range(lights.GetNumberOfItems()):
        light = lights.GetItemAsObject(index)
        if light.GetPositional():
            light.SetAttenuationValues(0, 0, 1)
            if light.GetTransformMatrix():
                light.SetPosition(0, 0, 0)
                light.SetFocalPoint(0, 0, -1)
            if light.GetConeAngle() >= 90:
                light.SetConeAngle(180)


def surround(renderer, sky):
    reader = vtk.vtkHDRReader()
    reader.SetFileName(sky)
    texture = vtk.vtkTexture()
    texture.SetInputConnection(reader.GetOutputPort())
    texture.SetColorModeToDirectScalars()
    texture.MipmapOn()
    texture.InterpolateOn()
    renderer.UseImageBasedLightingOn()
    renderer.SetEnvironmentTexture(texture)
    behind = vtk.vtkSkybox()
    behind.SetTexture(texture)
    behind.SetProjectionToSphere()
    behind.GammaCorrectOn()
    renderer.AddActor(behind)
    # A smooth sky: 1024 samples, as it is by default, would take most of the process's time.
    renderer.GetEnvMapPrefiltered().SetPrefilterMaxSamples(64)


def set_up(options, width, height):
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetSize(width, height)
    window.SetMultiSamples(0)
    window.SetAlphaBitPlanes(1)
    importer = vtk.vtkGLTFImporter()
    importer.SetFileName(options.scene)
    importer.SetRenderWindow(window)
    importer.SetCamera(options.camera)
    importer.Update()
    renderer = window.GetRenderers().GetFirstRenderer()
    found = renderer.GetActors()
    restore_translucency(Glb(options.scene).json, [found.GetItemAsObject(i) for i in range(found.GetNumberOfItems())])
    renderer.AutomaticLightCreationOff()
    calibrate_lights(renderer)
    if options.sky:
        surround(renderer, options.sky)
    renderer.SetUseDepthPeeling(1)
    renderer.SetMaximumNumberOfPeels(MOST_PEELS)
    renderer.SetOcclusionRatio(0.0)
    renderer.ResetCameraClippingRange()
    return window, renderer


def frame(window, renderer, shift):
    """Draws a frame with the camera moved sideways, so that the last frame cannot be reused."""
    renderer.GetActiveCamera().SetWindowCenter(shift, 0)
    window.Render()
    window.WaitForCompletion()


def write_picture(window, path):
    grab = vtk.vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.ReadFrontBufferOff()
    grab.ShouldRerenderOff()
    writer = vtk.vtkPNGWriter()
    writer.SetInputConnection(grab.GetOutputPort())
    writer.SetFileName(path)
    writer.Write()


def gl_name(window):
    lines = window.ReportCapabilities().splitlines()
    return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("OpenGL renderer"))


def main():
    parser = parser_of("vtk_frames.py", __doc__, size="1280x720")
    parser.add_argument("--camera", type=int, default=0)
    options = parser.parse_args()
    window, renderer = set_up(options, *options.size)
    frame(window, renderer, 0)
    write_picture(window, options.o)
    result = timed(lambda number: frame(window, renderer, 1e-4 * number), options.frames)
    print(json.dumps({"version": vtk.vtkVersion().GetVTKVersion(), "gl": gl_name(window), **result}))


main()
