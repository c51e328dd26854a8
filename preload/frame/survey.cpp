#include "preload/frame/survey.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>

#include "preload/base/hash.h"
#include "preload/base/png.h"

namespace sideray::run {
namespace {

constexpr int thumbnail_side = 48;

std::string described(Taking taking, const Rule& rule) {
  switch (taking) {
    case Taking::opaque:
      return "opaque";
    case Taking::sky:
      return "sky";
    case Taking::reflects:
      return kind_name(rule.kind) + std::string(rule.guessed ? " (guessed)" : "");
    case Taking::held:
      return "held back, drawn as ever";
    default:
      return rule.kind == Kind::ignore ? "ignored" : "left alone";
  }
}

// Returns the memory that the process uses.
double memory_mb() {
  std::ifstream file("/proc/self/statm");
  double size = 0, resident = 0;
  file >> size >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / 1e6;
}

double median(std::vector<float> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return static_cast<double>(*middle);
}

std::string text(const char* format, double value) {
  char buffer[64];
  std::snprintf(buffer, sizeof(buffer), format, value);
  return buffer;
}

}  // namespace

void Survey::count(Entry& entry, uint64_t frame, const DrawState& state, const std::string& taken) {
  ++entry.draws;
  if (entry.last_frame != frame) ++entry.frames;
  entry.last_frame = frame;
  if (state.blend) ++entry.blended;
  if (state.lighting) ++entry.lit;
  entry.taken.insert(taken);
}

Survey::Thumbnail Survey::thumbnail(const Texture& texture) {
  Thumbnail small;
  small.width = std::min(texture.width, thumbnail_side);
  small.height = std::min(texture.height, thumbnail_side);
  for (int y = small.height - 1; y >= 0; --y)
    for (int x = 0; x < small.width; ++x) {
      const auto from_x = static_cast<size_t>(x * texture.width / small.width), from_y = static_cast<size_t>(y * texture.height / small.height);
      const uint8_t* texel = &texture.texels[4 * (from_y * static_cast<size_t>(texture.width) + from_x)];
      small.rgba.insert(small.rgba.end(), texel, texel + 4);
    }
  return small;
}

void Survey::note(const Texture& texture, uint64_t mesh, const DrawState& state, Taking taking, const Rule& rule) {
  const std::string taken = described(taking, rule);
  if (texture.hash != 0) {
    count(textures_[texture.hash], frame_, state, taken);
    if (!texture.texels.empty() && !pictures_.contains(texture.hash)) pictures_[texture.hash] = thumbnail(texture);
  } else {
    count(textures_[0], frame_, state, taken);
  }
  if (mesh != 0) count(meshes_[mesh], frame_, state, taken);
}

void Survey::end_frame(const Frame& frame) {
  if (frame.frame_ms > 0) frame_ms_.push_back(static_cast<float>(frame.frame_ms));
  if (frame_ == 100 || frame_ == 1000) memory_mb_[frame_ == 1000] = memory_mb();
  ++frame_;
  total_.rays += frame.rays;
  total_.layers += frame.layers;
  total_.held += frame.held;
  total_.batches += frame.batches;
  total_.reflecting += frame.reflecting;
  total_.shadow_rays += frame.shadow_rays;
  if (frame.batches > 0) last_ = frame;
  if (frame.pixels == 0 || frame.reflecting + frame.in_shadow + frame.held_in_shadow == 0) return;
  const auto pixels = static_cast<double>(frame.pixels);
  const double share = static_cast<double>(frame.reflecting) / pixels;
  if (frame.reflecting > 0) ++frames_with_rays_;
  if (frame.in_shadow + frame.held_in_shadow > 0) ++frames_with_shadows_;
  ++frames_traced_;
  share_ += share;
  most_share_ = std::max(most_share_, share);
  shadow_share_ += static_cast<double>(frame.in_shadow) / pixels;
  held_shadow_share_ += static_cast<double>(frame.held_in_shadow) / pixels;
  trace_ms_ += frame.trace_ms;
}

std::string Survey::figures() const {
  const auto mean = [](double sum, uint64_t frames) { return sum / std::max<double>(1, static_cast<double>(frames)); };
  const std::pair<const char*, std::string> rows[] = {
      {"frames", std::to_string(frame_ - 1)},
      {"frames_with_rays", std::to_string(frames_with_rays_)},
      {"fragments_by_rays", std::to_string(total_.reflecting)},
      {"mean_share_of_pixels", text("%.4f", mean(share_, frames_with_rays_))},
      {"largest_share_of_pixels", text("%.4f", most_share_)},
      {"frames_with_shadows", std::to_string(frames_with_shadows_)},
      {"mean_share_in_shadow", text("%.4f", mean(shadow_share_, frames_with_shadows_))},
      {"mean_share_of_held_in_shadow", text("%.4f", mean(held_shadow_share_, frames_with_shadows_))},
      {"shadow_rays", std::to_string(total_.shadow_rays)},
      {"layers_found", std::to_string(total_.layers)},
      {"reflection_rays", std::to_string(total_.rays)},
      {"draws_held", std::to_string(total_.held)},
      {"batches", std::to_string(total_.batches)},
      {"median_frame_ms", text("%.1f", median(frame_ms_))},
      {"memory_mb_at_frame_100", text("%.0f", memory_mb_[0])},
      {"memory_mb_at_frame_1000", text("%.0f", memory_mb_[1])},
      {"memory_mb", text("%.0f", memory_mb())},
      {"mean_trace_ms", text("%.2f", mean(trace_ms_, frames_traced_))},
      {"instances_of_last_traced_frame", std::to_string(last_.instances)},
      {"meshes_kept", std::to_string(last_.meshes)},
      {"textures_met", std::to_string(textures_.size() - textures_.count(0))}};
  std::string html = "<table>\n";
  for (const auto& [name, value] : rows) html += std::string("<tr><td>") + name + "</td><td>" + value + "</td></tr>\n";
  return html + "</table>\n";
}

std::string Survey::table(const std::map<uint64_t, Entry>& entries, bool with_pictures) const {
  std::vector<std::pair<uint64_t, const Entry*>> sorted;
  for (const auto& [hash, entry] : entries) sorted.emplace_back(hash, &entry);
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.second->draws > b.second->draws; });
  if (sorted.size() > 1000) sorted.resize(1000);
  std::string html = "<table><tr><th>hash</th><th></th><th>draws</th><th>frames</th><th>blended</th><th>lit</th><th>taken for</th></tr>\n";
  for (const auto& [hash, entry] : sorted) {
    std::string taken, picture;
    for (const std::string& word : entry->taken) taken += (taken.empty() ? "" : ", ") + word;
    if (const auto found = pictures_.find(hash); with_pictures && found != pictures_.end())
      picture = "<img src=\"data:image/png;base64," + base64(png(found->second.width, found->second.height, 4, found->second.rgba)) + "\">";
    html += "<tr><td><code>" + (hash == 0 ? "no texture" : hash_text(hash)) + "</code></td><td>" + picture + "</td><td>" + std::to_string(entry->draws) +
            "</td><td>" + std::to_string(entry->frames) + "</td><td>" + std::to_string(entry->blended) + "</td><td>" + std::to_string(entry->lit) +
            "</td><td>" + taken + "</td></tr>\n";
  }
  return html + "</table>\n";
}

bool Survey::write(const std::string& path, const std::string& renderer, const std::string& ended) const {
  std::string missed;
  for (const auto& [what, count] : missed_) missed += "<tr><td>" + what + "</td><td>" + std::to_string(count) + "</td></tr>\n";
  std::ofstream file(path + ".new");
  file << "<!DOCTYPE html><html><head><meta charset=\"utf-8\"><title>sideray run</title><style>body{font:14px sans-serif;margin:2em}"
          "td,th{padding:2px 10px;text-align:left;border-bottom:1px solid #ddd}img{background:#888}</style></head><body>\n"
       << "<h1>What sideray run met</h1>\n<p>" << renderer << "</p>\n"
       << (ended.empty() ? "" : "<p><b>Passed through: " + ended + "</b></p>\n") << figures() << "<h2>Textures</h2>\n"
       << table(textures_, true) << "<h2>Meshes of lists and arrays</h2>\n" << table(meshes_, false) << "<h2>Missed</h2>\n<table>" << missed
       << "</table></body></html>\n";
  file.close();
  return file && std::rename((path + ".new").c_str(), path.c_str()) == 0;
}

}  // namespace sideray::run
