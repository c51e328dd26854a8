#include "cli/chart/chart_page.h"

#include <sys/utsname.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <fstream>
#include <thread>

#include <fmt/format.h>
#include "lab/page/pages.h"
#include "lab/page/page_pictures.h"

namespace sideray::cli {
namespace {

using lab::Json;

std::string quoted(const std::string& text) {
  static constexpr const char* plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=:,./@%";
  if (!text.empty() && text.find_first_not_of(plain) == std::string::npos) return text;
  std::string result = "'";
  for (char c : text) {
    if (c == '\'')
      result += "'\\''";
    else
      result += c;
  }
  result += '\'';
  return result;
}

// Returns the command as it is typed into a shell.
std::string command_line(const std::string& command, const std::string& scene, const Table& table,
                         const Given& given) {
  std::string line = "sideray " + command + " " + quoted(scene), diagnostics;
  for (const sideray_option* option : table) {
    const auto at = given.find(option->name);
    if (at == given.end()) continue;
    const bool is_flag = option->type == SIDERAY_OPTION_FLAG;
    if (is_flag && at->second != "true") continue;
    if (option->diagnostic) {
      diagnostics += fmt::format("{}{}={}", diagnostics.empty() ? " --diagnose " : ",", option->name, at->second);
      continue;
    }
    line += " " + dashed(option->name);
    if (!is_flag) line.append(" ").append(quoted(at->second));
  }
  return line + diagnostics;
}

// Describes the machine that writes the page; each row says where it was drawn.
Json machine() {
  Json json = Json::object();
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name") && line.find(": ") != std::string::npos) {
      json["processor"] = line.substr(line.find(": ") + 2);
      break;
    }
  json["cores"] = std::max(1u, std::thread::hardware_concurrency());
  if (utsname name; uname(&name) == 0)
    json["system"] = fmt::format("{} {} {}", name.sysname, name.release, name.machine);
  return json;
}

std::string program() {
  int major = 0, minor = 0, patch = 0;
  sideray_version(&major, &minor, &patch);
  return fmt::format("sideray {}.{}.{}", major, minor, patch);
}

Json larger_is_better() {
  Json names = Json::array();
  for (const std::string& name : lab::metric_names())
    if (lab::larger_is_better(name)) names.push_back(name);
  return names;
}

}  // namespace

std::string chart_page(const ChartOptions& options, const ChartFolder& folder, const std::vector<PagePoint>& points,
                       const Json& results, const Json& ledger) {
  const lab::Display display = resolve_reference(options, folder.path(folder.reference_output())).display;
  const scenes::Image reference = scenes::read_image(folder.path(folder.reference_image()));
  // Every point has a picture and a map.
  const lab::PageScale scale = lab::page_scale(reference.width, reference.height, 2 * points.size() + 1);
  Json data = {{"results", results},
               {"metric", options.metric},
               {"larger_is_better", larger_is_better()},
               {"command", command_line("chart", options.scene, chart_table(), options.given)},
               {"program", program()},
               {"machine", machine()}};
  data["scale"] = {{"width", scale.width},
                   {"height", scale.height},
                   {"of", {reference.width, reference.height}},
                   {"is_exact", scale.is_exact}};
  data["reference"] = lab::page_picture(reference, display, scale);
  data["points"] = Json::array();
  for (size_t i = 0; i < points.size(); ++i) {
    const scenes::Image image = scenes::read_image(folder.path(ChartFolder::image(i)));
    lab::PagePicture page = lab::page_picture(image, reference, display, scale);
    const RenderOptions& drawn = *points[i].options;
    Json point = {{"label", points[i].label},
                  {"command", command_line("render", drawn.scene, render_table(), drawn.given)},
                  {"picture", std::move(page.picture)}};
    if (page.map) point["map"] = std::move(*page.map);
    data["points"].push_back(std::move(point));
  }
  if (!ledger.is_null()) data["ledger"] = ledger;
  return lab::chart_page(data);
}

}  // namespace sideray::cli
