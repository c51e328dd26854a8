// Tests a host that uses the masks of the previous frame: legs of a table in front of a floor with the shadow of its
// top. At the same pixel, legs and floor would take each other's masks along their outlines; sideray_find_masks()
// reprojects each surface.
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <optional>
#include <sideray/sideray.hpp>
#include <string>
#include <vector>

#include "embed/hosts/one_pane.h"
#include "gl/context/context.h"
#include "gl/resources/objects.h"
#include "gl/resources/program.h"

namespace sideray::tests::moving_masks_test {
namespace {

constexpr int width = 240, height = 160;
constexpr size_t pixels = size_t{width} * height;

// The reasons, numbered as in sideray.glsl.
constexpr float matched = 0, not_asked = 1, not_traced = 3, other_surface = 6, beside = 7;

struct Box {
  glm::vec3 middle, half;
};
constexpr std::array<Box, 6> boxes{{{{0, -0.1f, 0}, {6, 0.1f, 6}},  // the floor
                                    {{0, 1.5f, 0}, {1.2f, 0.06f, 0.8f}},
                                    {{-1, 0.75f, -0.6f}, {0.06f, 0.75f, 0.06f}},
                                    {{1, 0.75f, -0.6f}, {0.06f, 0.75f, 0.06f}},
                                    {{-1, 0.75f, 0.6f}, {0.06f, 0.75f, 0.06f}},
                                    {{1, 0.75f, 0.6f}, {0.06f, 0.75f, 0.06f}}}};
constexpr size_t leg = 4;  // the one that moves by itself

std::vector<glm::vec3> corners_of(glm::vec3 half) {
  std::vector<glm::vec3> corners;
  for (int i = 0; i < 8; ++i) corners.push_back(half * glm::vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
  return corners;
}
constexpr std::array<uint32_t, 36> triangles{0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                             2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};

struct Kind {
  const char* name;
  GLenum depth;
  bool orthographic;
};

struct Look {
  float lit, open, reason;
};

class MovingMasks : public testing::TestWithParam<Kind> {
 protected:
  void SetUp() override {
    context_ = gl::Context::create("auto", "");
    context_->make_current();
    const gl::Functions& gl = context_->functions();
    framebuffer_ = gl::Framebuffer(gl), color_ = gl::Renderbuffer(gl), depth_ = gl::Renderbuffer(gl);
    array_ = gl::VertexArray(gl), vertices_ = gl::Buffer(gl);
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    const auto attach = [&](const gl::Renderbuffer& buffer, GLenum format, GLenum attachment) {
      gl.BindRenderbuffer(GL_RENDERBUFFER, buffer.id());
      gl.RenderbufferStorage(GL_RENDERBUFFER, format, width, height);
      gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, buffer.id());
    };
    attach(color_, GL_RGBA32F, GL_COLOR_ATTACHMENT0);
    attach(depth_, GetParam().depth, GL_DEPTH_ATTACHMENT);
    create_scene();
    const sideray_host_gl host{sizeof(host), gl::Context::get_proc_address, context_.get()};
    tracer_.emplace(sideray::Tracer::create(scene_).value());
    service_.emplace(sideray::Service::create(*tracer_, host).value());
    own_pixel_ = program("vec4(sideray_shadow(0), sideray_ao(), 0.0, 1.0)");
    moving_ = program("look()");
  }
  void TearDown() override {
    service_.reset();
    own_pixel_.reset(), moving_.reset();
    framebuffer_.reset(), color_.reset(), depth_.reset(), array_.reset(), vertices_.reset();
    for (const std::string& error : context_->take_errors()) ADD_FAILURE() << error;
    context_->release_current();
  }

  void create_scene() {
    const sideray_material white = scene_.add_material(sideray_material_defaults());
    std::vector<glm::vec3> corners;
    for (size_t i = 0; i < boxes.size(); ++i) {
      const std::vector<glm::vec3> own = corners_of(boxes[i].half);
      sideray_mesh_desc mesh = sideray_mesh_defaults();
      mesh.vertex_count = 8, mesh.index_count = triangles.size();
      mesh.positions.data = &own[0].x, mesh.indices = triangles.data();
      sideray_instance_desc instance{};
      instance.mesh = scene_.add_mesh(mesh), instance.material = white;
      place(instance.world_from_object, boxes[i].middle);
      instance.visibility = SIDERAY_VISIBLE_ALL;
      instances_.push_back(scene_.add_instances({&instance, 1})[0]);
      middles_.push_back(boxes[i].middle);
      for (const uint32_t corner : triangles) corners.push_back(own[corner]);
    }
    sideray_light sun{};
    sun.size = sizeof(sun);
    sun.type = SIDERAY_LIGHT_DIRECTIONAL;
    sun.direction[0] = -0.5f, sun.direction[1] = -1.0f, sun.direction[2] = -0.3f;
    for (float& c : sun.intensity) c = 1;
    scene_.set_lights({&sun, 1});
    scene_.commit();
    context_->functions().BindBuffer(GL_ARRAY_BUFFER, vertices_.id());
    context_->functions().BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(corners.size() * sizeof(corners[0])),
                                     corners.data(), GL_STATIC_DRAW);
  }
  static void place(double (&matrix)[12], glm::dvec3 middle) {
    std::memset(matrix, 0, sizeof(matrix));
    for (int i : {0, 4, 8}) matrix[i] = 1;
    for (int i = 0; i < 3; ++i) matrix[9 + i] = middle[i];
  }

  std::unique_ptr<gl::Program> program(const std::string& result) const {
    return std::make_unique<gl::Program>(
        context_->functions(), "host",
        "#version 330 core\nlayout(location = 0) in vec3 corner;\nuniform mat4 clip_from_world;\n"
        "uniform vec3 middle, middle_before;\nout vec3 before;\nvoid main() {\n"
        "before = corner + middle_before; gl_Position = clip_from_world * vec4(corner + middle, 1.0); }\n",
        std::string("#version 330 core\n") + sideray_glsl(330) +
            "in vec3 before;\nout vec4 result;\n"
            "vec4 look() { SiderayMaskPlace place = sideray_find_masks(before);\n"
            "return vec4(sideray_shadow_at(place, 0), sideray_ao_at(place), float(place.reason), 1.0); }\n"
            "void main() { result = " + result + "; }\n");
  }

  // `walk` is how far the eye has moved to the right.
  static glm::dmat4 clip_from_world(double walk) {
    const glm::dvec3 eye(1.5 + walk, 2.6, 5.6);
    const glm::dmat4 camera = glm::lookAt(eye, eye + glm::dvec3(-0.25, -0.34, -0.94), glm::dvec3(0, 1, 0));
    const double aspect = double{width} / height;
    return (GetParam().orthographic ? glm::ortho(-2.4 * aspect, 2.4 * aspect, -2.4, 2.4, 0.5, 40.0)
                                    : glm::perspective(0.8, aspect, 0.5, 40.0)) * camera;
  }

  // Draws everything at its current place; `before` gives programs the previous positions.
  std::vector<Look> draw(const gl::Program& p, double walk, const std::vector<glm::vec3>& before) {
    const gl::Functions& gl = context_->functions();
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    gl.Viewport(0, 0, width, height);
    gl.Enable(GL_DEPTH_TEST);
    gl.ClearColor(1, 1, -1, 1);
    gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    service_->bind(p.id(), 1);
    p.use();
    const glm::mat4 clip(clip_from_world(walk));
    gl.UniformMatrix4fv(gl.GetUniformLocation(p.id(), "clip_from_world"), 1, GL_FALSE, glm::value_ptr(clip));
    gl.BindVertexArray(array_.id());
    gl.BindBuffer(GL_ARRAY_BUFFER, vertices_.id());
    gl.VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
    gl.EnableVertexAttribArray(0);
    for (size_t i = 0; i < boxes.size(); ++i) {
      gl.Uniform3fv(gl.GetUniformLocation(p.id(), "middle"), 1, &middles_[i].x);
      gl.Uniform3fv(gl.GetUniformLocation(p.id(), "middle_before"), 1, &before[i].x);
      gl.DrawArrays(GL_TRIANGLES, static_cast<GLint>(36 * i), 36);
    }
    gl.BindVertexArray(0);
    std::vector<glm::vec4> texels(pixels);
    gl.ReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, texels.data());
    std::vector<Look> looks;
    for (const glm::vec4& t : texels) looks.push_back({t.x, t.y, t.z});
    return looks;
  }

  void trace(double walk, bool moving = true) {
    draw(*own_pixel_, walk, middles_);  // for its depth
    FrameInputs in;
    set_matrices(in.frame.view, clip_from_world(walk));
    in.frame.source.framebuffer = framebuffer_.id();
    in.frame.source.mask = SIDERAY_MASK_NONE;
    in.frame.source.width = width, in.frame.source.height = height;
    in.layers.reset();
    in.masks = sideray_mask_inputs_defaults();
    in.masks->shadow_lights = 1;
    in.masks->ao_rays = 8;
    in.masks->ao_distance = 1;
    in.masks->denoise = 0;
    in.masks->moving = moving;
    const std::optional<sideray_ticket> ticket = service_->submit(in);
    ASSERT_TRUE(ticket && service_->wait(*ticket));
  }

  void move(size_t box, glm::vec3 by) {
    middles_[box] += by;
    double matrix[12];
    place(matrix, middles_[box]);
    scene_.move_instance(instances_[box], matrix);
    scene_.commit();
  }
  // Returns the positions of everything in the frame whose masks are bound.
  std::vector<glm::vec3> middles_of_masks() const {
    std::vector<glm::vec3> middles;
    for (const sideray_instance instance : instances_) {
      const auto matrix = service_->placement(SIDERAY_JOB_MASKS, instance).value();
      middles.emplace_back(matrix[9], matrix[10], matrix[11]);
    }
    return middles;
  }

  // Counts pixels whose shadow, and that of their neighbours, is known from masks of this frame, and those that a
  // lookup gets wrong. `open` uses the ambient mask instead, which changes little between pixels.
  struct Errors {
    size_t known = 0, wrong = 0, wrong_beside = 0, unanswered = 0;
  };
  static Errors compare(const std::vector<Look>& looks, const std::vector<Look>& truth) {
    Errors errors;
    for (int y = 1; y + 1 < height; ++y)
      for (int x = 1; x + 1 < width; ++x) {
        const auto at = [&](int i, int j) { return static_cast<size_t>((y + j) * width + x + i); };
        bool known = true;
        for (int j = -1; j <= 1; ++j)
          for (int i = -1; i <= 1; ++i) known = known && truth[at(i, j)].lit == truth[at(0, 0)].lit;
        const Look& look = looks[at(0, 0)];
        if (!known || look.reason < 0) continue;
        ++errors.known;
        const bool differs = std::abs(look.lit - truth[at(0, 0)].lit) > 0.5f;
        (look.reason == beside ? errors.wrong_beside : errors.wrong) += differs;
        errors.unanswered += look.reason != matched && look.reason != beside;
      }
    return errors;
  }

  std::unique_ptr<gl::Context> context_;
  gl::Framebuffer framebuffer_;
  gl::Renderbuffer color_, depth_;
  gl::VertexArray array_;
  gl::Buffer vertices_;
  sideray::Scene scene_ = sideray::Scene::create().value();
  std::vector<sideray_instance> instances_;
  std::vector<glm::vec3> middles_;
  std::optional<sideray::Tracer> tracer_;
  std::optional<sideray::Service> service_;
  std::unique_ptr<gl::Program> own_pixel_, moving_;
};

TEST_P(MovingMasks, OfAViewThatStandsStillAreThoseOfThePixels) {
  trace(0.3);
  const std::vector<Look> own = draw(*own_pixel_, 0.3, middles_), found = draw(*moving_, 0.3, middles_of_masks());
  size_t drawn = 0, answered = 0;
  for (size_t i = 0; i < pixels; ++i) {
    if (found[i].reason < 0) continue;
    ++drawn;
    if (found[i].reason != matched) continue;
    ++answered;
    ASSERT_EQ(found[i].lit, own[i].lit) << i % width << "," << i / width;
    ASSERT_EQ(found[i].open, own[i].open) << i % width << "," << i / width;
  }
  EXPECT_GT(drawn, pixels / 2);
  EXPECT_EQ(answered, drawn);
}

// Functions that include the search, for shaders with one light, give the same results.
TEST_P(MovingMasks, AreTheSameByOneCall) {
  trace(0.3);
  const auto by_one_call = program(
      "vec4(sideray_shadow_moving(0, before), sideray_ao_moving(before), "
      "float(sideray_explain_masks_moving(before)), 1.0)");
  const auto of_color = program("vec4(sideray_shadow_color_moving(0, before).g, sideray_ao_moving(before), 0.0, 1.0)");
  const std::vector<glm::vec3> before = middles_of_masks();
  const std::vector<Look> found = draw(*moving_, 0.5, before), one = draw(*by_one_call, 0.5, before),
                          color = draw(*of_color, 0.5, before);
  size_t dark = 0;
  for (size_t i = 0; i < pixels; ++i) {
    if (found[i].reason < 0) continue;
    dark += found[i].lit < 0.5f;
    ASSERT_EQ(one[i].lit, found[i].lit) << i;
    ASSERT_EQ(one[i].open, found[i].open) << i;
    ASSERT_EQ(one[i].reason, found[i].reason) << i;
    ASSERT_EQ(color[i].lit, found[i].lit) << "nothing tints this light: " << i;
  }
  EXPECT_GT(dark, 300u);
}

TEST_P(MovingMasks, StayWithTheirSurfacesWhereTheCameraMoves) {
  trace(0.3);
  const double now = 0.5;
  const std::vector<glm::vec3> before = middles_of_masks();
  const std::vector<Look> fringed = draw(*own_pixel_, now, before), found = draw(*moving_, now, before);
  trace(now);
  const std::vector<Look> truth = draw(*own_pixel_, now, middles_);
  const Errors own_pixel = compare(fringed, truth), moving = compare(found, truth);
  EXPECT_GT(moving.known, pixels / 3);
  EXPECT_GT(own_pixel.wrong, 300u);  // the fringes
  EXPECT_EQ(moving.wrong, 0u);
  EXPECT_LT(moving.wrong_beside, 10u);  // what was hidden is guessed
  EXPECT_LT(moving.unanswered, moving.known / 20);  // at the picture's border
}

TEST_P(MovingMasks, FollowWhatMoves) {
  trace(0.3);
  move(leg, {0.25f, 0, 0});
  const std::vector<glm::vec3> before = middles_of_masks();
  EXPECT_EQ(before[leg], boxes[leg].middle);
  EXPECT_EQ(before[0], boxes[0].middle);
  const std::vector<Look> found = draw(*moving_, 0.3, before);
  trace(0.3);
  EXPECT_NEAR(middles_of_masks()[leg].x, middles_[leg].x, 1e-6);
  const std::vector<Look> truth = draw(*own_pixel_, 0.3, middles_);
  const Errors moving = compare(found, truth);
  // The leg's own shadow on the floor is one frame late; its pixels are no fringe.
  EXPECT_LT(moving.wrong, 700u);
  EXPECT_LT(moving.wrong_beside, 120u);
  const auto on_leg = [&](const std::vector<Look>& looks, int y) {
    const glm::dvec4 clip = clip_from_world(0.3) * glm::dvec4(glm::dvec3(middles_[leg]) + glm::dvec3(0, 0.1 * y, 0.06), 1.0);
    const glm::dvec2 at = (glm::dvec2(clip) / clip.w * 0.5 + 0.5) * glm::dvec2(width, height);
    return looks[static_cast<size_t>(at.y) * width + static_cast<size_t>(at.x)];
  };
  for (int y = -4; y <= 4; ++y) EXPECT_EQ(on_leg(found, y).reason, matched) << y;
}

TEST_P(MovingMasks, SayWhyThereIsNone) {
  trace(0.3, false);
  EXPECT_FALSE(service_->masks()->depth_texture);
  for (const Look& look : draw(*moving_, 0.3, middles_)) {
    if (look.reason < 0) continue;
    ASSERT_EQ(look.reason, not_asked);
    ASSERT_EQ(look.lit, 1);
  }
  trace(0.3);
  EXPECT_TRUE(service_->masks()->depth_texture);
  std::vector<glm::vec3> elsewhere = middles_of_masks(), hidden = elsewhere;
  elsewhere[0] += glm::vec3(100, 0, 0);
  hidden[0] += glm::vec3(0, -3, 0);  // below what was seen
  const auto count = [&](const std::vector<glm::vec3>& before, float reason) {
    size_t found = 0;
    for (const Look& look : draw(*moving_, 0.3, before)) found += look.reason == reason;
    return found;
  };
  EXPECT_GT(count(elsewhere, not_traced), pixels / 4);
  EXPECT_GT(count(hidden, other_surface), pixels / 10);
  EXPECT_EQ(count(hidden, beside), 0u);
}

TEST_P(MovingMasks, HavePlacementsOfTheFrameThatIsShown) {
  EXPECT_FALSE(service_->placement(SIDERAY_JOB_MASKS, instances_[leg])) << "before the first frame";
  trace(0.3);
  EXPECT_TRUE(service_->placement(SIDERAY_JOB_MASKS, instances_[leg]));
  EXPECT_FALSE(service_->placement(SIDERAY_JOB_LAYERS, instances_[leg])) << "no layers were traced";
  scene_.remove_instances({&instances_[leg], 1});
  scene_.commit();
  double matrix[12];
  sideray_error error{};
  EXPECT_EQ(sideray_service_placement(service_->get(), 0, SIDERAY_JOB_MASKS, instances_[leg], matrix, &error),
            SIDERAY_INVALID_ARGUMENT);
  EXPECT_EQ(std::string(error.message).find("placement: the committed scene has no instance "), 0u) << error.message;
  EXPECT_EQ(sideray_service_placement(service_->get(), 0, SIDERAY_JOB_ALL, instances_[0], matrix, &error),
            SIDERAY_INVALID_ARGUMENT);
  EXPECT_EQ(sideray_service_placement(service_->get(), 0, SIDERAY_JOB_MASKS, instances_[0], nullptr, &error),
            SIDERAY_INVALID_ARGUMENT);
}

INSTANTIATE_TEST_SUITE_P(Views, MovingMasks,
                         testing::Values(Kind{"Perspective", GL_DEPTH24_STENCIL8, false},
                                         Kind{"Perspective16", GL_DEPTH_COMPONENT16, false},
                                         Kind{"Orthographic", GL_DEPTH_COMPONENT32F, true}),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace sideray::tests::moving_masks_test
