"""join_includes.py OUT FILE: FILE with the text of the files that its lines `#include "NAME"` name, beside it."""
import pathlib
import re
import sys

out, path = map(pathlib.Path, sys.argv[1:3])
out.write_text(re.sub(r'^#include "(.+)"\n', lambda line: (path.parent / line[1]).read_text(encoding="utf-8"),
                      path.read_text(encoding="utf-8"), flags=re.MULTILINE), encoding="utf-8")
