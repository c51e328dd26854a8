// Sideray for C++17: move-only handles and Result over sideray.h. Header-only; contracts are those of sideray.h.
#pragma once

#include <array>
#include <sideray/sideray.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#if __cplusplus > 201703L
#include <span>  // kept for C++20 hosts that got it from this header before 0.3
#endif
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace sideray {

// Refers to contiguous elements: of a vector, an array, a std::span, or a pointer and a count.
template <typename T>
class Span {
 public:
  constexpr Span() = default;
  constexpr Span(T* data, size_t size) : data_(data), size_(size) {}
  template <size_t N>
  constexpr Span(T (&elements)[N]) : data_(elements), size_(N) {}
  template <typename Elements,
            typename = std::enable_if_t<std::is_convertible_v<decltype(std::declval<Elements&>().data()), T*>>>
  constexpr Span(Elements&& elements) : data_(elements.data()), size_(elements.size()) {}
  constexpr T* data() const { return data_; }
  constexpr size_t size() const { return size_; }

 private:
  T* data_ = nullptr;
  size_t size_ = 0;
};

// A failed call as an exception; thrown by Result::value and by check.
struct Error : std::runtime_error {
  Error(sideray_status error_status, const std::string& message) : std::runtime_error(message), status(error_status) {}
  sideray_status status;
};

// Holds a value, or the error that explains why there is none.
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : value_(std::move(value)) {}
  Result(const sideray_error& error) : error_(error) {}
  explicit operator bool() const { return value_.has_value(); }
  const sideray_error& error() const { return error_; }
  T& operator*() { return *value_; }
  T* operator->() { return &*value_; }
  T value() && {
    if (!value_) throw Error(error_.status, error_.message);
    return std::move(*value_);
  }

 private:
  std::optional<T> value_;
  sideray_error error_{};
};

// Calls f(&error); throws a failure as Error, and returns SIDERAY_OK or SIDERAY_NOT_READY.
template <typename F>
sideray_status check(F&& f) {
  sideray_error error{};
  const sideray_status status = f(&error);
  if (status < 0) throw Error(status, error.message);
  return status;
}

class Scene {
 public:
  static Result<Scene> create() {
    sideray_error error{};
    sideray_scene* scene = nullptr;
    if (sideray_scene_create(&scene, &error) != SIDERAY_OK) return error;
    return Scene(scene);
  }
  // Adds a reference to a scene that another owner holds.
  static Scene share(sideray_scene* scene) {
    sideray_scene_retain(scene);
    return Scene(scene);
  }
  sideray_scene* get() const { return handle_.get(); }

  sideray_mesh add_mesh(const sideray_mesh_desc& desc, uint32_t* dropped = nullptr) {
    sideray_mesh mesh = 0;
    check([&](sideray_error* e) { return sideray_scene_add_mesh(get(), &desc, &mesh, dropped, e); });
    return mesh;
  }
  // Replaces the vertices, as many as the mesh has; its triangles stay.
  void set_vertices(sideray_mesh mesh, const sideray_mesh_desc& desc) {
    check([&](sideray_error* e) { return sideray_scene_set_vertices(get(), mesh, &desc, e); });
  }
  // `texels`: four bytes each, top row first.
  sideray_texture add_texture(uint32_t width, uint32_t height, sideray_texel_format format, const void* texels) {
    sideray_texture texture = 0;
    check(
        [&](sideray_error* e) { return sideray_scene_add_texture(get(), width, height, format, texels, &texture, e); });
    return texture;
  }
  sideray_material add_material(const sideray_material_desc& desc) {
    sideray_material material = 0;
    check([&](sideray_error* e) { return sideray_scene_add_material(get(), &desc, &material, e); });
    return material;
  }
  // Replaces the shape of `mesh`.
  void replace_mesh(sideray_mesh mesh, const sideray_mesh_desc& desc, uint32_t* dropped = nullptr) {
    check([&](sideray_error* e) { return sideray_scene_replace_mesh(get(), mesh, &desc, dropped, e); });
  }
  void remove_mesh(sideray_mesh mesh) {
    check([&](sideray_error* e) { return sideray_scene_remove_mesh(get(), mesh, e); });
  }
  void replace_texture(sideray_texture texture, uint32_t width, uint32_t height, sideray_texel_format format,
                       const void* texels) {
    check([&](sideray_error* e) {
      return sideray_scene_replace_texture(get(), texture, width, height, format, texels, e);
    });
  }
  void remove_texture(sideray_texture texture) {
    check([&](sideray_error* e) { return sideray_scene_remove_texture(get(), texture, e); });
  }
  void replace_material(sideray_material material, const sideray_material_desc& desc) {
    check([&](sideray_error* e) { return sideray_scene_replace_material(get(), material, &desc, e); });
  }
  void remove_material(sideray_material material) {
    check([&](sideray_error* e) { return sideray_scene_remove_material(get(), material, e); });
  }
  // Returns the names of the instances.
  std::vector<sideray_instance> add_instances(Span<const sideray_instance_desc> descs) {
    std::vector<sideray_instance> instances(descs.size());
    check([&](sideray_error* e) {
      return sideray_scene_add_instances(get(), descs.data(), sizeof(sideray_instance_desc), descs.size(),
                                         instances.data(), e);
    });
    return instances;
  }
  // Takes as many descriptions as instances.
  void replace_instances(Span<const sideray_instance> instances, Span<const sideray_instance_desc> descs) {
    check([&](sideray_error* e) {
      return sideray_scene_replace_instances(get(), instances.data(), descs.data(), sizeof(sideray_instance_desc),
                                             std::min(instances.size(), descs.size()), e);
    });
  }
  void remove_instances(Span<const sideray_instance> instances) {
    check([&](sideray_error* e) {
      return sideray_scene_remove_instances(get(), instances.data(), instances.size(), e);
    });
  }
  // Takes twelve numbers, four columns of three.
  void move_instance(sideray_instance instance, const double* world_from_object) {
    check([&](sideray_error* e) { return sideray_scene_move_instances(get(), &instance, 1, world_from_object, e); });
  }
  // Takes as many surface ids as instances.
  void renumber_instances(Span<const sideray_instance> instances, Span<const uint32_t> surface_ids) {
    check([&](sideray_error* e) {
      return sideray_scene_renumber_instances(get(), instances.data(), std::min(instances.size(), surface_ids.size()),
                                              surface_ids.data(), e);
    });
  }
  void set_visibility(sideray_instance instance, uint32_t visibility) {
    check([&](sideray_error* e) { return sideray_scene_set_visibility(get(), instance, visibility, e); });
  }
  sideray_wind add_wind(const sideray_wind_desc& desc) {
    sideray_wind wind = 0;
    check([&](sideray_error* e) { return sideray_scene_add_wind(get(), &desc, &wind, e); });
    return wind;
  }
  void set_time(double time_s, double previous_time_s) {
    check([&](sideray_error* e) { return sideray_scene_set_time(get(), time_s, previous_time_s, e); });
  }
  sideray_particles add_particles(const sideray_particles_desc& desc) {
    sideray_particles particles = 0;
    check([&](sideray_error* e) { return sideray_scene_add_particles(get(), &desc, &particles, e); });
    return particles;
  }
  void set_sprites(sideray_particles particles, Span<const sideray_sprite> sprites) {
    check([&](sideray_error* e) {
      return sideray_scene_set_sprites(get(), particles, sprites.data(), sizeof(sideray_sprite), sprites.size(), e);
    });
  }
  void set_lights(Span<const sideray_light> lights) {
    check([&](sideray_error* e) { return sideray_scene_set_lights(get(), lights.data(), lights.size(), e); });
  }
  void set_environment(uint32_t width, uint32_t height, const float* rgb, float scale, float rotation_deg) {
    check([&](sideray_error* e) {
      return sideray_scene_set_environment(get(), width, height, rgb, scale, rotation_deg, e);
    });
  }
  // `cube_from_world`: null = the identity.
  void set_environment_cube(uint32_t side, const std::array<const float*, 6>& faces, float scale,
                            const float* cube_from_world = nullptr) {
    check([&](sideray_error* e) {
      return sideray_scene_set_environment_cube(get(), side, faces.data(), scale, cube_from_world, e);
    });
  }
  void set_shader(const sideray_shader_desc& shader) {
    check([&](sideray_error* e) { return sideray_scene_set_shader(get(), &shader, e); });
  }
  void set_built_in_shader() {
    check([&](sideray_error* e) { return sideray_scene_set_shader(get(), nullptr, e); });
  }
  void set_fixed_function(const sideray_fixed_function& model) {
    check([&](sideray_error* e) { return sideray_scene_set_fixed_function(get(), &model, e); });
  }
  void set_fixed_material(sideray_material material, const sideray_fixed_material& fixed) {
    check([&](sideray_error* e) { return sideray_scene_set_fixed_material(get(), material, &fixed, e); });
  }
  void commit() {
    check([&](sideray_error* e) { return sideray_scene_commit(get(), e); });
  }

 private:
  struct Release {
    void operator()(sideray_scene* scene) const { sideray_scene_release(scene); }
  };
  explicit Scene(sideray_scene* scene) : handle_(scene) {}
  std::unique_ptr<sideray_scene, Release> handle_;
};

class Tracer {
 public:
  static Result<Tracer> create(const Scene& scene, const sideray_tracer_desc& desc = sideray_tracer_defaults()) {
    sideray_error error{};
    sideray_tracer* tracer = nullptr;
    if (sideray_tracer_create(scene.get(), &desc, &tracer, &error) != SIDERAY_OK) return error;
    return Tracer(tracer);
  }
  sideray_tracer* get() const { return handle_.get(); }

  // Returns `layers` hits per ray, in the order (distance, surface id, primitive).
  std::vector<sideray_hit> trace(sideray_ray_set set, Span<const sideray_ray> rays, uint32_t layers = 1) {
    std::vector<sideray_hit> hits(rays.size() * layers);
    sideray_ray_batch batch = sideray_ray_batch_defaults();
    batch.set = set;
    batch.layers = layers;
    batch.rays = rays.data();
    batch.count = rays.size();
    batch.hits = hits.data();
    check([&](sideray_error* e) { return sideray_tracer_trace_rays(get(), &batch, e); });
    return hits;
  }

 private:
  struct Release {
    void operator()(sideray_tracer* tracer) const { sideray_tracer_release(tracer); }
  };
  explicit Tracer(sideray_tracer* tracer) : handle_(tracer) {}
  std::unique_ptr<sideray_tracer, Release> handle_;
};

// The inputs of a frame with its jobs by value. By default it has the job of layers.
struct FrameInputs {
  sideray_frame_inputs frame = sideray_frame_defaults();  // its pointers to jobs are not read
  std::optional<sideray_layer_inputs> layers = sideray_layer_inputs_defaults();
  std::optional<sideray_mask_inputs> masks;
  std::optional<sideray_reflection_inputs> reflections;
  std::optional<sideray_irradiance_inputs> irradiance;

  // Returns the struct of the C interface, which points into this object.
  sideray_frame_inputs c() const {
    sideray_frame_inputs inputs = frame;
    inputs.layers = layers ? &*layers : nullptr;
    inputs.masks = masks ? &*masks : nullptr;
    inputs.reflections = reflections ? &*reflections : nullptr;
    inputs.irradiance = irradiance ? &*irradiance : nullptr;
    return inputs;
  }
};

// Must be destroyed with the context that created it current, or after abandon_context().
class Service {
 public:
  static Result<Service> create(const Tracer& tracer, const sideray_host_gl& host) {
    sideray_error error{};
    sideray_service* service = nullptr;
    if (sideray_service_create(tracer.get(), &host, &service, &error) != SIDERAY_OK) return error;
    return Service(service);
  }
  sideray_service* get() const { return handle_.get(); }

  // Returns nothing if three frames of the view are in flight already.
  std::optional<sideray_ticket> submit(const FrameInputs& inputs) { return submit(inputs.c()); }
  std::optional<sideray_ticket> submit(const sideray_frame_inputs& inputs) {
    sideray_ticket ticket = 0;
    const sideray_status status =
        check([&](sideray_error* e) { return sideray_service_submit(get(), &inputs, &ticket, e); });
    return status == SIDERAY_OK ? std::optional(ticket) : std::nullopt;
  }
  void advance() {
    check([&](sideray_error* e) { return sideray_service_advance(get(), e); });
  }
  // Returns whether the frame is uploaded. A negative `timeout_ms` waits for ever.
  bool wait(sideray_ticket ticket, int32_t timeout_ms = -1) {
    return check([&](sideray_error* e) { return sideray_service_wait(get(), ticket, timeout_ms, e); }) == SIDERAY_OK;
  }
  void cancel(sideray_ticket ticket) {
    check([&](sideray_error* e) { return sideray_service_cancel(get(), ticket, e); });
  }
  // Returns whether these jobs of the frame are uploaded. A negative `timeout_ms` waits for ever.
  bool wait_jobs(sideray_ticket ticket, uint32_t jobs, int32_t timeout_ms = -1) {
    return check([&](sideray_error* e) {
             return sideray_service_wait_jobs(get(), ticket, jobs, timeout_ms, e);
           }) == SIDERAY_OK;
  }
  uint32_t finished_jobs(sideray_ticket ticket) const {
    uint32_t jobs = 0;
    check([&](sideray_error* e) { return sideray_service_finished_jobs(get(), ticket, &jobs, e); });
    return jobs;
  }
  // Returns nothing before the first finished job of its kind; so do the next two.
  std::optional<sideray_layer_outputs> layers(uint32_t view_id = 0) const {
    return newest<sideray_layer_outputs>(view_id, sideray_service_layers);
  }
  std::optional<sideray_mask_outputs> masks(uint32_t view_id = 0) const {
    return newest<sideray_mask_outputs>(view_id, sideray_service_masks);
  }
  std::optional<sideray_reflection_outputs> reflections(uint32_t view_id = 0) const {
    return newest<sideray_reflection_outputs>(view_id, sideray_service_reflections);
  }
  std::optional<sideray_irradiance_outputs> irradiance(uint32_t view_id = 0) const {
    return newest<sideray_irradiance_outputs>(view_id, sideray_service_irradiance);
  }
  // Returns a matrix as in sideray_instance_desc::world_from_object; nothing before such outputs, or if the instance is
  // newer.
  std::optional<std::array<double, 12>> placement(uint32_t job, sideray_instance instance, uint32_t view_id = 0) const {
    std::array<double, 12> matrix{};
    const sideray_status status = check(
        [&](sideray_error* e) { return sideray_service_placement(get(), view_id, job, instance, matrix.data(), e); });
    return status == SIDERAY_OK ? std::optional(matrix) : std::nullopt;
  }
  void bind(uint32_t program, uint32_t first_unit, uint32_t view_id = 0) {
    check([&](sideray_error* e) { return sideray_service_bind(get(), view_id, program, first_unit, e); });
  }
  sideray_frame_stats stats(sideray_ticket ticket) const {
    sideray_frame_stats stats{};
    stats.size = sizeof(stats);
    check([&](sideray_error* e) { return sideray_service_stats(get(), ticket, &stats, e); });
    return stats;
  }
  void abandon_context() { sideray_service_abandon_context(get()); }

 private:
  template <typename Outputs>
  std::optional<Outputs> newest(uint32_t view_id, sideray_status (*ask)(sideray_service*, uint32_t, Outputs*,
                                                                        sideray_error*)) const {
    Outputs outputs{};
    outputs.size = sizeof(outputs);
    const sideray_status status = check([&](sideray_error* e) { return ask(get(), view_id, &outputs, e); });
    return status == SIDERAY_OK ? std::optional(outputs) : std::nullopt;
  }
  struct Destroy {
    void operator()(sideray_service* service) const { sideray_service_destroy(service); }
  };
  explicit Service(sideray_service* service) : handle_(service) {}
  std::unique_ptr<sideray_service, Destroy> handle_;
};

// The options of a picture with their parts by value, with the defaults of sideray_render_defaults.
struct RenderOptions {
  sideray_render_options picture = sideray_render_defaults();  // of its pointers only `diagnostics` is read
  std::optional<sideray_translucency_options> translucency = sideray_translucency_defaults();
  std::optional<sideray_shadow_options> shadows = sideray_shadow_defaults();
  std::optional<sideray_pose_options> poses = sideray_pose_defaults();
  std::optional<sideray_reference_options> reference;

  // Returns the struct of the C interface, which points into this object.
  sideray_render_options c() const {
    sideray_render_options options = picture;
    options.translucency = translucency ? &*translucency : nullptr;
    options.shadows = shadows ? &*shadows : nullptr;
    options.poses = poses ? &*poses : nullptr;
    options.reference = reference ? &*reference : nullptr;
    return options;
  }
};

// The options of a picture by name. Copies are independent sets.
class Options {
 public:
  static Result<Options> create() {
    sideray_error error{};
    sideray_options* options = nullptr;
    if (sideray_options_create(&options, &error) != SIDERAY_OK) return error;
    return Options(options);
  }
  Options(Options&&) = default;
  Options& operator=(Options&&) = default;
  Options(const Options& other) {
    sideray_options* options = nullptr;
    check([&](sideray_error* e) { return sideray_options_copy(other.get(), &options, e); });
    handle_.reset(options);
  }
  Options& operator=(const Options& other) { return *this = Options(other); }
  sideray_options* get() const { return handle_.get(); }

  // Sets an option; an empty value restores the default.
  void set(const std::string& name, const std::string& value) {
    check([&](sideray_error* e) { return sideray_options_set(get(), name.c_str(), value.c_str(), e); });
  }
  // Throws if options contradict each other.
  void require_consistent() const {
    check([&](sideray_error* e) { return sideray_options_check(get(), e); });
  }
  std::string operator[](const std::string& name) const {
    const char* value = sideray_options_get(get(), name.c_str());
    return value ? value : "";
  }
  bool is_set(const std::string& name) const { return sideray_options_is_set(get(), name.c_str()) != 0; }
  bool reads(const std::string& name) const { return sideray_options_reads(get(), name.c_str()) != 0; }
  bool applies(const std::string& name) const { return sideray_options_applies(get(), name.c_str(), nullptr) != 0; }
  // The result is valid until the options are changed or destroyed.
  const sideray_render_options& render() const { return *sideray_options_render(get()); }

 private:
  struct Release {
    void operator()(sideray_options* options) const { sideray_options_release(options); }
  };
  explicit Options(sideray_options* options) : handle_(options) {}
  std::unique_ptr<sideray_options, Release> handle_;
};

class Picture {
 public:
  explicit Picture(sideray_picture* picture) : handle_(picture) { sideray_picture_size(picture, &width_, &height_); }
  uint32_t width() const { return width_; }
  uint32_t height() const { return height_; }
  size_t channel_count() const { return sideray_picture_channel_count(handle_.get()); }
  sideray_channel channel(size_t index) const {
    const sideray_channel* channel = sideray_picture_channel(handle_.get(), index);
    return channel ? *channel : sideray_channel{};
  }
  sideray_render_stats stats() const {
    sideray_render_stats stats{};
    stats.size = sizeof(stats);
    check([&](sideray_error* e) { return sideray_picture_stats(handle_.get(), &stats, e); });
    return stats;
  }
  // Returns every stage once, in their order.
  std::vector<sideray_stage_time> stages() const {
    std::vector<sideray_stage_time> list;
    for (size_t i = 0; i < sideray_picture_stage_count(handle_.get()); ++i)
      list.push_back(*sideray_picture_stage(handle_.get(), i));
    return list;
  }
  // Returns zeros if the picture has no such stage.
  sideray_stage_time stage(sideray_stage stage) const {
    for (size_t i = 0; i < sideray_picture_stage_count(handle_.get()); ++i)
      if (const sideray_stage_time* time = sideray_picture_stage(handle_.get(), i); time->stage == stage) return *time;
    return {stage, "", 0, 0, 0};
  }

 private:
  struct Release {
    void operator()(sideray_picture* picture) const { sideray_picture_release(picture); }
  };
  std::unique_ptr<sideray_picture, Release> handle_;
  uint32_t width_ = 0, height_ = 0;
};

class Renderer {
 public:
  static Result<Renderer> create(const sideray_renderer_desc& desc = sideray_renderer_defaults()) {
    sideray_error error{};
    sideray_renderer* renderer = nullptr;
    if (sideray_renderer_create(&desc, &renderer, &error) != SIDERAY_OK) return error;
    return Renderer(renderer);
  }
  sideray_renderer* get() const { return handle_.get(); }

  Result<Picture> render(const Scene& scene, const sideray_camera& camera, const RenderOptions& options) {
    return render(scene, camera, options.c());
  }
  Result<Picture> render(const Scene& scene, const sideray_camera& camera, const sideray_render_options& options) {
    sideray_error error{};
    sideray_picture* picture = nullptr;
    if (sideray_renderer_render(get(), scene.get(), &camera, &options, &picture, &error) != SIDERAY_OK) return error;
    return Picture(picture);
  }
  // As sideray_renderer_render_many.
  Result<std::vector<Picture>> render_many(const Scene& scene, const std::vector<sideray_camera>& cameras,
                                           const sideray_render_options& options) {
    sideray_error error{};
    std::vector<sideray_picture*> drawn(cameras.size());
    if (sideray_renderer_render_many(get(), scene.get(), cameras.data(), cameras.size(), &options, drawn.data(), &error) !=
        SIDERAY_OK)
      return error;
    return std::vector<Picture>(drawn.begin(), drawn.end());
  }
  // Any thread. As sideray_renderer_cancel.
  void cancel() const { sideray_renderer_cancel(get()); }
  sideray_device_info device() const {
    const sideray_device_info* device = nullptr;
    check([&](sideray_error* e) { return sideray_renderer_device(get(), &device, e); });
    return *device;
  }

 private:
  struct Destroy {
    void operator()(sideray_renderer* renderer) const { sideray_renderer_destroy(renderer); }
  };
  explicit Renderer(sideray_renderer* renderer) : handle_(renderer) {}
  std::unique_ptr<sideray_renderer, Destroy> handle_;
};

}  // namespace sideray
