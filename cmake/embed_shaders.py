"""embed_shaders.py OUT.cpp FILE...: writes the files' text as C++ string literals, looked up by file name."""
import os
import sys

out, files = sys.argv[1], sorted(sys.argv[2:], key=os.path.basename)
lines = ['#include "shaders/sources.h"', "", "namespace sideray::shaders {", "namespace {", "",
         "struct Source {", "  std::string_view name, text;", "};", "", "constexpr Source sources[] = {"]
for path in files:
    lines.append('    {"%s",' % os.path.basename(path))
    with open(path, encoding="utf-8") as stream:
        for line in stream:
            escaped = line.rstrip("\n").replace("\\", "\\\\").replace('"', '\\"')
            lines.append('     "%s\\n"' % escaped)
    lines.append("    },")
lines += ["};", "", "}  // namespace", "", "std::string_view source(std::string_view name) {",
          "  for (const Source& s : sources)", "    if (s.name == name) return s.text;", "  return {};", "}", "",
          "}  // namespace sideray::shaders", ""]
with open(out, "w", encoding="utf-8") as stream:
    stream.write("\n".join(lines))
