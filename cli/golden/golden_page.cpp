#include <nlohmann/json.hpp>

#include "cli/golden/golden_folder.h"
#include "cli/golden/golden_verdict.h"
#include "lab/page/page_pictures.h"
#include "lab/page/pages.h"

namespace sideray::cli {
namespace {

using Json = nlohmann::ordered_json;

// For each picture that differs: reference, picture, map.
constexpr size_t pictures_each = 3;

Json json_of(const Verdict& verdict, size_t differing, const std::string& drawn, const std::string& references) {
  Json json = {{"name", verdict.drawn.name}, {"text", verdict.text}, {"holds", verdict.holds}};
  if (verdict.holds) return json;
  for (const lab::Change& change : verdict.differences.changes) json["changes"].push_back(lab::describe(change));
  const scenes::Image now = recorded_picture(drawn, verdict.drawn),
                      reference = recorded_picture(references, verdict.reference);
  const lab::PageScale scale = lab::page_scale(now.width, now.height, pictures_each * differing);
  lab::PagePicture page = lab::page_picture(now, reference, verdict.display, scale);
  json["now"] = std::move(page.picture);
  json["reference"] = lab::page_picture(reference, verdict.display, scale);
  if (page.map) json["map"] = std::move(*page.map);
  if (verdict.differences.flip) json["flip"] = *verdict.differences.flip;
  return json;
}

}  // namespace

std::string golden_page_text(const std::string& title, const std::string& summary, const std::vector<Verdict>& verdicts,
                             const std::string& drawn, const std::string& references) {
  size_t differing = 0;
  for (const Verdict& verdict : verdicts) differing += !verdict.holds;
  Json data = {{"title", title}, {"summary", summary}, {"pictures", Json::array()}};
  for (const Verdict& verdict : verdicts) data["pictures"].push_back(json_of(verdict, differing, drawn, references));
  return lab::golden_page(data);
}

}  // namespace sideray::cli
