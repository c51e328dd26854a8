"""snippets_test.py SOURCE_FOLDER CC CXX: compiles the code of the documents.

Every block that is marked `c` or `cpp` is compiled as C99 or as C++20, behind prelude.h: in a function of its own, or at
file scope where it begins with "static" or "#include". Blocks of other versions are marked, as in "c 0.1", and left out.
"""

import pathlib
import re
import subprocess
import sys
import tempfile

PAGES = ("README.md", "docs/embedding.md", "docs/fixed-function.md", "docs/migrating-0.2.md")
LANGUAGES = {"c": ["-std=c99", "-xc"], "cpp": ["-std=c++20", "-xc++"]}
WARNINGS = ["-Wall", "-Wextra", "-Werror", "-Wno-unused-variable", "-Wno-unused-but-set-variable", "-Wno-unused-function"]
BLOCK = re.compile(r"^( *)```(c|cpp)\n(.*?)^ *```$", re.MULTILINE | re.DOTALL)


def unit_of(page, text, language, prelude):
    """One translation unit of all blocks of a language, with the page's own line numbers; "" where there are none."""
    parts = []
    for number, block in enumerate(BLOCK.finditer(text)):
        if block[2] != language:
            continue
        line = text.count("\n", 0, block.start(3)) + 1
        body = f'#line {line} "{page}"\n{block[3]}'
        at_file_scope = block[3].lstrip().startswith(("static", "#include"))
        parts.append(body if at_file_scope else f"void snippet_{number}(void);\nvoid snippet_{number}(void) {{\n{body}}}\n")
    return f'#include "{prelude}"\n' + "".join(parts) if parts else ""


def main():
    source, compilers = pathlib.Path(sys.argv[1]).resolve(), {"c": sys.argv[2], "cpp": sys.argv[3]}
    prelude = source / "tests/docs/prelude.h"
    compiled = 0
    for page in PAGES:
        text = (source / page).read_text()
        for language, flags in LANGUAGES.items():
            unit = unit_of(page, text, language, prelude)
            if not unit:
                continue
            with tempfile.NamedTemporaryFile("w", suffix=f".{language}") as file:
                file.write(unit)
                file.flush()
                command = [compilers[language], *flags, *WARNINGS, "-fsyntax-only", f"-I{source / 'include'}", file.name]
                if subprocess.run(command).returncode != 0:
                    sys.exit(f"{page}: its {language} code does not compile")
            compiled += 1
    if compiled < 4:
        sys.exit(f"only {compiled} units of code found: the documents' marks have changed")
    print(f"{compiled} units of code compile")


if __name__ == "__main__":
    main()
