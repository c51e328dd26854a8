"""The options of Renderer.render by name, for type checkers: of the program's table, which tests compare."""

from typing import Iterable, Literal, Optional, TypedDict, Union

from ._camera import Vector
from ._convert import ArrayLike

class RenderOptions(TypedDict, total=False):
    quality: Optional[Literal["draft", "balanced", "best"]]
    translucency: Optional[Literal[False, "raster", "raytraced", "hybrid", "reference", "off"]]
    layers: Optional[Union[int, Literal["auto", "unlimited"]]]
    ray_reuse: Optional[Union[float, Literal["auto"]]]
    cache_rate: Optional[Literal["full", "checkerboard", "interleaved", "quarter"]]
    second_wave: Optional[bool]
    whole_pixels: Optional[bool]
    match: Optional[Literal["id", "nearest", "distance"]]
    match_threshold: Optional[float]
    step: Optional[Literal["multihit", "retrace", "listing"]]
    mask: Optional[Literal["none", "stencil", "count"]]
    refraction: Optional[bool]
    rt_particles: Optional[bool]
    oit: Optional[Literal["sorted", "abuffer", "peel"]]
    shadows: Optional[Literal[False, "map", "exact", "inexact", "off"]]
    inexact: Optional[Literal["tmin", "bounded", "restpose"]]
    inexact_bias: Optional[float]
    inexact_target: Optional[Literal["model", "bit", "stencil"]]
    poses: Optional[Union[int, Literal["rest", "all"]]]
    cull_angle: Optional[float]
    reflections: Optional[Union[bool, Literal["auto", "on", "off"]]]
    ambient: Optional[Literal[False, "auto", "off", "ao", "bounce"]]
    denoise: Optional[bool]
    taa: Optional[bool]
    samples: Optional[int]
    light_samples: Optional[int]
    bounces: Optional[Union[int, Literal["unlimited"]]]
    caustics: Optional[bool]
    seed: Optional[int]
    budget: Optional[float]
    deadline: Optional[float]
    reference: Optional[bool]
    check: Optional[bool]

class FrameOptions(RenderOptions, total=False):
    eye: Optional[Vector]
    target: Optional[Vector]
    fov: float
    aov: Union[str, Iterable[str]]
    color: bool
    repeat: int
    exposure: float
    tonemap: str
    ray_traced: Optional[str]
    env: Union[str, ArrayLike, None]
    env_scale: float
    env_rotate: float
