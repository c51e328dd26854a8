"""pages_test.py SOURCE_FOLDER PROGRAM [PAGE...]: what the pages name is there. PROGRAM is build/sideray.

  blocks     blocks of code end
  links      relative links lead to files, and their anchors to headings
  files      paths in code, such as `rt/base/lanes.h` or `bridge/plan/frame_plan`, are those of the sources
  functions  `name()` and `Class::name()` are in the sources
  symbols    sideray_* and SIDERAY_* are in the sources
  options    `--name` is an option of the program, or of a script, example or test; pages about older versions may name
             removed options
  commands   `sideray ...` is parsed by the program, which then misses its scene
  tests      a suite in --gtest_filter is one of tests/
  python     blocks compile
  version    CITATION.cff, CHANGELOG.md and examples have the version of include/sideray/base.h
"""

import json
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

PAGES = ("*.md", "docs/*.md", "docs/adr/*.md", "examples/**/*.md", "python/*.md", "tests/**/*.md")
HISTORICAL = ("docs/adr/", "docs/migrating.md", "CHANGELOG.md")
FOLDERS = "bridge|cli|cmake|docs|elementary|examples|gl|include|lab|library|model|python|rt|scenes|script|shaders|tests|viewer"
FENCE = re.compile(r"^( *)```(\S*)[^\n]*\n(.*?)^ *```$", re.MULTILINE | re.DOTALL)
SPAN = re.compile(r"(?<!`)`([^`\n]+)`(?!`)")
LINK = re.compile(r"\]\(([^()\s]+)\)")
PATH = re.compile(rf"(?:{FOLDERS})/[\w./*+-]+")
OPTION = re.compile(r"(?<![\w-])--([a-z][a-z0-9-]+)")
# Options of programs that are not ours.
FOREIGN = "--gtest_filter --benchmark_repetitions --dependency --wrap --constraint --exclusive --preset --build --install --target"
# What stands for something else in a command: SCENE, FILE.glb, DIR/x, N, ..., [OPTIONS], a|b.
PLACEHOLDER = re.compile(r"\.\.\.|[\[|<>$]|(?<![\w-])[A-Z]{1,12}(?![\w-])")
STAND_INS = {"SCENE": "scene.glb", "IMAGE": "x.png", "DIR": "d", "FILE": "sweep.json"}
# Commands that read a scene: one that does not exist ends them before anything is drawn.
WITH_SCENE = ("render", "bench", "chart", "plan", "view", "info")


class Page:
    def __init__(self, root, path):
        self.path, self.name = path, str(path.relative_to(root))
        self.text = path.read_text(encoding="utf-8")
        self.blocks = [(m[2], m[3]) for m in FENCE.finditer(self.text)]
        self.prose = FENCE.sub("", self.text)
        self.spans = [span.replace("\\|", "|") for span in SPAN.findall(self.prose)]

    def headings(self):
        """Anchors as GitHub makes them."""
        seen, anchors = {}, set()
        for title in re.findall(r"^#{1,6} +(.+?) *$", self.prose, re.MULTILINE):
            title = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", title)
            anchor = re.sub(r"[^\w\- ]", "", title.lower().strip()).replace(" ", "-")
            number = seen[anchor] = seen.get(anchor, -1) + 1
            anchors.add(f"{anchor}-{number}" if number else anchor)
        return anchors


def link_faults(page, pages):
    for target in LINK.findall(SPAN.sub("", page.prose)):
        if re.match(r"[a-z]+:", target):
            continue
        file, _, anchor = target.partition("#")
        path = (page.path.parent / file).resolve() if file else page.path
        if not path.exists():
            yield f"({target}): there is no {file}"
        elif anchor and path in pages and anchor not in pages[path].headings():
            yield f"({target}): {pages[path].name} has no such heading"


def fence_faults(page):
    """An unclosed block would hide all links and code after it."""
    inside = False
    for number, line in enumerate(page.text.splitlines(), 1):
        if line.lstrip().startswith("```"):
            if inside and line.strip() != "```":
                yield f"line {number}: text behind the end of a block"
            inside = not inside
    if inside:
        yield "a block of code has no end"


def file_faults(page, root):
    if page.name.startswith(HISTORICAL):
        return  # files come and go
    for span in page.spans:
        if not PATH.fullmatch(span) or span.startswith("examples/") and not (root / "examples").exists():
            continue
        path = span.rstrip("/.")
        # A unit may be named without its ending, and a target that the build makes by its source.
        if not any(root.glob(path)) and not any(root.glob(path + ".*")):
            yield f"`{span}`: there is no such file"


def function_faults(page, sources):
    """Functions that are named as `Class::name()` or `name()`."""
    if page.name.startswith(HISTORICAL):
        return
    for span in page.spans:
        if re.fullmatch(r"[\w:.]+\(\)", span) and not re.search(rf"\b{re.split(r'[:.]+', span[:-2])[-1]}\b", sources):
            yield f"`{span}`: there is no such function"


def symbol_faults(page, words):
    """Names of the interface, of the snippet and of environment variables."""
    if page.name.startswith(HISTORICAL):
        return
    code = page.spans + [block for _, block in page.blocks]
    for name in sorted({name for text in code for name in re.findall(r"\b(?:sideray|SIDERAY)_[A-Za-z0-9_]+", text)}):
        if name not in words and "NAME" not in name and not (name.endswith("_") and any(w.startswith(name) for w in words)):
            yield f"`{name}`: there is no such name"


def option_faults(page, known, elsewhere, removed):
    texts = page.spans + [line for language, block in page.blocks if language in ("", "sh") for line in block.splitlines()]
    for text in texts:
        for name in OPTION.findall(text):
            gone_before = page.name.startswith(HISTORICAL) and name in removed
            if name not in known and f"--{name}" not in elsewhere and not gone_before:
                yield f"`{text.strip()}`: no program has --{name}"


def commands_of(page):
    """Command lines `sideray ...` of the page as lists of words, but for those with placeholders."""
    texts = [line for language, block in page.blocks if language in ("", "sh") for line in block.splitlines()]
    for text in page.spans + texts:
        line = re.sub(r"\s+#.*$", "", text.strip()).removeprefix("build/")
        for word, instead in STAND_INS.items():
            line = re.sub(rf"(?<![\w-]){word}(?![\w.-])", instead, line)
        if line.startswith(tuple(f"{command} " for command in WITH_SCENE)):
            line = f"sideray {line}"
        if not line.startswith("sideray ") or PLACEHOLDER.search(line):
            continue
        words = shlex.split(line)[1:]
        if len(words) > 1:
            yield text.strip(), words


def run_dry(program, words, scenes):
    """The usage fault of a command, or ""."""
    command, arguments = words[0], words[1:]
    if command not in WITH_SCENE:
        return ""
    with tempfile.TemporaryDirectory() as folder:
        where = [i for i, word in enumerate(arguments)
                 if word.endswith((".glb", ".gltf")) or word.partition("?")[0] in scenes]
        if "--jobs" in arguments or not where:
            return ""
        arguments[where[0]] = f"{folder}/none.glb"
        for i, word in enumerate(arguments):
            if word.endswith(".json") and arguments[i - 1] == "--sweep":
                arguments[i] = f"{folder}/sweep.json"
                pathlib.Path(arguments[i]).write_text("[{}]")
        for i, word in enumerate(arguments[:-1]):
            if word in ("-o", "--stats", "--json", "--truth") and i + 1 not in where:
                arguments[i + 1] = f"{folder}/{pathlib.PurePath(arguments[i + 1]).name}"
        if command in ("render", "chart") and "-o" not in arguments:
            arguments += ["-o", f"{folder}/x.png" if command == "render" else f"{folder}/x"]
        run = subprocess.run([program, command, *arguments], capture_output=True, text=True, timeout=60)
    text = (run.stderr + run.stdout).strip()
    return "" if "none.glb" in text and "extra" not in text else text.splitlines()[0] if text else f"exit code {run.returncode}"


def test_faults(page, tests):
    for names in re.findall(r"--gtest_filter='?([^'`\s]+)", page.text):
        for name in re.split(r"[:-]", names):
            suite = name.split(".")[0].strip("*")
            if suite and suite not in tests:
                yield f"--gtest_filter={name}: tests/ has no such suite"


def python_faults(page):
    for language, block in page.blocks:
        if language == "python":
            try:
                compile(block, page.name, "exec")
            except SyntaxError as fault:
                yield f"python: {fault}"


def version_faults(root):
    """The version is in base.h, and repeated in files that are read without it."""
    header = (root / "include/sideray/base.h").read_text()
    major, minor, patch = (re.search(rf"SIDERAY_VERSION_{part} (\d+)", header)[1] for part in ("MAJOR", "MINOR", "PATCH"))
    repeats = {"CITATION.cff": (r"^version: (\S+)", f"{major}.{minor}.{patch}"), "CHANGELOG.md": (r"^## (\S+)", f"{major}.{minor}.{patch}"),
               "examples/python/offscreen.py": (r"libsideray\.so\.([\d.]+)", f"{major}.{minor}")}
    for name, (pattern, expected) in repeats.items():
        found = re.search(pattern, (root / name).read_text(), re.MULTILINE)
        if not found or found[1] != expected:
            yield f"{name}: {found[1] if found else 'no version'}, include/sideray/base.h has {expected}"


def text_below(root, *folders):
    endings = {"", ".py", ".cpp", ".c", ".h", ".hpp", ".glsl", ".frag", ".vert", ".sh", ".yaml", ".sbatch"}
    files = (file for folder in folders for file in sorted((root / folder).rglob("*")) if file.is_file() and file.suffix in endings)
    return "\n".join(file.read_text(encoding="utf-8", errors="replace") for file in files)


def main():
    root, program = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2]
    paths = sorted({path.resolve() for pattern in PAGES for path in root.glob(pattern)})
    pages = {path: Page(root, path) for path in paths}
    commands = json.loads(subprocess.run([program, "options", "--json"], check=True, stdout=subprocess.PIPE).stdout)
    listed = subprocess.run([program, "make", "--list"], check=True, stdout=subprocess.PIPE, text=True).stdout
    scenes = set(re.findall(r"^(\w+)", listed, re.MULTILINE))
    known = {option["name"] for options in commands.values() for option in options}
    # Of every command, or of one without a table.
    known |= {"help", "help-all", "version", "json", "list", "set", "diagnose", "jobs", "quick"}
    run = subprocess.run([program, "run", "--help"], check=True, stdout=subprocess.PIPE, text=True).stdout
    known |= set(re.findall(r"--([a-z-]+)", run))
    elsewhere = text_below(root, "script", "examples", "tests/viewer", "tests/cluster", "viewer") + FOREIGN
    removed = (root / "bridge/options/removed_options.cpp").read_text() + text_below(root, "cli")
    tests, sources = text_below(root, "tests"), text_below(root, *FOLDERS.split("|"))
    names = set(re.findall(r"\w+", sources + (root / "CMakeLists.txt").read_text()))
    faults, run = list(version_faults(root)), 0
    chosen = [p for p in pages.values() if p.name in sys.argv[3:]] or pages.values()
    for page in chosen:
        found = [*fence_faults(page), *link_faults(page, pages), *file_faults(page, root), *function_faults(page, sources), *symbol_faults(page, names),
                 *option_faults(page, known, elsewhere, removed),
                 *test_faults(page, tests), *python_faults(page)]
        for text, words in commands_of(page):
            fault = run_dry(program, words, scenes)
            found += [f"`{text}`: {fault}"] if fault else []
            run += 1
        faults += [f"{page.name}: {fault}" for fault in found]
    if faults:
        sys.exit("\n".join(faults))
    print(f"{len(pages)} pages, {run} commands")


if __name__ == "__main__":
    main()
