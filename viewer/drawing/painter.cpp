#include "viewer/drawing/painter.h"

#include <algorithm>
#include <chrono>
#include <future>
#include <thread>

#include "scenes/base/files.h"
#include "scenes/images/images.h"
#include "viewer/drawing/modes.h"

namespace sideray::viewer {
namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// Returns elements of the Halton sequence, in 0..1.
float halton(uint32_t index, uint32_t base) {
  float result = 0, digit = 1;
  for (uint32_t rest = index; rest > 0; rest /= base) {
    digit /= static_cast<float>(base);
    result += digit * static_cast<float>(rest % base);
  }
  return result;
}

// Returns the camera with another position of the ray within each pixel.
sideray_camera moved_within_pixel(sideray_camera camera, uint32_t position, const Effort& effort) {
  camera.shift_x += (halton(position + 1, 2) - 0.5f) / static_cast<float>(effort.width);
  camera.shift_y += (halton(position + 1, 3) - 0.5f) / static_cast<float>(effort.height);
  return camera;
}

// The mouse needs distances to grab a surface, and object numbers to point at one.
uint32_t outputs_of(const Mode& mode) {
  return mode.aov | SIDERAY_AOV_Z | SIDERAY_AOV_ID;
}

Options options_for(const View& view, Way way, const Effort& effort) {
  Options options = options_of(way, view.options);
  options.set("size", std::to_string(effort.width) + "x" + std::to_string(effort.height));
  if (way == Way::reference) return options;
  const auto prefer = [&](const char* name, const std::string& value) {
    if (options.is_set(name)) return;
    Options trial = options;
    trial.set(name, value);
    if (sideray_options_check(trial.get(), nullptr) == SIDERAY_OK) options = std::move(trial);
  };
  // A draft lacks outputs that some channels need.
  const Mode& mode = modes()[view.mode];
  if (effort.is_draft && (mode.aov == 0 || !mode.is_lit)) {
    prefer("quality", "draft");
    prefer("refraction", "on");  // glass that bends light looks like another thing without
  }
  if (effort.budget_ms > 0) prefer("budget", std::to_string(effort.budget_ms));
  // A view at rest is drawn without a budget, one frame for each position.
  if (!view.is_moving && !effort.is_preview) options.set("budget", "");
  prefer("taa", "on");
  return options;
}

using Planes = std::array<const float*, 3>;

Planes colors_of(const Picture& picture) {
  return {floats_of(picture, "R"), floats_of(picture, "G"), floats_of(picture, "B")};
}

// Converts some rows of a picture to display values.
void develop_rows(const Planes& planes, const lab::Display& display, uint32_t first, uint32_t last, Frame& frame) {
  scenes::Image rows{frame.width, last - first, {}, true};
  const size_t begin = size_t{first} * frame.width, end = size_t{last} * frame.width;
  constexpr const char* names[] = {"R", "G", "B"};
  for (size_t k = 0; k < 3; ++k)
    rows.planes.push_back({names[k], scenes::Plane::Type::single, {planes[k] + begin, planes[k] + end}, {}});
  const std::vector<float> values = scenes::display_values(rows, display.exposure_ev, display.tonemap);
  const std::vector<uint8_t> bytes = scenes::quantize(values);
  std::copy(values.begin(), values.end(), frame.display.begin() + static_cast<std::ptrdiff_t>(3 * begin));
  std::copy(bytes.begin(), bytes.end(), frame.rgb.begin() + static_cast<std::ptrdiff_t>(3 * begin));
}

// Converts a picture to display values on all cores. Exact powers would take one core too long for a view that moves.
void develop(const Planes& planes, const lab::Display& display, Frame& frame) {
  constexpr uint32_t least_rows = 16;
  frame.display.resize(size_t{3} * frame.width * frame.height);
  frame.rgb.resize(frame.display.size());
  const uint32_t cores = std::max(1u, std::thread::hardware_concurrency());
  const uint32_t rows = std::max(least_rows, (frame.height + cores - 1) / cores);
  std::vector<std::future<void>> bands;
  for (uint32_t first = 0; first < frame.height; first += rows)
    bands.push_back(std::async(std::launch::async, [&, first] {
      develop_rows(planes, display, first, std::min(first + rows, frame.height), frame);
    }));
  for (std::future<void>& band : bands) band.get();
}

}  // namespace

Renderer& Painter::renderer_for(const View& view, Way way, bool needs_rasterizer) {
  if (scene_.lock() != view.scene) {
    for (Drawing& drawing : drawings_) drawing.renderer.reset();
    refined_ = {};
    scene_ = view.scene;
  }
  Drawing& drawing = drawings_[static_cast<size_t>(way)];
  if (!drawing.renderer || drawing.rasterizes != needs_rasterizer) {
    drawing.renderer.reset();
    drawing.renderer = machine_.renderer(needs_rasterizer);
    drawing.rasterizes = needs_rasterizer;
  }
  return *drawing.renderer;
}

Picture Painter::draw(const View& view, Way way, const Effort& effort, uint32_t position) {
  const Mode& mode = modes()[view.mode];
  const Options options = options_for(view, way, effort);
  sideray_render_options drawn = options.render();
  drawn.aovs = outputs_of(mode);
  // Without a budget every picture traces all its answers.
  if (view.inspects && drawn.budget_ms > 0 && way != Way::reference) drawn.aovs |= SIDERAY_AOV_ANSWERS;
  drawn.exposure = view.display.exposure_ev;
  const bool is_reference = way == Way::reference;
  const bool is_colored = mode.aov == 0;
  drawn.continues = (is_colored || mode.coloring == Coloring::age) && !is_reference;
  if (!is_colored) {
    drawn.taa = 0;
    drawn.without_color = !mode.is_lit && !is_reference;
  }
  if (is_reference) drawn.seed += 0x9e3779b9u * position;
  const sideray_camera camera = is_reference && is_colored ? moved_within_pixel(view.camera, position, effort) : view.camera;
  const Scene& scene = view.scene->at(view.time_s, options["ray-traced"], view.camera, effort.width, effort.height);
  return render(renderer_for(view, way, needs_rasterizer(options)), scene, camera, drawn);
}

Picture Painter::render(Renderer& renderer, const Scene& scene, const sideray_camera& camera,
                        const sideray_render_options& options) {
  const auto draws_with = [&](Renderer* now) {
    const std::lock_guard lock(mutex_);
    drawing_ = now;
  };
  draws_with(&renderer);
  Result<Picture> picture = renderer.render(scene, camera, options);
  draws_with(nullptr);
  return std::move(picture).value();
}

// Makes the renderer anew once if its OpenGL fails, for example because its context is lost.
Picture Painter::draw_anyhow(const View& view, Way way, const Effort& effort, uint32_t position) {
  try {
    return draw(view, way, effort, position);
  } catch (const Error& failure) {
    if (failure.status != SIDERAY_GL_FAILED) throw;
    drawings_[static_cast<size_t>(way)].renderer.reset();
    return draw(view, way, effort, position);
  }
}

void Painter::cancel() {
  const std::lock_guard lock(mutex_);
  if (drawing_) drawing_->cancel();
}

void Painter::refine(const Picture& picture, const View& view, const Effort& effort) {
  if (!refined_.is_of(view, effort)) refined_ = {view.number, effort.width, effort.height, 0, {}};
  const Planes planes = colors_of(picture);
  for (size_t k = 0; k < 3; ++k) {
    std::vector<double>& sum = refined_.sums[k];
    sum.resize(size_t{effort.width} * effort.height);
    for (size_t i = 0; i < sum.size(); ++i) sum[i] += static_cast<double>(planes[k][i]);
  }
  ++refined_.positions;
}

std::array<std::vector<float>, 3> Painter::refined() const {
  std::array<std::vector<float>, 3> means;
  for (size_t k = 0; k < 3; ++k)
    for (const double sum : refined_.sums[k]) means[k].push_back(static_cast<float>(sum / refined_.positions));
  return means;
}

std::shared_ptr<Frame> Painter::paint(const View& view, Way way, const Effort& effort) {
  const Clock::time_point start = Clock::now();
  const Mode& mode = modes()[view.mode];
  const bool refines = way == Way::reference && mode.aov == 0 && !effort.is_preview;
  auto frame = std::make_shared<Frame>();
  auto picture = std::make_shared<Picture>(
      draw_anyhow(view, way, effort, refines && refined_.is_of(view, effort) ? refined_.positions : 0));
  frame->number = view.number;
  frame->way = way;
  frame->width = effort.width, frame->height = effort.height;
  frame->is_preview = effort.is_preview;
  frame->stats = picture->stats();
  frame->stages = picture->stages();
  frame->positions = frame->stats.positions;
  if (mode.aov != 0) {
    frame->rgb = shown(*picture, mode);
    if (frame->rgb.empty())
      scenes::refuse("{}: this picture has none of it; choose another way of drawing, or other options", mode.name);
  } else if (refines) {
    refine(*picture, view, effort);
    const std::array<std::vector<float>, 3> means = refined();
    develop({means[0].data(), means[1].data(), means[2].data()}, view.display, *frame);
    frame->positions = refined_.positions;
  } else {
    develop(colors_of(*picture), view.display, *frame);
  }
  frame->is_done = !effort.is_preview && (mode.aov != 0 || frame->positions >= positions_of(way));
  frame->picture = std::move(picture);
  frame->ms = ms_since(start);
  return frame;
}

}  // namespace sideray::viewer
