"""A vector of environments that see: vector_env.py [MODEL.xml] [--envs 64] [--size 84x84] [--steps 20]

Each environment is a state of one MuJoCo model, and its observation is what a camera sees: colour, depth and segmentation. All
are drawn at once by sideray.mujoco with batch=N; mujoco.Renderer, which draws them one by one, is timed beside it. It needs
`pip install mujoco`; the class has the shape of gymnasium's VectorEnv and needs no gymnasium.
"""

import argparse
import os
import pathlib
import time

os.environ.setdefault("MUJOCO_GL", "egl")
import mujoco
import numpy as np

import sideray.mujoco


class VectorEnv:
    """`num_envs` states that are simulated with random controls."""

    def __init__(self, model, num_envs, width, height, camera=-1, **options):
        self.model, self.num_envs, self.camera = model, num_envs, camera
        self.states = [mujoco.MjData(model) for _ in range(num_envs)]
        self.renderer = sideray.mujoco.Renderer(model, height, width, batch=num_envs, **options)

    def reset(self, seed=0):
        """Observations, and an empty info."""
        random = np.random.default_rng(seed)
        for state in self.states:
            mujoco.mj_resetData(self.model, state)
            state.qvel[:] = random.normal(0.0, 0.02, self.model.nv)
            mujoco.mj_forward(self.model, state)
        return self.observe(), {}

    def step(self, actions):
        """Observations, rewards, what has ended, what was cut off, and an empty info."""
        for state, action in zip(self.states, actions):
            state.ctrl[:] = action
            mujoco.mj_step(self.model, state)
        nothing = np.zeros(self.num_envs)
        return self.observe(), nothing, nothing.astype(bool), nothing.astype(bool), {}

    def observe(self):
        """{"rgb": (N, H, W, 3) uint8, "depth": (N, H, W) float32, "segmentation": (N, H, W, 2) int32}."""
        self.renderer.update_scene(self.states, self.camera)
        return self.renderer.render_channels()

    def close(self):
        self.renderer.close()


def one_by_one(model, states, width, height, camera):
    """Pictures a second of mujoco.Renderer, of the same channels of the same states."""
    with mujoco.Renderer(model, height, width) as renderer:
        begin = time.perf_counter()
        for state in states:
            renderer.update_scene(state, camera)
            renderer.render()
            renderer.enable_depth_rendering()
            renderer.render()
            renderer.disable_depth_rendering()
            renderer.enable_segmentation_rendering()
            renderer.render()
            renderer.disable_segmentation_rendering()
        return len(states) / (time.perf_counter() - begin)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("model", nargs="?", default=str(pathlib.Path(__file__).with_name("glassware.xml")))
    parser.add_argument("--envs", type=int, default=64)
    parser.add_argument("--size", default="84x84")
    parser.add_argument("--steps", type=int, default=20)
    given = parser.parse_args()
    width, height = map(int, given.size.split("x"))
    model = mujoco.MjModel.from_xml_path(given.model)
    camera = 0 if model.ncam else -1
    env = VectorEnv(model, given.envs, width, height, camera)
    env.reset()
    random = np.random.default_rng(1)
    ours, theirs = [], []
    for _ in range(given.steps):
        actions = random.uniform(-0.1, 0.1, (given.envs, model.nu))
        begin = time.perf_counter()
        observations, *_ = env.step(actions)
        ours.append(given.envs / (time.perf_counter() - begin))
        try:
            theirs.append(one_by_one(model, env.states, width, height, camera))
        except Exception as error:  # there is no OpenGL here
            print(f"mujoco.Renderer draws nothing here: {error}")
            break
    env.close()
    for name, value in observations.items():
        print(f"{name}: {value.shape} {value.dtype}")
    print(f"sideray.mujoco, batch={given.envs}: {np.median(ours):.0f} environments a second, simulated and drawn")
    if theirs:
        print(f"mujoco.Renderer, one by one: {np.median(theirs):.0f} environments a second, drawn")


if __name__ == "__main__":
    main()
