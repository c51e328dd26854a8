"""embed_text.py OUT.cpp HEADER NAMESPACE FILE...: the files' text as C++ string literals, looked up by file name through
NAMESPACE::source, which HEADER declares."""
import os
import sys

out, header, namespace = sys.argv[1:4]
files = sorted(sys.argv[4:], key=os.path.basename)
lines = ['#include "%s"' % header, "", "namespace %s {" % namespace, "namespace {", "",
         "struct Source {", "  std::string_view name, text;", "};", "", "constexpr Source sources[] = {"]
for path in files:
    lines.append('    {"%s",' % os.path.basename(path))
    with open(path, encoding="utf-8") as stream:
        for line in stream:
            escaped = line.rstrip("\n").replace("\\", "\\\\").replace('"', '\\"').replace("??", "?\\?")
            lines.append('     "%s\\n"' % escaped)
    lines.append("    },")
lines += ["};", "", "}  // namespace", "", "std::string_view source(std::string_view name) {",
          "  for (const Source& s : sources)", "    if (s.name == name) return s.text;", "  return {};", "}", "",
          "}  // namespace %s" % namespace, ""]
text = "\n".join(lines)
# What stays the same is not compiled again: another interpreter, as of each wheel, runs this anew.
if not os.path.exists(out) or open(out, encoding="utf-8").read() != text:
    with open(out, "w", encoding="utf-8") as stream:
        stream.write(text)
