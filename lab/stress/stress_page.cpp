#include "lab/stress/stress_page.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

#include "lab/page/page_pictures.h"

namespace sideray::lab {
namespace {

using Names = std::vector<std::string>;

void add_once(Names& names, const std::string& name) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

// Lists the variants, parameters and measures of the rows, each once, in the order of the rows.
struct Axes {
  Names variants, parameters, measures;
};

Axes axes_of(std::span<const StressRow> rows) {
  Axes axes;
  for (const StressRow& row : rows) {
    add_once(axes.variants, row.variant);
    add_once(axes.parameters, describe_parameters(row, rows));
    add_once(axes.measures, row.measure);
  }
  return axes;
}

size_t index_in(const Names& names, const std::string& name) {
  return static_cast<size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

std::string text_of(const Json& value) {
  return value.is_string()         ? value.get<std::string>()
         : value.is_number_float() ? fmt::format("{:.4g}", value.get<double>())
                                   : value.dump();
}

std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '&')
      safe += "&amp;";
    else if (c == '<')
      safe += "&lt;";
    else
      safe += c;
  }
  return safe;
}

bool is_default(std::span<const StressRow> rows, const std::string& variant) {
  return std::any_of(rows.begin(), rows.end(),
                     [&](const StressRow& row) { return row.variant == variant && row.is_default; });
}

std::string named(std::span<const StressRow> rows, const std::string& variant) {
  const std::string text = escaped(variant);
  return is_default(rows, variant) ? fmt::format("<b>{}</b> (default)", text) : text;
}

std::string cell(const StressRow* row) {
  if (!row) return "<td></td>";
  return fmt::format("<td class=\"{}\">{:.3g}</td>", row->pass() ? "pass" : "fail", row->value);
}

// Returns the table of one measure. Bounds may differ along a row of it: the largest is shown.
std::string measure_table(std::span<const StressRow> rows, const Axes& axes, const std::string& measure) {
  double bound = 0;
  for (const StressRow& row : rows)
    if (row.measure == measure) bound = std::max(bound, row.bound);
  std::string html =
      fmt::format("<table><caption>{}; passes up to {:.3g}</caption><tr><th></th>", escaped(measure), bound);
  for (const std::string& parameters : axes.parameters) html += fmt::format("<th>{}</th>", escaped(parameters));
  html += "</tr>\n";
  for (const std::string& variant : axes.variants) {
    std::string cells;
    bool any = false;
    for (const std::string& parameters : axes.parameters) {
      const auto at = std::find_if(rows.begin(), rows.end(), [&](const StressRow& row) {
        return row.measure == measure && row.variant == variant && describe_parameters(row, rows) == parameters;
      });
      any = any || at != rows.end();
      cells += cell(at == rows.end() ? nullptr : &*at);
    }
    if (any) html += fmt::format("<tr><th class=\"variant\">{}</th>{}</tr>\n", named(rows, variant), cells);
  }
  return html + "</table>\n";
}

std::string verdict(const std::vector<StressRow>& rows) {
  const std::vector<const StressRow*> failing = failing_defaults(rows);
  const auto defaults = std::count_if(rows.begin(), rows.end(), [](const StressRow& row) { return row.is_default; });
  if (failing.empty()) return fmt::format("<p class=\"verdict\">Defaults pass all of their {} rows.</p>\n", defaults);
  std::string html =
      fmt::format("<p class=\"verdict\">Defaults fail {} of their {} rows:</p>\n<ul>\n", failing.size(), defaults);
  for (const StressRow* row : failing)
    html += fmt::format("<li><a href=\"#{0}\">{0}</a>, {1}, {2}: {3} is {4:.3g}, bound {5:.3g}</li>\n", row->name,
                        escaped(row->variant), escaped(describe_parameters(*row, rows_of(row->name, rows))),
                        escaped(row->measure), row->value, row->bound);
  return html + "</ul>\n";
}

std::string map_of_case(const std::string& name, std::span<const StressRow> of_case) {
  const Sheet sheet = failure_sheet(of_case);
  if (sheet.width == 0) return "";
  return fmt::format(
      "<p>Failure map: a row a variant, a column a set of parameters, both in the order of the tables, a block of rows "
      "each measure that pixels can show; wrong pixels are red.</p>\n<img src=\"{}\" alt=\"failure map of {}\">\n",
      png_uri(sheet.rgb, sheet.width, sheet.height), name);
}

std::string summary(const std::vector<StressCase>& cases, std::span<const StressRow> rows) {
  std::string html = "<table><caption>rows that fail</caption><tr><th>case</th><th>variant</th><th>fails</th></tr>\n";
  for (const StressCase& c : cases) {
    const std::span<const StressRow> of_case = rows_of(c.name, rows);
    for (const std::string& variant : axes_of(of_case).variants) {
      size_t count = 0, failed = 0;
      for (const StressRow& row : of_case)
        if (row.variant == variant) ++count, failed += !row.pass();
      html += fmt::format(
          "<tr><td><a href=\"#{0}\">{0}</a></td><th class=\"variant\">{1}</th><td class=\"{2}\">{3} of {4}</td></tr>\n",
          c.name, named(of_case, variant), failed ? "fail" : "pass", failed, count);
    }
  }
  return html + "</table>\n";
}

constexpr const char* style =
    "body{font:14px sans-serif;margin:2em;max-width:110em}table{border-collapse:collapse;margin:1em 0}"
    "caption{text-align:left;font-style:italic;padding:.3em 0}td,th{border:1px solid #bbb;padding:.2em .5em;"
    "font-weight:normal;text-align:right}th.variant{text-align:left;white-space:nowrap}td.pass{background:#cfe8cf}"
    "td.fail{background:#f4b6ae}img{image-rendering:pixelated;border:1px solid #888;max-width:100%}"
    ".wide{overflow-x:auto}.verdict{font-weight:bold}";

constexpr uint32_t frame = 3;

void fill(Sheet& sheet, uint32_t x, uint32_t y, const std::array<uint8_t, 3>& color) {
  std::copy(color.begin(), color.end(), sheet.rgb.begin() + 3 * (size_t{y} * sheet.width + x));
}

void draw_tile(Sheet& sheet, const StressRow& row, uint32_t left, uint32_t top) {
  constexpr std::array<uint8_t, 3> right{40, 70, 50}, wrong{235, 70, 50}, passed{60, 180, 80}, failed{220, 30, 30};
  const uint32_t width = row.map.width + 2 * frame, height = row.map.height + 2 * frame;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const bool inside = x >= frame && y >= frame && x < width - frame && y < height - frame;
      const size_t pixel = inside ? size_t{y - frame} * row.map.width + (x - frame) : 0;
      fill(sheet, left + x, top + y, inside ? (row.map.wrong[pixel] ? wrong : right) : (row.pass() ? passed : failed));
    }
}

}  // namespace

std::string describe_parameters(const StressRow& row, std::span<const StressRow> of_case) {
  std::string text;
  for (const auto& parameter : row.parameters.items()) {
    const bool varies = std::any_of(of_case.begin(), of_case.end(), [&](const StressRow& other) {
      return other.parameters.value(parameter.key(), Json()) != parameter.value();
    });
    if (varies) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", parameter.key(), text_of(parameter.value()));
  }
  return text;
}

std::span<const StressRow> rows_of(const std::string& name, std::span<const StressRow> rows) {
  const auto is_of_case = [&](const StressRow& row) { return row.name == name; };
  const auto first = std::find_if(rows.begin(), rows.end(), is_of_case);
  const auto last = std::find_if_not(first, rows.end(), is_of_case);
  return rows.subspan(static_cast<size_t>(first - rows.begin()), static_cast<size_t>(last - first));
}

Sheet failure_sheet(std::span<const StressRow> of_case) {
  std::vector<const StressRow*> mapped;
  for (const StressRow& row : of_case)
    if (row.map.width > 0) mapped.push_back(&row);
  if (mapped.empty()) return {};
  const Axes axes = axes_of(of_case);
  // A case may have maps of several measures: each has one block of rows.
  Names measures;
  for (const StressRow* row : mapped) add_once(measures, row->measure);
  const uint32_t tile_width = mapped[0]->map.width + 2 * frame + 1, tile_height = mapped[0]->map.height + 2 * frame + 1;
  const size_t rows = measures.size() * axes.variants.size();
  Sheet sheet{
      tile_width * static_cast<uint32_t>(axes.parameters.size()), tile_height * static_cast<uint32_t>(rows), {}};
  sheet.rgb.assign(size_t{3} * sheet.width * sheet.height, 255);
  for (const StressRow* row : mapped) {
    const size_t column = index_in(axes.parameters, describe_parameters(*row, of_case));
    const size_t line = index_in(measures, row->measure) * axes.variants.size() + index_in(axes.variants, row->variant);
    draw_tile(sheet, *row, tile_width * static_cast<uint32_t>(column), tile_height * static_cast<uint32_t>(line));
  }
  return sheet;
}

std::string stress_page(const std::vector<StressCase>& cases, const std::vector<StressRow>& rows,
                        const std::string& device) {
  std::string html = fmt::format(
      "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>sideray stress</title><style>{}</style>\n"
      "<h1>sideray stress</h1>\n<p>Where methods fail, against closed forms and exact oracles. Green passes, red "
      "fails. "
      "Measured on {}.</p>\n",
      style, escaped(device));
  html += verdict(rows) + summary(cases, rows);
  for (const StressCase& c : cases) {
    const std::span<const StressRow> of_case = rows_of(c.name, rows);
    if (of_case.empty()) continue;
    const Axes axes = axes_of(of_case);
    html += fmt::format("<h2 id=\"{0}\">{0}</h2>\n<p>{1}.</p>\n<div class=\"wide\">\n", c.name, escaped(c.question));
    for (const std::string& measure : axes.measures) html += measure_table(of_case, axes, measure);
    html += map_of_case(c.name, of_case) + "</div>\n";
  }
  return html + "</html>\n";
}

}  // namespace sideray::lab
