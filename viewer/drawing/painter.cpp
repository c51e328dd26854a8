#include "viewer/drawing/painter.h"

#include <chrono>

#include "scenes/base/files.h"
#include "scenes/images/images.h"
#include "viewer/drawing/modes.h"

namespace sideray::viewer {
namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// Halton's sequence: places in 0..1.
float halton(uint32_t index, uint32_t base) {
  float result = 0, digit = 1;
  for (uint32_t rest = index; rest > 0; rest /= base) {
    digit /= static_cast<float>(base);
    result += digit * static_cast<float>(rest % base);
  }
  return result;
}

// The same view through another place of each pixel.
sideray_camera moved_within_pixel(sideray_camera camera, uint32_t position, const Effort& effort) {
  camera.shift_x += (halton(position + 1, 2) - 0.5f) / static_cast<float>(effort.width);
  camera.shift_y += (halton(position + 1, 3) - 0.5f) / static_cast<float>(effort.height);
  return camera;
}

// Distances are what the mouse takes hold of, and numbers of objects what it points at.
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
  // A draft has not all that a channel may be of.
  const Mode& mode = modes()[view.mode];
  if (effort.is_draft && (mode.aov == 0 || !mode.is_lit)) {
    prefer("quality", "draft");
    prefer("refraction", "on");  // glass that bends light looks like another thing without
  }
  if (effort.budget_ms > 0) prefer("budget", std::to_string(effort.budget_ms));
  // A view that stands still is drawn whole, in as many frames as it has positions.
  if (!view.is_moving && !effort.is_preview) options.set("budget", "");
  prefer("taa", "on");
  return options;
}

scenes::Image image_of(const Picture& picture) {
  scenes::Image image{picture.width(), picture.height(), {}, true};
  const size_t pixels = size_t{image.width} * image.height;
  for (const char* name : {"R", "G", "B"}) {
    const float* values = floats_of(picture, name);
    image.planes.push_back({name, scenes::Plane::Type::single, {values, values + pixels}, {}});
  }
  return image;
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
  // Without a budget everything is traced for its picture.
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

// A renderer whose OpenGL failed, as where its context is lost, is made anew once.
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

void Painter::add(const Picture& picture, Refined& refined) const {
  const char* const names[] = {"R", "G", "B"};
  for (size_t k = 0; k < 3; ++k) {
    const float* values = floats_of(picture, names[k]);
    for (size_t i = 0; i < refined.sums[k].size(); ++i) refined.sums[k][i] += static_cast<double>(values[i]);
  }
  ++refined.positions;
}

void Painter::develop(const View& view, const scenes::Image& image, Frame& frame) const {
  frame.display = scenes::display_values(image, view.display.exposure_ev, view.display.tonemap);
  frame.rgb = scenes::quantize(frame.display);
}

std::shared_ptr<Frame> Painter::paint(const View& view, Way way, const Effort& effort) {
  const Clock::time_point start = Clock::now();
  const Mode& mode = modes()[view.mode];
  const bool refines = way == Way::reference && mode.aov == 0 && !effort.is_preview;
  const bool goes_on = refined_.number == view.number && refined_.width == effort.width && refined_.height == effort.height;
  if (refines && !goes_on) {
    refined_ = {view.number, effort.width, effort.height, 0, {}};
    for (std::vector<double>& sum : refined_.sums) sum.resize(size_t{effort.width} * effort.height);
  }
  auto frame = std::make_shared<Frame>();
  auto picture = std::make_shared<Picture>(draw_anyhow(view, way, effort, refines ? refined_.positions : 0));
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
    frame->is_done = !effort.is_preview;
  } else {
    scenes::Image image = image_of(*picture);
    if (refines) {
      add(*picture, refined_);
      for (size_t k = 0; k < 3; ++k)
        for (size_t i = 0; i < refined_.sums[k].size(); ++i)
          image.planes[k].values[i] = static_cast<float>(refined_.sums[k][i] / refined_.positions);
      frame->positions = refined_.positions;
    }
    develop(view, image, *frame);
    frame->is_done = !effort.is_preview && frame->positions >= positions_of(way);
  }
  frame->picture = std::move(picture);
  frame->ms = ms_since(start);
  return frame;
}

}  // namespace sideray::viewer
