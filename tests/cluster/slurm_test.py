"""slurm_test.py PROGRAM SOURCE_FOLDER: runs that a real Slurm starts, on four nodes of this machine (script/slurm).

One node dies in mid-frame, of another the disk is full, a third may not write. Exits with 77, which is skipped, where this
machine has no Slurm or may not have one.
"""
import glob
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

PROGRAM, SOURCE = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
SLURM = SOURCE / "script/slurm"
BATCH = SOURCE / "examples/cluster/sideray.sbatch"
NODES = 4
# With these options no frame depends on earlier ones: frames of plants in wind, and of a moving camera.
ALONE = "--size 96x54 --fps 30 --taa off --denoise off --cull-angle 0".split()
FOREST, BISTRO = ["forest?count=200", *ALONE], ["bistro", "--camera", "dolly", *ALONE]
LONGEST_WAIT = 300  # seconds, for a requeued task too


def say(text):
    print(f"{time.strftime('%H:%M:%S')}  {text}", flush=True)


def run(*command, expect=0):
    result = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if result.returncode != expect:
        sys.exit(f"{' '.join(map(str, command))}: {result.returncode}, not {expect}\n{result.stdout}{result.stderr}")
    return result.stdout + result.stderr


def check(is_right, what):
    if not is_right:
        sys.exit(f"slurm_test: {what}")


def wait_until(is_so, what):
    end = time.time() + LONGEST_WAIT
    while not is_so():
        check(time.time() < end, f"waited for {LONGEST_WAIT} s: {what}\n{run('squeue')}{run('sinfo')}")
        time.sleep(0.05)


def submit(*arguments, shards=None, **options):
    switches = [f"--{name.replace('_', '-')}={value}" for name, value in options.items()]
    setting = [f"SHARDS={shards}"] if shards else []
    job = run("env", *setting, "sbatch", "--parsable", *switches, BATCH, *arguments).strip()
    say(" ".join(map(str, [*setting, "sbatch", *switches, BATCH.name, *arguments])))
    return job


def wait_for(job):
    wait_until(lambda: not run("squeue", "-h", "-j", job), f"job {job}")


def status(folder, expect):
    return json.loads(run(PROGRAM, "status", folder, "--json", expect=expect))


def show(*command, expect=0):
    for line in run(*command, expect=expect).splitlines():
        say(f"  {line}")


def node_of(shard, folder):
    return json.loads((folder / f"shards/{shard:04}.json").read_text())["node"]


def pictures(folder):
    return sorted(path.name for path in folder.glob("f.*.exr"))


def check_bytes(folder, whole, count):
    check(pictures(folder) == pictures(whole) and len(pictures(whole)) == count, f"{folder}: not {count} pictures")
    for name in pictures(whole):
        check((folder / name).read_bytes() == (whole / name).read_bytes(), f"{folder / name}: other bytes than of one machine")
    left = [str(path) for path in folder.rglob("*") if ".tmp" in path.name or "lock" in path.name]
    check(not left, f"left over: {left}")
    say(f"{count} pictures with the bytes of one machine, and nothing half-written beside them")


def on_one_machine(folder, scene, frames):
    os.mkdir(folder)
    run(PROGRAM, "render", *scene, "--frames", f"0-{frames - 1}", "-o", f"{folder}/f.###.exr")
    say(f"one machine has drawn {frames} frames of {scene[0]}")
    return pathlib.Path(folder)


def one_node_dies(whole, frames):
    folder = pathlib.Path("killed")
    job = submit("render", *FOREST, "--frames", f"0-{frames - 1}", "-o", "killed/f.###.exr", array=f"0-{NODES - 1}")
    first = frames // NODES  # of shard 1
    wait_until(lambda: (folder / f"f.{first + 3:03}.exr").exists(), "the first frames of shard 1")
    node = node_of(1, folder)
    run(SLURM, "kill", "slurm", node)
    at_death = len([n for n in pictures(folder) if first <= int(n[2:5]) < 2 * first])
    check(at_death < first, "shard 1 was done before its node died")
    say(f"{node} is killed (SIGKILL to slurmd, step and task) when shard 1 has {at_death} of {first} pictures")
    show(PROGRAM, "status", folder, expect=1)
    wait_for(job)
    say(f"the array has ended; shard 1 was requeued to {node_of(1, folder)}")
    check(node_of(1, folder) != node, "shard 1 ended on the node that died")
    show(PROGRAM, "status", folder)
    show(PROGRAM, "gather", folder)
    check_bytes(folder, whole, frames)
    run(SLURM, "boot", "slurm", node)


def mount_faults(folder):
    """What n2 and n3 see: a disk that is full but for 48 KiB, and a folder that they may only read."""
    at, shards = folder.resolve(), pathlib.Path("slurm/shards").resolve()
    (folder / "shards").mkdir(parents=True)
    shards.mkdir()
    pathlib.Path("slurm/n2.mounts").write_text(
        f"mount --bind {at}/shards {shards} && mount -t tmpfs -o size=48k tmpfs {at} && mkdir {at}/shards && "
        f"mount --bind {shards} {at}/shards\n")
    pathlib.Path("slurm/n3.mounts").write_text(f"mount --bind {at} {at} && mount -o remount,bind,ro {at}\n")
    for node in ("n2", "n3"):
        run(SLURM, "kill", "slurm", node)
        run(SLURM, "boot", "slurm", node)
    for node in ("n2", "n3"):
        wait_until(lambda: "idle" in run("sinfo", "-h", "-n", node, "-o", "%T"), f"{node} comes up")
    # Slurm lists dead nodes as idle for a while, so a task runs on each.
    check("tmpfs" in run("srun", "-w", "n2", "stat", "-f", "-c", "%T", at), "n2 has no small disk")
    check("Read-only" in run("srun", "-w", "n3", "sh", "-c", f"touch {at}/x 2>&1; true"), "n3 may write")


def two_nodes_cannot_write(whole, frames):
    folder = pathlib.Path("faulty")
    mount_faults(folder)
    command = ["render", *BISTRO, "--frames", f"0-{frames - 1}", "-o", "faulty/f.###.exr"]
    job = submit(*command, array=f"0-{NODES - 1}", job_name="faulty")
    wait_for(job)
    show(PROGRAM, "status", folder, expect=1)
    logs = {path: pathlib.Path(path).read_text() for path in glob.glob("faulty-*.log")}
    check(any("No space left on device" in text for text in logs.values()), f"no task names the full disk: {logs}")
    check(any("Read-only file system" in text for text in logs.values()), f"no task names the read-only folder: {logs}")
    for path, text in sorted(logs.items()):
        for line in text.splitlines():
            say(f"  {path}: {line}")
    now = status(folder, 1)
    full = [task for task in now["tasks"] if task["state"] == "failed"]
    check(len(full) == 1 and full[0]["node"] == "n2" and "No space left" in full[0]["error"], f"not named: {now['tasks']}")
    check(len(now["missing"]) == 2 * frames // NODES, f"the other nodes did not finish: {now['missing']}")
    array = now["retry"].removeprefix("sbatch --array=")
    wait_for(submit(*command, shards=NODES, array=array, exclude="n2,n3"))
    show(PROGRAM, "gather", folder)
    check_bytes(folder, whole, frames)


def chart(nodes):
    pathlib.Path("sweep.json").write_text(json.dumps([{"translucency": "off"}] + [{"layers": n} for n in range(1, 8)]))
    wait_for(submit("chart", "panes", "--size", "48x27", "--sweep", "sweep.json", "--repeat", 1, "--light-samples", 2, "-o",
                    "chart", array=f"0-{nodes - 1}", exclude="n2,n3"))
    show(PROGRAM, "gather", "chart")
    check(len(json.loads(pathlib.Path("chart/results.json").read_text())["rows"]) == 8, "the chart has not 8 rows")
    check(pathlib.Path("chart/index.html").exists(), "the chart has no page")


def main():
    can = subprocess.run([SLURM, "check"], capture_output=True, text=True)
    if can.returncode != 0:
        print(f"skipped: {can.stderr.strip()}")
        sys.exit(77)
    os.environ.update(SIDERAY=str(PROGRAM), SLURM_CONF=os.path.abspath("slurm/slurm.conf"))
    run(SLURM, "start", "slurm", NODES)
    try:
        one_node_dies(on_one_machine("forest", FOREST, 200), 200)
        two_nodes_cannot_write(on_one_machine("bistro", BISTRO, 20), 20)
        chart(NODES)
    finally:
        run(SLURM, "stop", "slurm")
    say("passed")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory(prefix="sideray_slurm_", ignore_cleanup_errors=True) as work:
        os.chdir(work)
        main()
