// The engine before the retrofit: OpenSceneGraph, fixed function, one sun, no shadows. One thread.
#pragma once

#include <osg/Group>
#include <osg/Image>
#include <osgViewer/Viewer>

#include <memory>
#include <string>

#include "offscreen.h"

struct EngineSettings {
  std::string scene;             // a file that OpenSceneGraph reads
  std::string context = "auto";  // "window", or as Offscreen has it
  int width = 640, height = 360;
  bool debug = false;  // a debug context, where the platform has them
};

class Engine {
 public:
  explicit Engine(const EngineSettings& settings);  // throws std::runtime_error
  ~Engine();

  osgViewer::Viewer& viewer() { return *viewer_; }
  osg::Group& scene() { return *scene_; }
  void look(const osg::Vec3d& eye, const osg::Vec3d& target, double fov_deg);
  // A frame is an update of the graph to its time, then a drawing.
  void update(double time_s);
  void draw();
  // Says whether draw() copies its picture for picture(): RGB, bottom row first.
  void keep_picture(bool keep);
  const osg::Image& picture() const;
  std::string renderer() const;  // OpenGL's name of itself; call it after the first frame

 private:
  int width_, height_;
  std::unique_ptr<Offscreen> offscreen_;  // outlives the viewer
  osg::ref_ptr<osgViewer::Viewer> viewer_;
  osg::ref_ptr<osg::Group> scene_;
  class Finish;
  osg::ref_ptr<Finish> finish_;
};
