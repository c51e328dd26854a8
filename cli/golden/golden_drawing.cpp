#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <map>
#include <numeric>
#include <set>

#include "cli/base/progress.h"
#include "cli/golden/golden_jobs.h"
#include "cli/render/frames.h"
#include "cli/render/render_jobs.h"
#include "cli/session/picture_files.h"
#include "cli/session/scene_objects.h"
#include "cli/session/session.h"
#include "scenes/base/files.h"

namespace sideray::cli {
namespace {

// Returns the processor's vendor: software OpenGL uses instructions for reciprocals, which differ between vendors.
std::string processor_maker() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("vendor_id") && line.find(": ") != std::string::npos) return line.substr(line.find(": ") + 2);
  return "unknown processor";
}

std::string driver_of(const sideray_device_info& device) {
  if (std::string_view(device.gl) == "none") return "rays alone";
  std::string driver = fmt::format("{}, OpenGL {}", device.renderer, device.version);
  for (const char* software : {"llvmpipe", "softpipe", "swrast"})
    if (driver.starts_with(software)) driver += ", " + processor_maker();
  return driver;
}

std::string camera_digest(const sideray_camera& camera) {
  std::string text = fmt::format("{} {} {} {} {} {}", fmt::join(camera.world_from_camera, " "), camera.orthographic,
                                 camera.yfov, camera.half_height, camera.z_near, camera.z_far);
  // Added only for other values than the default, so that older references keep their digests.
  if ((camera.fx_per_fy != 0.0f && camera.fx_per_fy != 1.0f) || camera.shift_x != 0.0f || camera.shift_y != 0.0f)
    text += fmt::format(" {} {} {}", camera.fx_per_fy, camera.shift_x, camera.shift_y);
  return digest_of(text);
}

// Names an object; without a name of its own, by its mesh or material.
std::string name_of(const SceneObject& object, const scenes::Content& content) {
  if (!object.name.empty()) return object.name;
  const scenes::Object& first = content.objects[object.surfaces.front() - 1];
  if (const std::string& mesh = content.meshes[first.mesh].name; !mesh.empty()) return mesh;
  if (const std::string& material = content.materials[first.material].name; !material.empty()) return material;
  return fmt::format("surface {}", object.surfaces.front());
}

// Holds the objects of a scene, for all its pictures.
struct Names {
  std::vector<lab::NamedObject> objects;
  std::map<std::string, uint32_t> counts;

  explicit Names(const scenes::Content& content) {
    for (const SceneObject& object : scene_objects(content)) {
      const std::string name = name_of(object, content);
      objects.push_back({name, ++counts[name], 1, object.surfaces, ""});
    }
    for (lab::NamedObject& object : objects) object.of = counts[object.name];
  }
};

std::string place_of(const lab::NamedObject& object, const scenes::Content& content) {
  const scenes::Object& first = content.objects[object.surfaces.front() - 1];  // all primitives have the same transform
  return digest_of(fmt::format("{}", fmt::join(first.world_from_object, " ")));
}

std::vector<lab::NamedObject> shown(const Names& names, const scenes::Image& ids, const scenes::Content& content) {
  const std::vector<uint32_t>& values = ids.find("first.surface")->uint_values;
  const std::set<uint32_t> seen(values.begin(), values.end());
  const auto is_seen = [&](uint32_t surface) { return seen.contains(surface); };
  std::vector<lab::NamedObject> result;
  for (const lab::NamedObject& object : names.objects) {
    if (!std::any_of(object.surfaces.begin(), object.surfaces.end(), is_seen)) continue;
    result.push_back(object);
    result.back().place = place_of(object, content);
  }
  return result;
}

// Returns ids and distances. Half floats suffice, as distances only decide which of two surfaces is in front.
scenes::Image ids_of(const Picture& picture) {
  scenes::Image image{picture.width(), picture.height(), {}, true};
  const size_t pixels = size_t{image.width} * image.height;
  for (size_t i = 0; i < picture.channel_count(); ++i) {
    const sideray_channel channel = picture.channel(i);
    const std::string name = channel.name;
    scenes::Plane plane;
    plane.name = name;
    if (name == "first.surface") {
      plane.type = scenes::Plane::Type::uint;
      const auto* values = static_cast<const uint32_t*>(channel.values);
      plane.uint_values.assign(values, values + pixels);
    } else if (name == "first.Z") {
      const auto* values = static_cast<const float*>(channel.values);
      plane.values.assign(values, values + pixels);
    } else {
      continue;
    }
    image.planes.push_back(std::move(plane));
  }
  return image;
}

struct Drawing {
  const std::function<std::string(const std::string&)>& file_of;
  const std::function<void(DrawnPicture&&)>& take;
  Progress progress;

  void draw(Session& session, const Names& names, RenderOptions options, GoldenPicture golden) {
    progress.next(golden.name);
    const auto start = std::chrono::steady_clock::now();
    options.output = file_of(golden.file);
    const std::string ids_file = file_of(golden.ids);
    session.move_to(options);
    const Session::Drawn drawn = session.draw(options);
    write_picture(drawn.picture, drawn.light_names, options);
    scenes::write_exr(ids_file, ids_of(drawn.picture));
    // Compares what the files hold: half floats, or 8 bits.
    DrawnPicture result{std::move(golden), scenes::read_image(options.output), scenes::read_image(ids_file),
                        image_of(drawn.picture, drawn.light_names, options), names.counts, options.display, 0};
    result.golden.digest = digest_of(result.picture);
    result.golden.ids_digest = digest_of(result.ids);
    result.golden.driver = driver_of(drawn.run.device);
    result.golden.camera = camera_digest(session.camera());
    result.golden.objects = shown(names, result.ids, session.content());
    result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    take(std::move(result));
  }

  // Draws all frames of a job. A framed camera stays where it is in the first; averages need the frames before.
  void draw_job(const RenderOptions& options, const std::vector<GoldenPicture>& pictures) {
    if (!options.frames) {
      Session session(options);
      return draw(session, Names(session.content()), options, pictures.front());
    }
    const uint32_t first = options.frames->first;
    std::vector<uint32_t> frames(pictures.size());
    std::iota(frames.begin(), frames.end(), first);
    Session session(frame_options(options, {first}));
    const Names names(session.content());
    for (const Step& step : plan_steps(first, frames, 0))
      draw(session, names, frame_options(options, step), pictures[step.frame - first]);
  }
};

}  // namespace

void draw_golden(const std::vector<GoldenJob>& jobs, uint32_t threads,
                 const std::function<std::string(const std::string& name)>& file_of,
                 const std::function<void(DrawnPicture&& drawn)>& take) {
  size_t pictures = 0;
  for (const GoldenJob& job : jobs) pictures += pictures_of(job).size();
  Drawing drawing{file_of, take, Progress(pictures)};
  for (const GoldenJob& job : jobs)
    of_job(job.name, [&] {
      RenderOptions options = job.options;
      if (threads != 0) options.threads = threads;
      drawing.draw_job(options, pictures_of(job));
    });
}

}  // namespace sideray::cli
