"""A sequence on Ray (PyPI), on machines that share the folder: on_ray.py 16 render scene.glb --frames 0-999 -o out/f.####.exr"""
import os, subprocess, sys
import ray

@ray.remote(num_cpus=1, max_retries=3)
def task(index, count, arguments):
    shard = {"JOB_COMPLETION_INDEX": str(index), "JOB_COMPLETION_COUNT": str(count)}
    return subprocess.run([*arguments, "--shard", "auto"], env=os.environ | shard, cwd=folder).returncode

count, arguments, folder = int(sys.argv[1]), [os.environ.get("SIDERAY", "sideray"), *sys.argv[2:]], os.getcwd()
sys.exit(max(ray.get([task.remote(index, count, arguments) for index in range(count)])))
